// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/euroc_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/sim/gzip_lines.h"

namespace covey::sim {
namespace {

// A line of numbers; the stamp is read as the integer of nanoseconds or the decimal of seconds that it is, to the microsecond.
class Row {
 public:
  Row(const std::string& line, std::string where) : where_(std::move(where)) {
    const char* at = line.data();
    const char* const end = at + line.size();
    const auto is_space = [](char c) { return c == ' ' || c == ',' || c == '\t'; };
    while (true) {
      at = std::find_if_not(at, end, is_space);
      if (at == end) break;
      double number = 0.0;
      const auto [next, error] = std::from_chars(at, end, number);
      if (error != std::errc{} || (next != end && !is_space(*next)) || !std::isfinite(number))
        throw_input_error("{}: '{}' is not a number", where_,
                          std::string(at, std::find_if(at, end, is_space)));
      if (numbers_.empty()) stamp_ = std::string(at, next);
      numbers_.push_back(number);
      at = next;
    }
  }

  void expect_at_least(std::size_t count, const char* what) const {
    if (numbers_.size() < count) {
      throw_input_error("{}: expected {}, got {} numbers", where_, what, numbers_.size());
    }
  }

  Utime utime_of_ns() const {
    std::int64_t ns = 0;
    const auto [next, error] = std::from_chars(stamp_.data(), stamp_.data() + stamp_.size(), ns);
    if (error != std::errc{} || next != stamp_.data() + stamp_.size() || ns <= 0)
      throw_input_error("{}: stamp '{}' is not in nanoseconds", where_, stamp_);
    return (ns + 500) / 1000;
  }

  Utime utime_of_seconds() const {
    if (numbers_[0] <= 0.0 || numbers_[0] > 9e9)
      throw_input_error("{}: stamp '{}' is not in seconds", where_, stamp_);
    return from_seconds(numbers_[0]);
  }

  double operator[](std::size_t k) const { return numbers_[k]; }
  Eigen::Vector3d vector(std::size_t k) const { return {numbers_[k], numbers_[k + 1], numbers_[k + 2]}; }
  const std::string& where() const { return where_; }

 private:
  std::string where_;
  std::string stamp_;
  std::vector<double> numbers_;
};

SE3 pose(const Row& row, const Eigen::Quaterniond& q) {
  if (std::abs(q.norm() - 1.0) > 0.01)
    throw_input_error("{}: the quaternion has no unit length", row.where());
  return {SO3::from_quaternion(q), row.vector(1)};
}

template <typename Stamped>
void append(std::vector<Stamped>& list, const Stamped& item, const std::string& where) {
  if (!list.empty() && item.utime <= list.back().utime)
    throw_input_error("{}: its stamp does not come after the one before it", where);
  list.push_back(item);
}

template <typename Stamped, typename Parse>
std::vector<Stamped> read_rows(const std::filesystem::path& file, Parse parse) {
  std::vector<Stamped> list;
  read_lines(file, [&](const std::string& line, int number) {
    const auto first = line.find_first_not_of(" \t");
    if (first == std::string::npos || line[first] == '#') return;
    const Row row(line, fmt::format("{}:{}", file.string(), number));
    append(list, parse(row, line.find(',') != std::string::npos), row.where());
  });
  if (list.empty()) throw_input_error("{}: has no measurement", file.string());
  return list;
}

}  // namespace

std::vector<ImuSample> read_euroc_imu(const std::filesystem::path& file) {
  return read_rows<ImuSample>(file, [](const Row& row, bool) {
    row.expect_at_least(7, "a stamp, three rates and three accelerations");
    return ImuSample{.utime = row.utime_of_ns(), .gyro = row.vector(1), .accel = row.vector(4)};
  });
}

Trajectory read_euroc_truth(const std::filesystem::path& file) {
  return read_rows<StampedPose>(file, [](const Row& row, bool has_commas) {
    row.expect_at_least(8, "a stamp, a position and a quaternion");
    if (has_commas) return StampedPose{row.utime_of_ns(), pose(row, {row[4], row[5], row[6], row[7]})};
    return StampedPose{row.utime_of_seconds(), pose(row, {row[7], row[4], row[5], row[6]})};
  });
}

EurocSequence read_euroc_sequence(const std::filesystem::path& folder) {
  return {read_euroc_imu(folder / "imu0.csv.gz"), read_euroc_truth(folder / "groundtruth.csv.gz")};
}

}  // namespace covey::sim
