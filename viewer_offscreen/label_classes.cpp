// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/label_classes.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <optional>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

struct Customary {
  const char* name;
  Rgb colour;
};

constexpr std::array kCustomary = {
    Customary{"ground", {146, 176, 96}},    Customary{"grass", {124, 172, 84}},
    Customary{"road", {108, 110, 118}},     Customary{"pavement", {196, 186, 172}},
    Customary{"sidewalk", {196, 186, 172}}, Customary{"house", {206, 108, 78}},
    Customary{"building", {206, 108, 78}},  Customary{"tree", {38, 118, 62}},
    Customary{"vegetation", {38, 118, 62}}, Customary{"car", {48, 104, 204}},
    Customary{"pole", {238, 196, 44}},      Customary{"fence", {150, 104, 160}},
    Customary{"floor", {168, 146, 120}},    Customary{"wall", {222, 212, 194}},
    Customary{"ceiling", {236, 238, 240}},  Customary{"table", {186, 124, 54}},
    Customary{"shelf", {118, 74, 148}},     Customary{"box", {232, 142, 48}},
    Customary{"chair", {46, 150, 160}},     Customary{"person", {220, 40, 60}},
};

Rgb colour_of(const std::string& name, std::uint16_t label) {
  for (const Customary& customary : kCustomary) {
    if (name == customary.name) return customary.colour;
  }
  return label_colour(label);
}

std::optional<std::uint16_t> parse_label(const std::string& text) {
  std::uint16_t label = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, label);
  if (parsed.ec != std::errc() || parsed.ptr != end) return std::nullopt;
  return label;
}

}  // namespace

LabelClasses read_label_classes(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw_input_error("{}: cannot be read", file.string());
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  LabelClasses classes;
  try {
    const YAML::Node root = YAML::Load(text);  // JSON is YAML
    if (!root.IsMap()) throw_input_error("{}: is not a JSON object of number: name", file.string());
    for (const auto& entry : root) {
      const auto key = entry.first.as<std::string>();
      const std::optional<std::uint16_t> label = parse_label(key);
      if (!label) throw_input_error("{}: key '{}' is not the number of a label", file.string(), key);
      const YAML::Node& value = entry.second;
      const auto name = value.IsMap() ? value["name"].as<std::string>() : value.as<std::string>();
      const bool has_colour = value.IsMap() && value["colour"];
      const Rgb colour =
          has_colour ? parse_colour(value["colour"].as<std::string>()) : colour_of(name, *label);
      classes[*label] = {name, colour};
    }
  } catch (const YAML::Exception& error) {
    throw_input_error("{}: {}", file.string(), error.what());
  }
  return classes;
}

LabelClass label_class(const LabelClasses& classes, std::uint16_t label) {
  const auto found = classes.find(label);
  return found != classes.end() ? found->second
                                : LabelClass{fmt::format("label {}", label), label_colour(label)};
}

}  // namespace covey::viewer
