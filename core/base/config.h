// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// YAML -> options structs. A struct's defaults are the configuration; a file only overrides them, key by key,
// and every key of the file must be one that is read: an unknown key is an error that names file, line, key
// and the known keys.
//
//   struct LinkOptions { double loss = 0.0; int delay_ms = 0; };
//   LinkOptions read_link(ConfigSection& section) {
//     LinkOptions options;
//     section.read("loss", options.loss, 0.0, 1.0);      // refuses values outside the range, in words
//     section.read("delay_ms", options.delay_ms, 0, 60000);
//     return options;
//   }
//   Config config = Config::load("radio.yaml");
//   auto options = read_link(config.root());
//   config.check_all_read();                              // throws InputError on a key that nobody asked for
//
// All errors are InputError.

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace covey {

class ConfigSection {
 public:
  ConfigSection(const YAML::Node& node, std::string file, std::string path);

  // Overwrites `value` where the file has the key; leaves the default where it has not.
  template <typename T>
  void read(const std::string& key, T& value);
  template <typename T>
  void read(const std::string& key, T& value, T lowest, T highest);

  // A nested map; empty where the file has not the key.
  ConfigSection& section(const std::string& key);
  // A list of maps; empty where the file has not the key.
  std::vector<ConfigSection*> list(const std::string& key);

  bool has(const std::string& key) const;
  // "file.yaml:12: key 'link.loss'", for messages about a value.
  std::string where(const std::string& key) const;
  void check_all_read() const;

 private:
  YAML::Node find(const std::string& key);
  std::string place(const YAML::Node& node) const;

  YAML::Node node_;
  std::string file_;
  std::string path_;
  std::set<std::string> known_;
  std::map<std::string, std::vector<std::unique_ptr<ConfigSection>>> children_;
};

class Config {
 public:
  static Config load(const std::filesystem::path& file);
  static Config parse(const std::string& text, const std::string& name);

  ConfigSection& root() { return *root_; }
  void check_all_read() const { root_->check_all_read(); }

 private:
  explicit Config(std::unique_ptr<ConfigSection> root) : root_(std::move(root)) {}
  std::unique_ptr<ConfigSection> root_;
};

template <typename T>
void ConfigSection::read(const std::string& key, T& value) {
  const YAML::Node node = find(key);
  if (!node) return;
  try {
    value = node.as<T>();
  } catch (const YAML::Exception&) {
    throw_input_error("{}: '{}' is not a value of the right kind", where(key), YAML::Dump(node));
  }
}

template <typename T>
void ConfigSection::read(const std::string& key, T& value, T lowest, T highest) {
  T candidate = value;
  read(key, candidate);
  if (!(candidate >= lowest && candidate <= highest)) {
    throw_input_error("{}: {} is outside [{}, {}]", where(key), candidate, lowest, highest);
  }
  value = candidate;
}

}  // namespace covey
