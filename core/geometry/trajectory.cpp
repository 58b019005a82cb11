// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/trajectory.h"

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace covey {
namespace {

bool is_comment(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r");
  return first == std::string::npos || line[first] == '#';
}

std::array<double, 8> parse_numbers(const std::string& line, const std::string& where) {
  std::istringstream stream(line);
  std::array<double, 8> numbers{};
  for (double& number : numbers) {
    if (!(stream >> number) || !std::isfinite(number)) {
      throw_input_error("{}: expected eight numbers 't tx ty tz qx qy qz qw', got '{}'", where, line);
    }
  }
  std::string rest;
  if (stream >> rest) throw_input_error("{}: '{}' after the eight numbers of a pose", where, rest);
  return numbers;
}

}  // namespace

Trajectory read_tum(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw_input_error("{}: cannot be opened", file.string());
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (is_comment(line)) continue;
    const std::string where = fmt::format("{}:{}", file.string(), number);
    const auto [t, x, y, z, qx, qy, qz, qw] = parse_numbers(line, where);
    const Eigen::Quaterniond q(qw, qx, qy, qz);
    if (q.norm() < 1e-6) throw_input_error("{}: the quaternion is zero", where);
    if (std::abs(t) > 9e12) throw_input_error("{}: stamp {} is not in seconds", where, t);
    const Utime utime = from_seconds(t);
    if (!trajectory.empty() && utime <= trajectory.back().utime) {
      throw_input_error("{}: stamp {:.6f} does not come after the one before it", where, t);
    }
    trajectory.push_back({utime, {SO3::from_quaternion(q), {x, y, z}}});
  }
  return trajectory;
}

void write_tum(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::ofstream stream(file);
  if (!stream) throw_input_error("{}: cannot be written", file.string());
  for (const auto& [utime, pose] : trajectory) {
    const Utime magnitude = std::abs(utime);
    const Eigen::Vector3d& t = pose.translation;
    const Eigen::Quaterniond q = pose.rotation.canonical_quaternion();
    stream << fmt::format("{}{}.{:06d} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n",
                          utime < 0 ? "-" : "", magnitude / kUsPerSecond, magnitude % kUsPerSecond, t.x(),
                          t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  if (!stream.flush()) throw_input_error("{}: the disk refused the trajectory", file.string());
}

}  // namespace covey
