// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/process.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <vector>

#include "core/base/error.h"
#include "procs/common/command_line.h"
#include "procs/common/log_file.h"
#include "procs/common/robot_config.h"

namespace covey {
namespace {

constexpr Utime kStatusPeriodUs = 1'000'000;

// lcm-gen's decoder believes a message's counts: with a limit, an absurd one is a bad_alloc and not the end
// of the machine. And it computes an array's size in an int: from 2^31 bytes on that wraps, passes for short
// and lets it read far beyond the message; so such an array must not be had at all.
constexpr rlim_t kMemoryLimit = (rlim_t{2} << 30) - 1;

void start_logging(const CommandLine& command) {
  auto logger = spdlog::stderr_logger_st("covey");
  const std::string who =
      command.robot < 0 ? command.name : fmt::format("{}[{}]", command.name, command.robot);
  logger->set_pattern("%H:%M:%S.%e " + who + " %l: %v");
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void limit_memory() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  rlimit limit{};
  getrlimit(RLIMIT_DATA, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, kMemoryLimit);
  setrlimit(RLIMIT_DATA, &limit);
#endif
}

// "udpm://GROUP:PORT?..." -> PORT; other kinds, and what is no URL, have none, and differ as a whole.
std::string bus_port(const std::string& url) {
  const auto options = url.find('?');
  const auto colon = url.rfind(':', options);
  if (colon == std::string::npos) return url;
  return url.substr(colon, options == std::string::npos ? options : options - colon);
}

}  // namespace

struct Process::Impl {
  Impl(CommandLine parsed, Config loaded) : command(std::move(parsed)), config(std::move(loaded)) {}

  CommandLine command;
  Config config;
  EventLoop loop;
  Status status;
  std::shared_ptr<LogRecorder> recorder;
  std::vector<std::unique_ptr<Bus>> buses;
  std::vector<std::function<void()>> stop_handlers;
  Utime start_utime = 0;
  Bus* sensor = nullptr;
  Bus* depth = nullptr;

  Bus& sensor_bus(Bus*& opened, const std::string& url, Process& process) const;
};

Process::Process(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Process::~Process() = default;

const std::string& Process::name() const { return impl_->command.name; }
int Process::robot() const { return impl_->command.robot; }
Config& Process::config() { return impl_->config; }
const std::filesystem::path& Process::state_dir() const { return impl_->command.state_dir; }
const std::filesystem::path& Process::tum_path() const { return impl_->command.tum_path; }
bool Process::from_log() const { return is_log_url(impl_->command.url); }
Utime Process::now() const { return impl_->loop.now(); }
Bus& Process::bus() { return *impl_->buses.front(); }
EventLoop& Process::loop() { return impl_->loop; }
Status& Process::status() { return impl_->status; }
void Process::on_stop(std::function<void()> handler) { impl_->stop_handlers.push_back(std::move(handler)); }
void Process::stop(int exit_code) { impl_->loop.stop(exit_code); }

Bus& Process::sensor_bus() { return impl_->sensor_bus(impl_->sensor, impl_->command.sensor_url, *this); }

Bus& Process::depth_bus() { return impl_->sensor_bus(impl_->depth, impl_->command.depth_url, *this); }

std::filesystem::path Process::beside_config(const std::string& file) const {
  return std::filesystem::path(impl_->command.config).parent_path() / file;
}

Rig Process::rig() const { return load_robot_rig(impl_->command.config); }

Bus& Process::Impl::sensor_bus(Bus*& opened, const std::string& url, Process& process) const {
  if (!opened) opened = url.empty() ? &process.bus() : &process.open_bus(url);
  return *opened;
}

Bus& Process::open_bus(const std::string& url) {
  for (const auto& other : impl_->buses) {
    if (is_log_url(url) != other->from_log()) {
      throw_input_error("{} and {}: either all buses are logs or none is", url, other->url());
    }
    if (!other->from_log() && bus_port(url) == bus_port(other->url())) {
      throw_input_error("{} and {}: every bus needs a port of its own; liblcm does not separate groups", url,
                        other->url());
    }
  }
  const BusOptions options{url, impl_->command.faults, impl_->recorder};
  impl_->buses.push_back(std::make_unique<Bus>(options, impl_->loop, impl_->status));
  return *impl_->buses.back();
}

void Process::publish_status() {
  Status& status = impl_->status;
  status.gauge("rss_mb", resident_mb());
  if (!from_log()) {
    for (const auto& [port, drops] : kernel_drops())
      status.set_counter(fmt::format("kernel_drops/{}", port), drops);
  }
  status_t message = status.to_message(now());
  message.process = name();
  message.robot = robot();
  message.start_utime = impl_->start_utime;
  bus().publish(kStatus, message);
}

// From the opened bus to the end of the loop.
int Process::run(const std::function<std::shared_ptr<void>(Process&)>& make_node) {
  Impl& impl = *impl_;
  impl.loop.handle_signals();
  if (!impl.command.out.empty()) impl.recorder = std::make_shared<LogRecorder>(impl.command.out);
  open_bus(impl.command.url);
  impl.start_utime = now();
  impl.status.on_phase_change([this] { publish_status(); });
  const std::shared_ptr<void> node = make_node(*this);
  impl.config.check_all_read();
  if (impl.status.phase() == "starting") impl.status.set_phase("running");
  impl.loop.call_every(kStatusPeriodUs, [this] { publish_status(); });
  const int exit_code = impl.loop.run();
  for (const auto& handler : impl.stop_handlers) handler();
  impl.status.set_phase("stopping");
  if (impl.recorder) impl.recorder->flush();  // a full disk may only show now
  if (impl.recorder && !impl.recorder->good()) {
    throw std::runtime_error(
        fmt::format("{}: could not be written to the end; is the disk full?", impl.command.out));
  }
  if (from_log() && impl.loop.interrupted()) {
    throw std::runtime_error(
        fmt::format("interrupted before the end of {}{}", impl.command.url,
                    impl.command.out.empty() ? "" : fmt::format("; {} is partial", impl.command.out)));
  }
  return exit_code;
}

int run_process(int argc, char** argv, const ProcessOptions& options,
                const std::function<std::shared_ptr<void>(Process&)>& make_node) {
  try {
    const std::optional<CommandLine> command = parse_command_line(argc, argv, options);
    if (!command) return 0;
    start_logging(*command);
    limit_memory();
    if (command->url.empty()) {
      options.without_bus(*command);
      return 0;
    }
    Config config = load_robot_config(command->config, options.name);
    Process process(std::make_unique<Process::Impl>(*command, std::move(config)));
    if (options.before_bus) options.before_bus(process);
    return process.run(make_node);
  } catch (const InputError& error) {
    fmt::print(stderr, "{}: {}\n", options.name, error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", options.name, error.what());
    return 1;
  }
}

}  // namespace covey
