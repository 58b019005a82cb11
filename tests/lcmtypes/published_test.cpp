// SPDX-License-Identifier: BSD-3-Clause
// A published type never changes: peers and logs would stop to understand it. lcmtypes/published.txt holds every type's
// fingerprint as lcm-gen computes it from the names, types and dimensions of the fields.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>

#include "headers.inc"

namespace {

using Fingerprints = std::map<std::string, std::string>;

Fingerprints current() {
  const std::map<std::string, std::int64_t> hashes{
#include "fingerprints.inc"
  };
  Fingerprints fingerprints;
  for (const auto& [type, hash] : hashes) {
    fingerprints[type] = fmt::format("0x{:016x}", static_cast<std::uint64_t>(hash));
  }
  return fingerprints;
}

Fingerprints published() {
  Fingerprints fingerprints;
  std::ifstream file(COVEY_SOURCE_DIR "/lcmtypes/published.txt");
  std::string type;
  std::string fingerprint;
  while (file >> type >> fingerprint) fingerprints[type] = fingerprint;
  return fingerprints;
}

TEST_CASE("Every type is published, and no published type has changed") {
  const Fingerprints now = current();
  const Fingerprints before = published();
  for (const auto& [type, fingerprint] : now) {
    const auto known = before.find(type);
    if (known == before.end()) {
      FAIL_CHECK("a new type: add this line to lcmtypes/published.txt: " << type << ' ' << fingerprint);
    } else if (known->second != fingerprint) {
      FAIL_CHECK(
          type << " is published and its fields have changed, so that no peer and no log of before can be "
                  "understood; take the change back and make a new type beside it");
    }
  }
  for (const auto& [type, fingerprint] : before) {
    if (now.count(type) == 0) FAIL_CHECK(type << " is published and its .lcm file is gone; bring it back");
  }
}

// lcm-gen leaves the type's own name out of the fingerprint: two types with the same fields decode as each other.
TEST_CASE("No two types can be taken for each other") {
  std::map<std::string, std::string> type_of;
  for (const auto& [type, fingerprint] : current()) {
    INFO(type << " has the same fields as " << type_of[fingerprint]);
    CHECK(type_of[fingerprint].empty());
    type_of[fingerprint] = type;
  }
}

}  // namespace
