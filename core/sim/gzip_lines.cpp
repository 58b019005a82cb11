// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/gzip_lines.h"

#include <zlib.h>

#include <array>
#include <memory>

#include "core/base/error.h"

namespace covey::sim {

void read_lines(const std::filesystem::path& file, const std::function<void(const std::string&, int)>& line) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), gzclose);
  if (!stream) throw_input_error("{}: cannot be opened", file.string());
  std::array<char, 4096> buffer{};
  std::string text;
  int number = 0;
  while (gzgets(stream.get(), buffer.data(), static_cast<int>(buffer.size())) != nullptr) {
    text += buffer.data();
    if (text.back() != '\n') continue;  // longer than the buffer, or the last one
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    line(text, ++number);
    text.clear();
  }
  int error = Z_OK;
  const char* why = gzerror(stream.get(), &error);
  if (error != Z_OK && error != Z_STREAM_END)
    throw_input_error("{}: damaged after line {}: {}", file.string(), number, why);
  if (!text.empty()) line(text, number + 1);
}

}  // namespace covey::sim
