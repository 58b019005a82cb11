// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/asl_folder.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string_view>

#include "core/base/error.h"

namespace covey {
namespace {

struct Row {
  std::string place;  // "file:line"
  std::int64_t stamp_ns = 0;
  std::vector<std::string> fields;  // after the stamp
};

std::string trimmed(std::string_view text) {
  const auto from = text.find_first_not_of(" \t\r");
  if (from == std::string_view::npos) return {};
  return std::string(text.substr(from, text.find_last_not_of(" \t\r") + 1 - from));
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::size_t from = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos; comma = line.find(',', from)) {
    fields.push_back(trimmed(std::string_view(line).substr(from, comma - from)));
    from = comma + 1;
  }
  fields.push_back(trimmed(std::string_view(line).substr(from)));
  return fields;
}

std::vector<Row> read_rows(const std::filesystem::path& file, std::size_t fields) {
  std::ifstream stream(file);
  if (!stream) throw_input_error("{}: cannot be opened; an ASL folder has it", file.string());
  std::vector<Row> rows;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    Row row{fmt::format("{}:{}", file.string(), number), 0, split(line)};
    const std::string stamp = row.fields.front();
    row.fields.erase(row.fields.begin());
    const auto parsed = std::from_chars(stamp.data(), stamp.data() + stamp.size(), row.stamp_ns);
    if (parsed.ec != std::errc() || parsed.ptr != stamp.data() + stamp.size() || row.stamp_ns < 0) {
      throw_input_error("{}: '{}' is not a stamp in nanoseconds", row.place, stamp);
    }
    if (row.fields.size() < fields) {
      throw_input_error("{}: {} columns where {} are wanted", row.place, row.fields.size() + 1, fields + 1);
    }
    if (!rows.empty() && row.stamp_ns <= rows.back().stamp_ns) {
      throw_input_error("{}: the stamp is not later than the one before", row.place);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

Utime to_utime(std::int64_t stamp_ns) { return (stamp_ns + 500) / 1000; }

double number_in(const Row& row, std::size_t field) {
  const std::string& text = row.fields[field];
  double value = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !std::isfinite(value)) {
    throw_input_error("{}: '{}' is not a number", row.place, text);
  }
  return value;
}

std::vector<imu_t> read_imu(const std::filesystem::path& file) {
  std::vector<imu_t> samples;
  for (const Row& row : read_rows(file, 6)) {
    imu_t sample{};
    sample.utime = to_utime(row.stamp_ns);
    for (std::size_t i = 0; i < 3; ++i) {
      sample.gyro[i] = number_in(row, i);
      sample.accel[i] = number_in(row, i + 3);
    }
    samples.push_back(sample);
  }
  return samples;
}

std::filesystem::path picture_of(const std::filesystem::path& camera, const Row& row) {
  std::filesystem::path file = camera / "data" / row.fields.front();
  if (!std::filesystem::is_regular_file(file))
    throw_input_error("{}: {} is not there", row.place, file.string());
  return file;
}

void read_pictures(const std::filesystem::path& mav, AslFolder& folder) {
  const auto left_rows = read_rows(mav / "cam0/data.csv", 1);
  const auto right_rows =
      std::filesystem::exists(mav / "cam1") ? read_rows(mav / "cam1/data.csv", 1) : std::vector<Row>();
  std::size_t paired = 0;
  for (const Row& left : left_rows) {
    AslPicture picture{to_utime(left.stamp_ns), picture_of(mav / "cam0", left), {}, left.place};
    const auto right =
        std::lower_bound(right_rows.begin(), right_rows.end(), left.stamp_ns,
                         [](const Row& row, std::int64_t stamp) { return row.stamp_ns < stamp; });
    if (right != right_rows.end() && right->stamp_ns == left.stamp_ns) {
      picture.right = picture_of(mav / "cam1", *right);
      ++paired;
    }
    folder.pictures.push_back(std::move(picture));
  }
  folder.unpaired_left = static_cast<int>(left_rows.size() - paired);
  folder.unpaired_right = static_cast<int>(right_rows.size() - paired);
}

cv::Mat load_grey(const std::filesystem::path& file, const std::string& listed) {
  cv::Mat picture = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  if (picture.empty()) throw_input_error("{}: {} cannot be read as a picture", listed, file.string());
  return picture;
}

std::vector<std::uint8_t> bytes_of(const cv::Mat& picture) {
  return {picture.datastart, picture.dataend};  // imread's are in one piece
}

}  // namespace

AslFolder read_asl(const std::filesystem::path& folder) {
  const std::filesystem::path mav = std::filesystem::is_directory(folder / "mav0") ? folder / "mav0" : folder;
  if (!std::filesystem::is_directory(mav / "cam0")) {
    throw_input_error("--asl {}: has neither mav0/cam0 nor cam0", folder.string());
  }
  AslFolder asl;
  read_pictures(mav, asl);
  if (std::filesystem::exists(mav / "imu0")) asl.imu = read_imu(mav / "imu0/data.csv");
  return asl;
}

stereo_t load_stereo(const AslPicture& picture) {
  const cv::Mat left = load_grey(picture.left, picture.listed);
  stereo_t message{};
  message.utime = picture.utime;
  message.width = left.cols;
  message.height = left.rows;
  message.left = bytes_of(left);
  message.n_left = static_cast<std::int32_t>(message.left.size());
  if (picture.right.empty()) return message;
  const cv::Mat right = load_grey(picture.right, picture.listed);
  if (right.size() != left.size()) {
    throw_input_error("{}: {} has another size than {}", picture.listed, picture.right.string(),
                      picture.left.string());
  }
  message.right = bytes_of(right);
  message.n_right = static_cast<std::int32_t>(message.right.size());
  return message;
}

}  // namespace covey
