// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/fields.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <system_error>

namespace covey::pgo {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

// The whole file; zlib hands over what is not gzipped as it is.
std::string read_text(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> stream(gzopen(file.c_str(), "rb"), gzclose);
  if (!stream || std::filesystem::is_directory(file)) throw_input_error("{}: cannot be read", file.string());
  std::string text;
  std::array<char, 65536> buffer{};
  for (int size = 0; (size = gzread(stream.get(), buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), size);
  int error = Z_OK;
  const char* why = gzerror(stream.get(), &error);
  if (error != Z_OK && error != Z_STREAM_END) {
    const auto lines = std::count(text.begin(), text.end(), '\n');
    throw_input_error("{}:{}: the gzipped file is damaged: {}", file.string(), lines + 1, why);
  }
  return text;
}

}  // namespace

FieldReader::FieldReader(const std::filesystem::path& file, char separator)
    : file_(file), separator_(separator), text_(read_text(file)) {}

bool FieldReader::next() {
  while (position_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    std::string_view rest = trim(std::string_view(text_).substr(position_, end - position_));
    position_ = end + 1;
    ++line_;
    if (rest.empty() || rest.front() == '#') continue;
    fields_.clear();
    for (;;) {
      const std::size_t stop =
          std::min(separator_ == ' ' ? rest.find_first_of(kBlanks) : rest.find(separator_), rest.size());
      fields_.push_back(trim(rest.substr(0, stop)));
      if (stop == rest.size()) return true;
      rest.remove_prefix(stop + 1);
      if (separator_ == ' ') rest = trim(rest);
    }
  }
  return false;
}

double FieldReader::number(int field) const {
  const std::string_view text = fields_[field];
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  // Too small to be told from zero is zero; a number out of the upper range is not finite.
  const bool underflow = error == std::errc::result_out_of_range && text.find("e-") != std::string_view::npos;
  if (underflow) return 0.0;
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
    refuse("field {} is '{}', not a number", field + 1, text);
  }
  if (error != std::errc() || !std::isfinite(value))
    refuse("field {} is '{}', not a finite number", field + 1, text);
  return value;
}

long FieldReader::whole(int field, const char* what, long lowest, long highest) const {
  const std::string_view text = fields_[field];
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < lowest || value > highest) {
    refuse("field {} is '{}', not a {} (a whole number from {} to {})", field + 1, text, what, lowest,
           highest);
  }
  return value;
}

}  // namespace covey::pgo
