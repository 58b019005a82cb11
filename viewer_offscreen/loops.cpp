// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/loops.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

LoopStatus parse_status(const std::string& word, const std::string& place) {
  if (word == "accepted") return LoopStatus::kAccepted;
  if (word == "rejected") return LoopStatus::kRejected;
  if (word == "true") return LoopStatus::kTrue;
  if (word == "false") return LoopStatus::kFalse;
  throw_input_error("{}: status '{}' is not accepted, rejected, true or false", place, word);
}

LoopLine parse_loop(const std::vector<std::string>& words, const std::string& place) {
  if (words.size() != 7)
    throw_input_error("{}: {} values where 'x0 y0 z0 x1 y1 z1 status' has 7", place, words.size());
  std::array<double, 6> numbers = {};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const char* end = words[i].data() + words[i].size();
    const auto [stop, error] = std::from_chars(words[i].data(), end, numbers[i]);
    if (error != std::errc() || stop != end || !std::isfinite(numbers[i])) {
      throw_input_error("{}: '{}' is not a finite number", place, words[i]);
    }
  }
  return {{numbers[0], numbers[1], numbers[2]},
          {numbers[3], numbers[4], numbers[5]},
          parse_status(words[6], place)};
}

}  // namespace

std::vector<LoopLine> read_loops(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw_input_error("{}: cannot be opened", file.string());
  std::vector<LoopLine> loops;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    if (words.empty() || words[0][0] == '#' || (number == 1 && words[0] == "x0")) continue;
    loops.push_back(parse_loop(words, file.string() + ":" + std::to_string(number)));
  }
  return loops;
}

}  // namespace covey::viewer
