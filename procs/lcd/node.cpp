// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <ctime>
#include <variant>

#include "procs/lcd/images.h"

namespace covey {
namespace {

constexpr Utime kTickUs = 50'000;
constexpr Utime kImagesUs = 3 * kUsPerSecond;  // kept
constexpr Utime kPatienceUs = kUsPerSecond;    // for the images of a keyframe that was named before they came
constexpr std::size_t kQueueOfImages = 20;     // while a keyframe is worked on

double cpu_ms_since(std::clock_t begin) {
  return 1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

std::shared_ptr<const place::Vocabulary> load_vocabulary(const std::filesystem::path& file) {
  return std::make_shared<place::Vocabulary>(place::Vocabulary::load(file));
}

}  // namespace

LcdNode::LcdNode(Process& process) : LcdNode(process, process.rig()) {}

LcdNode::LcdNode(Process& process, const Rig& rig)
    : LcdNode(process, read_lcd_options(process.config().root().section("lcd"), rig), rig) {}

LcdNode::LcdNode(Process& process, const LcdNodeOptions& options, const Rig& rig)
    : process_(process),
      features_(rig, options.features),
      agent_(process.robot(), process.now(), load_vocabulary(process.beside_config(options.vocabulary)),
             options.agent),
      images_(kImagesUs) {
  cv::setNumThreads(1);
  if (!process.state_dir().empty()) {
    log_.emplace(process.robot(), process.state_dir(),
                 [this](const place::LcdRecord& record) { agent_.restore(record); });
  }
  const auto own = agent_.own_positions();
  process.bus().subscribe(
      kKeyframe, [this](const keyframe_t& message) { on_keyframe(message); },
      StreamPositions(own.begin(), own.end()));
  process.sensor_bus().subscribe(kStereo, [this](const stereo_t& message) { on_stereo(message); },
                                 {.newest_wins = true, .capacity = kQueueOfImages});
  listen(kLcdInventory);
  listen(kLcdBag);
  listen(kLcdRequest);
  listen(kLcdMore);
  listen(kLcdFrame);
  listen(kLcdLoop);
  process.loop().call_every(kTickUs, [this] {
    agent_.tick(process_.now());
    take_expected();
    work();
  });
  publish();
}

template <typename T>
void LcdNode::listen(const RadioChannel<T>& channel) {
  process_.bus().subscribe(channel, [this, channel](const T& message) {
    const char* reason = agent_.receive(message, process_.now());
    if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", channel.in().name, reason));
    work();
  });
}

void LcdNode::on_keyframe(const keyframe_t& message) {
  if (message.robot != process_.robot()) {
    process_.status().count(fmt::format("dropped/{}/robot", kKeyframe.name));
    return;
  }
  expected_.push_back(
      {{message.robot, message.segment, message.id}, message.utime, process_.now() + kPatienceUs});
  take_expected();
}

void LcdNode::on_stereo(const stereo_t& message) {
  images_.add(message);
  take_expected();
}

void LcdNode::take_expected() {
  std::erase_if(expected_, [this](const Expected& keyframe) {
    const stereo_t* images = images_.find(keyframe.utime);
    if (images != nullptr) {
      take_keyframe(keyframe, *images);
      return true;
    }
    if (process_.now() < keyframe.until) return false;
    process_.status().count(fmt::format("dropped/{}/no_images", kKeyframe.name));
    return true;
  });
}

void LcdNode::take_keyframe(const Expected& keyframe, const stereo_t& message) {
  const char* reason = "image_size";
  const auto images = images_of(message);
  const cv::Size size = features_.rectification().size();
  if (images && images->left.size() == size && images->right.size() == size) {
    const std::clock_t begin = std::clock();
    place::FrameFeatures features = features_.extract(images->left, images->right);
    reason = agent_.add(keyframe.name, keyframe.utime, std::move(features), process_.now());
    process_.status().sample("extract_ms", cpu_ms_since(begin));
  }
  if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", kKeyframe.name, reason));
  work();
}

// At most one verification per turn of the loop.
void LcdNode::work() {
  publish();
  if (work_posted_) return;
  work_posted_ = true;
  process_.loop().post([this] {
    work_posted_ = false;
    const std::clock_t begin = std::clock();
    if (!agent_.work(process_.now())) return publish();
    process_.status().sample("work_ms", cpu_ms_since(begin));
    work();
  });
}

// On disk before it is said: what others have heard must not be forgotten.
void LcdNode::publish() {
  struct Publish {
    Bus& bus;
    void operator()(const lcd_inventory_t& m) { bus.publish(kLcdInventory, m); }
    void operator()(const lcd_bag_t& m) { bus.publish(kLcdBag, m); }
    void operator()(const lcd_request_t& m) { bus.publish(kLcdRequest, m); }
    void operator()(const lcd_more_t& m) { bus.publish(kLcdMore, m); }
    void operator()(const lcd_frame_t& m) { bus.publish(kLcdFrame, m); }
    void operator()(const lcd_loop_t& m) { bus.publish(kLcdLoop, m); }
  };
  for (const place::LcdRecord& record : agent_.take_records()) {
    if (log_) log_->append(record, process_.now());
  }
  for (const place::LcdMessage& message : agent_.take_outgoing())
    std::visit(Publish{process_.bus()}, message);
  for (const loop_t& loop : agent_.take_loops()) process_.bus().publish(kLoop, loop);
  publish_status();
}

void LcdNode::publish_status() {
  Status& status = process_.status();
  for (const auto& [robot, counts] : agent_.funnel().by_robot()) {
    for (const auto& [step, n] : counts) status.set_counter(fmt::format("funnel/{}/{}", robot, step), n);
  }
  status.gauge("keyframes", agent_.keyframes(process_.robot()));
  status.gauge("others_keyframes", agent_.others_keyframes());
  status.gauge("loops", agent_.loops());
  status.gauge("untold", agent_.untold());
  status.gauge("waiting", agent_.waiting());
  status.set_phase(agent_.is_busy(process_.now()) || !expected_.empty() ? "working" : "idle");
}

}  // namespace covey
