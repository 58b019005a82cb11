// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/lcd_log.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey {
namespace {

std::vector<place::LcdRecord> some_records() {
  lcd_bag_t own{};
  own.from = 3;
  own.id = 1;
  lcd_bag_t of_another{};
  of_another.from = 4;
  of_another.id = 2;
  lcd_frame_t features{};
  features.from = 3;
  features.id = 1;
  loop_t loop{};
  loop.stream = 9;
  lcd_loop_t answer{};
  answer.from = 4;
  return {own, features, of_another, loop, answer};
}

std::vector<Bytes> encoded(const std::vector<place::LcdRecord>& records) {
  std::vector<Bytes> bytes;
  for (const auto& record : records) {
    bytes.push_back(std::visit([](const auto& message) { return encode(message); }, record));
  }
  return bytes;
}

std::vector<place::LcdRecord> read_back(const ScratchFolder& folder, std::unique_ptr<LcdLog>& log) {
  std::vector<place::LcdRecord> records;
  log.reset();
  log = std::make_unique<LcdLog>(3, folder.path,
                                 [&](const place::LcdRecord& record) { records.push_back(record); });
  return records;
}

TEST_CASE("what was kept is read back in its order, again and again") {
  const ScratchFolder folder;
  std::unique_ptr<LcdLog> log;
  REQUIRE(read_back(folder, log).empty());
  Utime now = 100;
  for (const auto& record : some_records()) log->append(record, now++);
  for (int run = 0; run < 2; ++run) REQUIRE(encoded(read_back(folder, log)) == encoded(some_records()));
}

TEST_CASE("a log that was cut off is good up to there, and goes on from there") {
  const ScratchFolder folder;
  std::unique_ptr<LcdLog> log;
  read_back(folder, log);
  for (const auto& record : some_records()) log->append(record, 5);
  log.reset();
  const auto file = folder.path / "lcd.lcm";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 37);
  REQUIRE(read_back(folder, log).size() == 4);
  log->append(some_records().front(), 6);
  REQUIRE(read_back(folder, log).size() == 5);
}

}  // namespace
}  // namespace covey
