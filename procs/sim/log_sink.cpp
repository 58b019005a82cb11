// SPDX-License-Identifier: BSD-3-Clause
#include <optional>

#include "core/base/error.h"
#include "procs/common/sensor_log.h"
#include "procs/sim/sink.h"

namespace covey {
namespace {

class LogSink : public SensorSink {
 public:
  explicit LogSink(const std::filesystem::path& file)
      : file_(file), part_(file.string() + ".part"), log_(part_.string()) {}
  ~LogSink() override {
    log_.reset();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }

  void write(const imu_t& imu) override { log_->write(kImu, imu); }
  void write(const stereo_t& stereo) override { log_->write(kStereo, stereo); }
  void write(const depth_t& depth) override { log_->write(kDepth, depth); }
  void finish() override {
    if (!log_->finish()) throw_input_error("{}: the disk refused the log", part_.string());
    log_.reset();
    std::filesystem::rename(part_, file_);
  }

 private:
  std::filesystem::path file_;
  std::filesystem::path part_;
  std::optional<SensorLogWriter> log_;
};

}  // namespace

std::unique_ptr<SensorSink> make_log_sink(const std::filesystem::path& file) {
  return std::make_unique<LogSink>(file);
}

}  // namespace covey
