// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

static_assert(std::endian::native == std::endian::little, "binary values are copied as they stand");

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> count_type;  // set for a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

std::optional<Type> type_named(std::string_view name) {
  if (name == "char" || name == "int8") return Type::kInt8;
  if (name == "uchar" || name == "uint8") return Type::kUint8;
  if (name == "short" || name == "int16") return Type::kInt16;
  if (name == "ushort" || name == "uint16") return Type::kUint16;
  if (name == "int" || name == "int32") return Type::kInt32;
  if (name == "uint" || name == "uint32") return Type::kUint32;
  if (name == "float" || name == "float32") return Type::kFloat;
  if (name == "double" || name == "float64") return Type::kDouble;
  return std::nullopt;
}

std::string_view next_word(std::string_view& rest) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = std::min(rest.find_first_not_of(kBlank), rest.size());
  const std::size_t last = std::min(rest.find_first_of(kBlank, first), rest.size());
  const std::string_view word = rest.substr(first, last - first);
  rest.remove_prefix(last);
  return word;
}

// The file's bytes with a cursor; knows how to say where it stands.
class Cursor {
 public:
  Cursor(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  template <typename... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
    const std::string place =
        in_lines_ ? fmt::format("{}:{}", name_, line_) : fmt::format("{}: byte {}", name_, at_);
    throw_input_error("{}: {}", place, fmt::format(format, std::forward<Args>(args)...));
  }

  std::string_view next_line() {
    ++line_;
    if (at_ >= bytes_.size()) fail("the file ends early");
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view line = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    return line;
  }

  template <typename T>
  T next_binary() {
    T value;
    if (bytes_.size() - at_ < sizeof(T)) fail("the file ends early");
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }

  void count_bytes() { in_lines_ = false; }
  std::string_view rest() const { return bytes_.substr(at_); }

 private:
  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
  bool in_lines_ = true;
};

// One element's values, each handed out as a double (exact for every type of the format).
class Values {
 public:
  Values(Cursor& cursor, bool ascii) : cursor_(cursor), ascii_(ascii) {}

  void begin_element() {
    if (ascii_) line_ = cursor_.next_line();
  }

  double next(const Property& property, Type type) {
    if (!ascii_) return next_binary(type);
    const std::string_view word = next_word(line_);
    if (word.empty()) cursor_.fail("property '{}' is missing", property.name);
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      cursor_.fail("property '{}': '{}' is not a number", property.name, word);
    }
    return value;
  }

  void end_element() {
    if (ascii_ && !next_word(line_).empty()) cursor_.fail("more values than the header has properties");
  }

 private:
  double next_binary(Type type) {
    switch (type) {
      case Type::kInt8:
        return cursor_.next_binary<std::int8_t>();
      case Type::kUint8:
        return cursor_.next_binary<std::uint8_t>();
      case Type::kInt16:
        return cursor_.next_binary<std::int16_t>();
      case Type::kUint16:
        return cursor_.next_binary<std::uint16_t>();
      case Type::kInt32:
        return cursor_.next_binary<std::int32_t>();
      case Type::kUint32:
        return cursor_.next_binary<std::uint32_t>();
      case Type::kFloat:
        return cursor_.next_binary<float>();
      case Type::kDouble:
        return cursor_.next_binary<double>();
    }
    return 0.0;
  }

  Cursor& cursor_;
  bool ascii_;
  std::string_view line_;
};

struct Header {
  bool ascii = false;
  std::vector<Element> elements;
};

Property read_property(Cursor& cursor, std::string_view rest) {
  const auto read_type = [&cursor](std::string_view word) {
    const std::optional<Type> type = type_named(word);
    if (!type) cursor.fail("'{}' is not a PLY number type", word);
    return *type;
  };
  Property property;
  std::string_view word = next_word(rest);
  if (word == "list") {
    property.count_type = read_type(next_word(rest));
    if (*property.count_type >= Type::kFloat) cursor.fail("a list's length must be an integer");
    word = next_word(rest);
  }
  property.type = read_type(word);
  property.name = next_word(rest);
  if (property.name.empty()) cursor.fail("a property without a name");
  return property;
}

Element read_element(Cursor& cursor, std::string_view rest) {
  Element element;
  element.name = next_word(rest);
  const std::string_view count = next_word(rest);
  const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (count.empty() || error != std::errc() || end != count.data() + count.size()) {
    cursor.fail("element '{}': '{}' is not a count", element.name, count);
  }
  return element;
}

Header read_header(Cursor& cursor) {
  std::string_view line = cursor.next_line();
  if (next_word(line) != "ply") cursor.fail("not a PLY file (its first line is not 'ply')");
  Header header;
  bool has_format = false;
  while (true) {
    line = cursor.next_line();
    const std::string_view word = next_word(line);
    if (word == "end_header") break;
    if (word.empty() || word == "comment" || word == "obj_info") continue;
    if (word == "format") {
      const std::string_view format = next_word(line);
      header.ascii = format == "ascii";
      has_format = header.ascii || format == "binary_little_endian";
      if (!has_format) cursor.fail("format '{}' is not ascii or binary_little_endian", format);
    } else if (word == "element") {
      header.elements.push_back(read_element(cursor, line));
    } else if (word == "property") {
      if (header.elements.empty()) cursor.fail("a property before the first element");
      header.elements.back().properties.push_back(read_property(cursor, line));
    } else {
      cursor.fail("'{}' is not a PLY header keyword", word);
    }
  }
  if (!has_format) cursor.fail("the header has no format line");
  return header;
}

// A file cannot have more elements than bytes: a forged count must not take all memory.
std::size_t plausible(const Cursor& cursor, const Element& element) {
  if (element.count > cursor.rest().size()) {
    cursor.fail("a count of {} for element '{}' cannot stand in {} bytes", element.count, element.name,
                cursor.rest().size());
  }
  return element.count;
}

void read_over(Values& values, const Property& property) {
  const double count = property.count_type ? values.next(property, *property.count_type) : 1.0;
  for (double i = 0.0; i < count; ++i) values.next(property, property.type);
}

double read_integer(const Cursor& cursor, Values& values, const Property& property, Type type,
                    double highest) {
  const double value = values.next(property, type);
  if (!(value >= 0.0 && value <= highest) || value != std::floor(value)) {
    cursor.fail("property '{}': {} is not an integer in [0, {}]", property.name, value, highest);
  }
  return value;
}

enum class Role { kX, kY, kZ, kRed, kGreen, kBlue, kLabel, kOther };

std::vector<Role> vertex_roles(const Cursor& cursor, const Element& element) {
  constexpr std::array<std::string_view, 7> kNames = {"x", "y", "z", "red", "green", "blue", "label"};
  std::vector<Role> roles;
  std::array<bool, 8> present = {};
  for (const Property& property : element.properties) {
    std::size_t role = 0;
    while (role < kNames.size() && (property.name != kNames[role] || property.count_type)) ++role;
    const bool colour = role >= 3 && role <= 5;
    if (colour && property.type != Type::kUint8) cursor.fail("property '{}' must be uchar", property.name);
    present[role] = true;
    roles.push_back(static_cast<Role>(role));
  }
  if (!present[0] || !present[1] || !present[2]) cursor.fail("element 'vertex' lacks x, y or z");
  if (present[3] != present[4] || present[4] != present[5])
    cursor.fail("of red, green and blue one is missing");
  return roles;
}

bool contains(const std::vector<Role>& roles, Role role) {
  return std::find(roles.begin(), roles.end(), role) != roles.end();
}

void read_vertices(Cursor& cursor, Values& values, const Element& element, Mesh& mesh) {
  const std::vector<Role> roles = vertex_roles(cursor, element);
  const std::size_t count = plausible(cursor, element);
  mesh.vertices.resize(count);
  mesh.colours.resize(contains(roles, Role::kRed) ? count : 0);
  mesh.labels.resize(contains(roles, Role::kLabel) ? count : 0);
  for (std::size_t i = 0; i < count; ++i) {
    values.begin_element();
    for (std::size_t j = 0; j < roles.size(); ++j) {
      const Property& property = element.properties[j];
      const auto byte = [&] {
        return static_cast<std::uint8_t>(read_integer(cursor, values, property, property.type, 255));
      };
      switch (roles[j]) {
        case Role::kX:
          mesh.vertices[i].x() = static_cast<float>(values.next(property, property.type));
          break;
        case Role::kY:
          mesh.vertices[i].y() = static_cast<float>(values.next(property, property.type));
          break;
        case Role::kZ:
          mesh.vertices[i].z() = static_cast<float>(values.next(property, property.type));
          break;
        case Role::kRed:
          mesh.colours[i].r = byte();
          break;
        case Role::kGreen:
          mesh.colours[i].g = byte();
          break;
        case Role::kBlue:
          mesh.colours[i].b = byte();
          break;
        case Role::kLabel:
          mesh.labels[i] =
              static_cast<std::uint16_t>(read_integer(cursor, values, property, property.type, kNoLabel));
          break;
        case Role::kOther:
          read_over(values, property);
          break;
      }
    }
    if (!mesh.vertices[i].allFinite()) cursor.fail("vertex {} is not finite", i);
    values.end_element();
  }
}

void read_polygon(const Cursor& cursor, Values& values, const Property& property, Mesh& mesh) {
  const auto count =
      static_cast<std::size_t>(read_integer(cursor, values, property, *property.count_type, 1e9));
  if (count < 3) cursor.fail("a face of {} corners", count);
  const double highest = static_cast<double>(mesh.vertices.size()) - 1.0;
  const auto corner = [&] {
    return static_cast<std::uint32_t>(read_integer(cursor, values, property, property.type, highest));
  };
  const std::uint32_t first = corner();
  std::uint32_t previous = corner();
  for (std::size_t i = 2; i < count; ++i) {
    const std::uint32_t next = corner();
    mesh.faces.push_back({first, previous, next});
    previous = next;
  }
}

void read_faces(Cursor& cursor, Values& values, const Element& element, Mesh& mesh) {
  const auto is_corners = [](const Property& property) {
    return property.count_type && (property.name == "vertex_indices" || property.name == "vertex_index");
  };
  mesh.faces.reserve(plausible(cursor, element));
  for (std::size_t i = 0; i < element.count; ++i) {
    values.begin_element();
    for (const Property& property : element.properties) {
      if (is_corners(property)) {
        read_polygon(cursor, values, property, mesh);
      } else {
        read_over(values, property);
      }
    }
    values.end_element();
  }
}

template <typename T>
void append_binary(std::string& out, T value) {
  std::array<char, sizeof(T)> bytes = {};
  std::memcpy(bytes.data(), &value, sizeof(T));
  out.append(bytes.data(), bytes.size());
}

std::string format_header(const Mesh& mesh, PlyFormat format) {
  std::string out =
      fmt::format("ply\nformat {} 1.0\nelement vertex {}\n",
                  format == PlyFormat::kAscii ? "ascii" : "binary_little_endian", mesh.vertices.size());
  out += "property float x\nproperty float y\nproperty float z\n";
  if (!mesh.colours.empty()) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  if (!mesh.labels.empty()) out += "property ushort label\n";
  out +=
      fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.faces.size());
  return out;
}

void append_ascii_body(const Mesh& mesh, std::string& out) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3f& p = mesh.vertices[i];
    out +=
        fmt::format("{} {} {}", p.x(), p.y(), p.z());  // the shortest text that reads back as the same float
    if (!mesh.colours.empty())
      out += fmt::format(" {} {} {}", mesh.colours[i].r, mesh.colours[i].g, mesh.colours[i].b);
    if (!mesh.labels.empty()) out += fmt::format(" {}", mesh.labels[i]);
    out += '\n';
  }
  for (const auto& [a, b, c] : mesh.faces) out += fmt::format("3 {} {} {}\n", a, b, c);
}

void append_binary_body(const Mesh& mesh, std::string& out) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    for (const float coordinate : mesh.vertices[i]) append_binary(out, coordinate);
    if (!mesh.colours.empty()) append_binary(out, mesh.colours[i]);
    if (!mesh.labels.empty()) append_binary(out, mesh.labels[i]);
  }
  for (const auto& face : mesh.faces) {
    append_binary(out, std::uint8_t{3});
    for (const std::uint32_t corner : face) append_binary(out, static_cast<std::int32_t>(corner));
  }
}

}  // namespace

Mesh parse_ply(std::string_view bytes, const std::string& name) {
  Cursor cursor(bytes, name);
  const Header header = read_header(cursor);
  if (!header.ascii) cursor.count_bytes();
  Values values(cursor, header.ascii);
  Mesh mesh;
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      read_vertices(cursor, values, element, mesh);
      has_vertices = true;
    } else if (element.name == "face") {
      if (!has_vertices) cursor.fail("element 'face' stands before 'vertex'");
      read_faces(cursor, values, element, mesh);
    } else {
      for (std::size_t i = 0; i < element.count; ++i) {
        values.begin_element();
        for (const Property& property : element.properties) read_over(values, property);
        values.end_element();
      }
    }
  }
  if (!has_vertices) cursor.fail("no element 'vertex'");
  const bool spent = header.ascii ? cursor.rest().find_first_not_of(" \t\r\n") == std::string_view::npos
                                  : cursor.rest().empty();
  if (!spent) cursor.fail("the file goes on after its last element");
  return mesh;
}

Mesh read_ply(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw_input_error("{}: cannot be opened", file.string());
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  return parse_ply(bytes, file.string());
}

std::string format_ply(const Mesh& mesh, PlyFormat format) {
  COVEY_CHECK(mesh.colours.empty() || mesh.colours.size() == mesh.vertices.size());
  COVEY_CHECK(mesh.labels.empty() || mesh.labels.size() == mesh.vertices.size());
  std::string out = format_header(mesh, format);
  format == PlyFormat::kAscii ? append_ascii_body(mesh, out) : append_binary_body(mesh, out);
  return out;
}

void write_ply(const std::filesystem::path& file, const Mesh& mesh, PlyFormat format) {
  std::ofstream out(file, std::ios::binary);
  out << format_ply(mesh, format);
  out.close();
  if (!out) throw_input_error("{}: cannot be written; is its folder there and writable?", file.string());
}

}  // namespace covey::viewer
