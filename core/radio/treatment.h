// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How the radio treats a channel: which module pays for it, whether it must arrive, and what goes first.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

namespace covey::radio {

// Numbers as in radio_fragment_t.module.
enum class Module : std::int8_t {
  kControl = 0,  // acknowledgements and signs of life; always goes first
  kPlaceRecognition = 1,
  kGeometricVerification = 2,
  kDpgo = 3,
};
inline constexpr std::size_t kModules = 4;
inline constexpr std::array<const char*, kModules> kModuleNames = {"control", "place_recognition",
                                                                   "geometric_verification", "dpgo"};

constexpr std::size_t index_of(Module module) { return static_cast<std::size_t>(module); }
constexpr const char* name_of(Module module) { return kModuleNames[index_of(module)]; }

struct Treatment {
  Module module = Module::kControl;
  bool reliable = false;  // acknowledged and repeated until it arrives; larger than a datagram always is
  int priority = 0;       // within a module, higher goes first
  std::int64_t fingerprint = 0;  // of the channel's type: another one is refused
};

// What may cross the radio, by bare channel name.
using TreatmentTable = std::map<std::string, Treatment, std::less<>>;

}  // namespace covey::radio
