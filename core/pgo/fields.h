// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A text file, gzipped or not, as lines of fields, for readers that refuse what they do not understand: every complaint is an
// InputError that begins with "file:line: ".

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace covey::pgo {

class FieldReader {
 public:
  // separator ' ' takes any run of blanks as one; another character separates exactly.
  FieldReader(const std::filesystem::path& file, char separator);

  // The next line that is neither empty nor a comment (#); false at the end.
  bool next();

  int line() const { return line_; }
  int size() const { return static_cast<int>(fields_.size()); }
  std::string_view operator[](int field) const { return fields_[field]; }
  std::string place() const { return fmt::format("{}:{}", file_.string(), line_); }

  // The field as a finite number, or as a whole number in [lowest, highest].
  double number(int field) const;
  long whole(int field, const char* what, long lowest, long highest) const;

  template <typename... Args>
  [[noreturn]] void refuse(fmt::format_string<Args...> format, Args&&... args) const {
    throw InputError(place() + ": " + fmt::format(format, std::forward<Args>(args)...));
  }

 private:
  std::filesystem::path file_;
  char separator_;
  std::string text_;
  std::size_t position_ = 0;
  int line_ = 0;
  std::vector<std::string_view> fields_;
};

}  // namespace covey::pgo
