// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/status.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <set>
#include <sstream>

namespace covey {
namespace {

constexpr std::size_t kSamples = 256;

std::set<std::string> own_socket_inodes() {
  std::set<std::string> inodes;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), error).string();
    const std::string prefix = "socket:[";
    if (!error && target.rfind(prefix, 0) == 0) {
      inodes.insert(target.substr(prefix.size(), target.size() - prefix.size() - 1));
    }
  }
  return inodes;
}

}  // namespace

void Status::sample(const std::string& name, double value) {
  Samples& samples = samples_[name];
  if (samples.last.size() < kSamples) {
    samples.last.push_back(value);
  } else {
    samples.last[samples.next] = value;
    samples.next = (samples.next + 1) % kSamples;
  }
}

void Status::set_phase(const std::string& phase) {
  if (phase == phase_) return;
  phase_ = phase;
  if (on_phase_change_) on_phase_change_();
}

std::int64_t Status::counter(const std::string& name) const {
  const auto found = counters_.find(name);
  return found == counters_.end() ? 0 : found->second;
}

double Status::gauge(const std::string& name) const {
  const auto found = gauges_.find(name);
  return found == gauges_.end() ? 0.0 : found->second;
}

status_t Status::to_message(Utime now) const {
  status_t message{};
  message.utime = now;
  message.phase = phase_;
  for (const auto& [name, value] : counters_) {
    message.counter_names.push_back(name);
    message.counter_values.push_back(value);
  }
  auto gauges = gauges_;
  for (const auto& [name, samples] : samples_) {
    std::vector<double> sorted = samples.last;
    std::sort(sorted.begin(), sorted.end());
    const auto size = static_cast<double>(sorted.size());
    gauges[name + "_mean"] = std::accumulate(sorted.begin(), sorted.end(), 0.0) / size;
    gauges[name + "_p99"] = sorted[static_cast<std::size_t>(0.99 * (size - 1.0))];
    gauges[name + "_max"] = sorted.back();
  }
  for (const auto& [name, value] : gauges) {
    message.gauge_names.push_back(name);
    message.gauge_values.push_back(value);
  }
  message.n_counters = static_cast<std::int32_t>(message.counter_names.size());
  message.n_gauges = static_cast<std::int32_t>(message.gauge_names.size());
  return message;
}

// /proc/net/udp, one socket a line: sl local_address rem_address st tx:rx tr:when retrnsmt uid timeout inode
// ref pointer drops, with the local port in hexadecimal.
std::map<int, std::int64_t> kernel_drops() {
  std::map<int, std::int64_t> drops;
  const std::set<std::string> own = own_socket_inodes();
  std::ifstream file("/proc/self/net/udp");
  std::string line;
  std::getline(file, line);  // headings
  while (std::getline(file, line)) {
    std::istringstream words(line);
    const std::vector<std::string> fields{std::istream_iterator<std::string>(words), {}};
    if (fields.size() < 13 || own.count(fields[9]) == 0) continue;
    const auto colon = fields[1].find(':');
    if (colon == std::string::npos) continue;
    drops[static_cast<int>(std::strtol(fields[1].c_str() + colon + 1, nullptr, 16))] +=
        std::strtoll(fields[12].c_str(), nullptr, 10);
  }
  return drops;
}

double resident_mb() {
  std::ifstream file("/proc/self/statm");
  double total_pages = 0.0;
  double resident_pages = 0.0;
  file >> total_pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) * 1e-6;
}

}  // namespace covey
