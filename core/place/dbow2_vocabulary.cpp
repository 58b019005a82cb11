// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/dbow2_vocabulary.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/pgo/fields.h"

namespace covey::place {
namespace {

using pgo::FieldReader;

constexpr int kMostNodes = 10'000'000;
constexpr int kMostChildren = std::numeric_limits<std::uint8_t>::max();
constexpr int kMostLevels = 10;
constexpr double kMostWeight = 1e5;
constexpr std::size_t kMostItem = 1000;  // letters
constexpr int kTextFields = 2 + static_cast<int>(kDescriptorBytes) + 1;

struct ReadNode {
  int id = 0;
  int parent = 0;
  Descriptor centre{};
  double weight = 0.0;
  bool is_word = false;
  int line = 0;
};

template <typename Number>
Number parse(std::string_view text, const char* what, Number lowest, Number highest, const FieldReader& at) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= lowest && value <= highest))
    at.refuse("{} is '{}' and should be a number of {} to {}", what, text, lowest, highest);
  return value;
}

std::uint8_t parse_byte(std::string_view text, const FieldReader& at) {
  return static_cast<std::uint8_t>(parse<int>(text, "a descriptor's byte", 0, 255, at));
}

void check_head(int k, int levels, const FieldReader& at) {
  if (k < 2 || k > kMostChildren)
    at.refuse("k, the children of a node, is {}: 2 to {} are possible", k, kMostChildren);
  if (levels < 1 || levels > kMostLevels)
    at.refuse("L, the levels of the tree, is {}: 1 to {} are possible", levels, kMostLevels);
}

std::vector<ReadNode> read_text(FieldReader& reader) {
  if (reader.size() != 4) {
    reader.refuse(
        "neither a DBoW2 vocabulary as text, which begins with four numbers (k L scoring weighting), nor "
        "one of OpenCV's YAML files");
  }
  constexpr int kMost = std::numeric_limits<int>::max();
  check_head(parse<int>(reader[0], "k", 0, kMost, reader), parse<int>(reader[1], "L", 0, kMost, reader),
             reader);
  parse<int>(reader[2], "the scoring", 0, 5, reader);
  parse<int>(reader[3], "the weighting", 0, 3, reader);
  std::vector<ReadNode> nodes;
  while (reader.next()) {
    if (reader.size() != kTextFields) {
      reader.refuse("a node has {} numbers: parent, 1 for a word, 32 bytes, weight; here are {}", kTextFields,
                    reader.size());
    }
    if (nodes.size() == kMostNodes) reader.refuse("more than {} nodes", kMostNodes);
    ReadNode node;
    node.id = static_cast<int>(nodes.size()) + 1;
    node.parent = parse<int>(reader[0], "the parent", 0, kMostNodes, reader);
    node.is_word = parse<int>(reader[1], "whether it is a word", 0, 1, reader) == 1;
    std::array<std::uint8_t, kDescriptorBytes> bytes{};
    for (std::size_t k = 0; k < bytes.size(); ++k)
      bytes[k] = parse_byte(reader[2 + static_cast<int>(k)], reader);
    node.centre = descriptor_from(bytes.data());
    node.weight = parse<double>(reader[kTextFields - 1], "the weight", 0.0, kMostWeight, reader);
    node.line = reader.line();
    nodes.push_back(node);
  }
  return nodes;
}

// The words of a YAML file, whatever lines they stand on.
class Tokens {
 public:
  explicit Tokens(FieldReader& reader) : reader_(reader) {}

  // Empty at the end.
  std::string_view next() {
    while (field_ == reader_.size()) {
      if (!reader_.next()) return {};
      field_ = 0;
    }
    return reader_[field_++];
  }

  // Of "{ key:value, key:value }", with one blank between words, what is between the braces.
  std::string next_item() {
    std::string item(next());
    while (!item.ends_with('}')) {
      const std::string_view token = next();
      if (token.empty()) reader_.refuse("the file ends within an entry");
      item.append(" ").append(token);
      if (item.size() > kMostItem) reader_.refuse("an entry is longer than {} letters", kMostItem);
    }
    if (!item.starts_with('{'))
      reader_.refuse("an entry should begin with '{{', not with '{}'", item.substr(0, 20));
    return item.substr(1, item.size() - 2);
  }

 private:
  FieldReader& reader_;
  int field_ = 0;
};

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

// The next value of an entry, which must be of this key; it and the comma after it are taken away.
std::string_view take(std::string_view& item, std::string_view key, const FieldReader& at) {
  item = trimmed(item);
  if (!item.starts_with(key) || !item.substr(key.size()).starts_with(':'))
    at.refuse("an entry should go on with '{}:', not with '{}'", key, item.substr(0, 20));
  item.remove_prefix(key.size() + 1);
  const std::size_t comma = std::min(item.find(','), item.size());
  const std::string_view value = trimmed(item.substr(0, comma));
  item.remove_prefix(std::min(comma + 1, item.size()));
  return value;
}

Descriptor parse_descriptor(std::string_view text, const FieldReader& at) {
  if (text.size() < 2 || !text.starts_with('"') || !text.ends_with('"'))
    at.refuse("a descriptor should stand in quotes");
  text = trimmed(text.substr(1, text.size() - 2));
  std::array<std::uint8_t, kDescriptorBytes> bytes{};
  std::size_t n = 0;
  while (!text.empty()) {
    const std::size_t blank = std::min(text.find(' '), text.size());
    if (n == bytes.size()) at.refuse("a descriptor has more than {} bytes", bytes.size());
    bytes[n++] = parse_byte(text.substr(0, blank), at);
    text = trimmed(text.substr(blank));
  }
  if (n != bytes.size()) at.refuse("a descriptor has {} bytes instead of {}", n, bytes.size());
  return descriptor_from(bytes.data());
}

ReadNode parse_node(std::string_view item, const FieldReader& at) {
  ReadNode node;
  node.id = parse<int>(take(item, "nodeId", at), "nodeId", 1, kMostNodes, at);
  node.parent = parse<int>(take(item, "parentId", at), "parentId", 0, kMostNodes, at);
  node.weight = parse<double>(take(item, "weight", at), "the weight", 0.0, kMostWeight, at);
  node.centre = parse_descriptor(take(item, "descriptor", at), at);
  node.line = at.line();
  if (!trimmed(item).empty()) at.refuse("a node has more than nodeId, parentId, weight and descriptor");
  return node;
}

// Which of the nodes has this id; they usually stand in order.
ReadNode* find_node(std::vector<ReadNode>& nodes, const std::vector<int>& by_id, int id) {
  if (id < 1 || id >= static_cast<int>(by_id.size()) || by_id[static_cast<std::size_t>(id)] < 0)
    return nullptr;
  return &nodes[static_cast<std::size_t>(by_id[static_cast<std::size_t>(id)])];
}

// Where each id stands, -1: nowhere. As many ids as nodes, so that each stands once.
std::vector<int> index_of(const std::vector<ReadNode>& nodes, const std::filesystem::path& file) {
  std::vector<int> by_id(nodes.size() + 1, -1);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const ReadNode& node = nodes[k];
    if (node.id > static_cast<int>(nodes.size()))
      throw_input_error("{}:{}: node {} of only {} nodes", file.string(), node.line, node.id, nodes.size());
    int& place = by_id[static_cast<std::size_t>(node.id)];
    if (place >= 0) throw_input_error("{}:{}: a second node {}", file.string(), node.line, node.id);
    place = static_cast<int>(k);
  }
  return by_id;
}

std::vector<ReadNode> read_yaml(FieldReader& reader, const std::filesystem::path& file) {
  Tokens tokens(reader);
  std::string_view first = tokens.next();
  while (first.starts_with('%') || first == "---") first = tokens.next();
  if (first != "vocabulary:") reader.refuse("'vocabulary:' should stand here");
  int k = 0;
  int levels = 0;
  std::vector<ReadNode> nodes;
  std::vector<int> by_id;
  bool in_nodes = false;
  bool in_words = false;
  for (std::string_view token = tokens.next(); !token.empty(); token = tokens.next()) {
    if (token == "k:" || token == "L:") {
      (token == "k:" ? k : levels) = parse<int>(tokens.next(), token == "k:" ? "k" : "L", 0, 1000, reader);
    } else if (token == "scoringType:" || token == "weightingType:") {
      tokens.next();
    } else if (token == "nodes:" && !in_nodes) {
      check_head(k, levels, reader);
      in_nodes = true;
    } else if (token == "words:" && in_nodes && !in_words) {
      by_id = index_of(nodes, file);
      in_words = true;
    } else if (token == "-" && in_words) {
      const std::string item = tokens.next_item();
      std::string_view rest = item;
      parse<int>(take(rest, "wordId", reader), "wordId", 0, kMostNodes, reader);
      const int id = parse<int>(take(rest, "nodeId", reader), "nodeId", 1, kMostNodes, reader);
      ReadNode* node = find_node(nodes, by_id, id);
      if (node == nullptr) reader.refuse("a word of node {}, which there is none of", id);
      if (std::exchange(node->is_word, true)) reader.refuse("a second word of node {}", id);
    } else if (token == "-" && in_nodes) {
      if (nodes.size() == kMostNodes) reader.refuse("more than {} nodes", kMostNodes);
      nodes.push_back(parse_node(tokens.next_item(), reader));
    } else {
      reader.refuse("'{}' is not expected here", token.substr(0, 20));
    }
  }
  if (!in_words) reader.refuse("the file ends before its words");
  return nodes;
}

// Breadth first, as Vocabulary wants them.
Vocabulary build(const std::vector<ReadNode>& nodes, const std::filesystem::path& file) {
  const auto refuse = [&file](const ReadNode& node, const std::string& why) {
    throw_input_error("{}:{}: node {} {}", file.string(), node.line, node.id, why);
  };
  if (nodes.empty()) throw_input_error("{}: a vocabulary without nodes", file.string());
  const std::vector<int> by_id = index_of(nodes, file);
  std::vector<std::vector<int>> children(nodes.size() + 1);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const ReadNode& node = nodes[k];
    if (node.parent >= static_cast<int>(children.size()))
      refuse(node, fmt::format("has no parent {}", node.parent));
    auto& siblings = children[static_cast<std::size_t>(node.parent)];
    if (siblings.size() == kMostChildren)
      refuse(node,
             fmt::format("is one child too many of node {}: {} are possible", node.parent, kMostChildren));
    siblings.push_back(static_cast<int>(k));
  }
  std::vector<int> order;  // places in `nodes`
  std::vector<Vocabulary::Node> tree(1);
  const auto append = [&](const std::vector<int>& places) {
    for (const int place : places) {
      const ReadNode& node = nodes[static_cast<std::size_t>(place)];
      order.push_back(place);
      tree.push_back({node.centre, 0, node.is_word ? static_cast<float>(node.weight) : 0.0F});
    }
    return static_cast<std::uint8_t>(places.size());
  };
  tree[0].children = append(children[0]);
  double heaviest = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const ReadNode& node = nodes[static_cast<std::size_t>(order[k])];
    const auto& own = children[static_cast<std::size_t>(node.id)];
    if (node.is_word && !own.empty()) refuse(node, "is a word and has children");
    if (!node.is_word && own.empty()) refuse(node, "is no word and has no children");
    const std::uint8_t n = append(own);
    tree[k + 1].children = n;
    heaviest = std::max(heaviest, node.is_word ? node.weight : 0.0);
  }
  if (order.size() < nodes.size()) {
    std::vector<bool> reached(nodes.size(), false);
    for (const int place : order) reached[static_cast<std::size_t>(place)] = true;
    const auto lost =
        static_cast<std::size_t>(std::find(reached.begin(), reached.end(), false) - reached.begin());
    refuse(nodes[lost], "does not hang on the root");
  }
  if (!(heaviest > 0.0)) throw_input_error("{}: no word of this vocabulary has a weight", file.string());
  return Vocabulary(std::move(tree));
}

}  // namespace

Vocabulary read_dbow2(const std::filesystem::path& file) {
  FieldReader reader(file, ' ');
  if (!reader.next()) throw_input_error("{}: the file is empty", file.string());
  const bool is_yaml = reader[0].starts_with('%') || reader[0] == "vocabulary:" || reader[0] == "---";
  return build(is_yaml ? read_yaml(reader, file) : read_text(reader), file);
}

}  // namespace covey::place
