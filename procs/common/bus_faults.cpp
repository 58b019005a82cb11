// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/bus_faults.h"

#include <sstream>

#include "core/base/error.h"

namespace covey {
namespace {

// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

std::uint64_t hash(const std::string& text) {
  std::uint64_t value = 0;
  for (const char c : text) value = mix(value ^ static_cast<unsigned char>(c));
  return value;
}

double number(const std::string& text, const std::string& key, double lowest, double highest) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (text.empty() || used != text.size() || !(value >= lowest && value <= highest)) {
    throw_input_error("--bus-faults: {}: '{}' is not a number in [{}, {}]", key, text, lowest, highest);
  }
  return value;
}

}  // namespace

BusFaults parse_bus_faults(const std::string& text) {
  BusFaults faults;
  std::stringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const auto equals = item.find('=');
    const std::string key = item.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : item.substr(equals + 1);
    if (key == "drop") {
      faults.drop = number(value, key, 0.0, 1.0);
    } else if (key == "duplicate") {
      faults.duplicate = number(value, key, 0.0, 1.0);
    } else if (key == "delay_ms") {
      faults.delay_ms = number(value, key, 0.0, 60'000.0);
    } else if (key == "seed") {
      faults.seed = static_cast<std::uint64_t>(number(value, key, 0.0, 1e15));
    } else {
      throw_input_error("--bus-faults: unknown key '{}'; known: drop, duplicate, delay_ms, seed", key);
    }
  }
  return faults;
}

std::vector<Utime> FaultInjector::next(const std::string& channel) {
  std::uint64_t state = mix(faults_.seed) ^ hash(channel) ^ mix(messages_[channel]++);
  const auto uniform = [&state] {
    state = mix(state);
    return static_cast<double>(state >> 11) * 0x1p-53;
  };
  std::vector<Utime> delays;
  if (uniform() < faults_.drop) return delays;
  const int copies = uniform() < faults_.duplicate ? 2 : 1;
  for (int copy = 0; copy < copies; ++copy) {
    delays.push_back(static_cast<Utime>(uniform() * faults_.delay_ms * 1000.0));
  }
  return delays;
}

}  // namespace covey
