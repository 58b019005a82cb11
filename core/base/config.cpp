// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/config.h"

#include <fmt/ranges.h>

#include <ios>
#include <utility>

namespace covey {

ConfigSection::ConfigSection(const YAML::Node& node, std::string file, std::string path)
    : node_(node), file_(std::move(file)), path_(std::move(path)) {
  if (node_ && !node_.IsNull() && !node_.IsMap()) {
    throw_input_error("{}: expected a map of keys{}", place(node_),
                      path_.empty() ? "" : " under '" + path_ + "'");
  }
}

std::string ConfigSection::place(const YAML::Node& node) const {
  if (!node || node.Mark().is_null()) return file_;
  return fmt::format("{}:{}", file_, node.Mark().line + 1);
}

YAML::Node ConfigSection::find(const std::string& key) {
  known_.insert(key);
  if (!has(key)) return YAML::Node(YAML::NodeType::Undefined);
  return node_[key];
}

bool ConfigSection::has(const std::string& key) const {
  return node_ && node_.IsMap() && static_cast<bool>(std::as_const(node_)[key]);
}

std::string ConfigSection::where(const std::string& key) const {
  const std::string full = path_.empty() ? key : path_ + "." + key;
  return fmt::format("{}: key '{}'", has(key) ? place(std::as_const(node_)[key]) : file_, full);
}

ConfigSection& ConfigSection::section(const std::string& key) {
  auto& children = children_[key];
  if (children.empty()) {
    const YAML::Node node = find(key);
    children.push_back(std::make_unique<ConfigSection>(node ? node : YAML::Node(YAML::NodeType::Null), file_,
                                                       path_.empty() ? key : path_ + "." + key));
  }
  return *children.front();
}

std::vector<ConfigSection*> ConfigSection::list(const std::string& key) {
  auto& children = children_[key];
  const YAML::Node node = find(key);
  if (children.empty() && node) {
    if (!node.IsSequence()) throw_input_error("{}: expected a list", where(key));
    for (std::size_t i = 0; i < node.size(); ++i) {
      const std::string path = fmt::format("{}{}[{}]", path_.empty() ? "" : path_ + ".", key, i);
      children.push_back(std::make_unique<ConfigSection>(node[i], file_, path));
    }
  }
  std::vector<ConfigSection*> sections;
  for (auto& child : children) sections.push_back(child.get());
  return sections;
}

void ConfigSection::check_all_read() const {
  if (node_ && node_.IsMap()) {
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) throw_input_error("{}: a key must be a word", place(entry.first));
      const auto key = entry.first.as<std::string>();
      if (known_.count(key) == 0) {
        const std::string full = path_.empty() ? key : path_ + "." + key;
        throw_input_error("{}: unknown key '{}'; known here: {}", place(entry.first), full,
                          fmt::join(known_, ", "));
      }
    }
  }
  for (const auto& [key, children] : children_) {
    for (const auto& child : children) child->check_all_read();
  }
}

Config Config::load(const std::filesystem::path& file) {
  try {
    return Config(std::make_unique<ConfigSection>(YAML::LoadFile(file.string()), file.string(), ""));
  } catch (const YAML::BadFile&) {
    throw_input_error("{}: cannot be read; does the file exist?", file.string());
  } catch (const std::ios_base::failure&) {  // what a folder gives
    throw_input_error("{}: cannot be read; is it a file?", file.string());
  } catch (const YAML::ParserException& error) {
    throw_input_error("{}:{}:{}: not YAML: {}", file.string(), error.mark.line + 1, error.mark.column + 1,
                      error.msg);
  }
}

Config Config::parse(const std::string& text, const std::string& name) {
  try {
    return Config(std::make_unique<ConfigSection>(YAML::Load(text), name, ""));
  } catch (const YAML::ParserException& error) {
    throw_input_error("{}:{}:{}: not YAML: {}", name, error.mark.line + 1, error.mark.column + 1, error.msg);
  }
}

}  // namespace covey
