// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

// A round from the future would keep all later ones from being newer.
constexpr Utime kClockToleranceUs = 60'000'000;

void check_folder(const Picture& picture) {
  const std::filesystem::path folder = std::filesystem::absolute(picture.file).parent_path();
  if (!std::filesystem::is_directory(folder)) throw_input_error("--out: {} is no folder", folder.string());
}

}  // namespace

ViewerNode::ViewerNode(Process& process, const Command& command) : process_(process), command_(command) {
  for (const Picture& picture : command.pictures) check_folder(picture);
  const std::vector<std::string>& urls = command.watch->urls;
  listen(process.bus());
  for (std::size_t i = 1; i < urls.size(); ++i) listen(process.open_bus(urls[i]));
  if (process.from_log()) {
    process.on_stop([this] { draw_end_of_log(); });
  } else {
    process.loop().call_every(command.watch->every_us, [this] { draw_what_is_new(); });
    process.on_stop([this] { draw_what_is_new(); });
  }
}

void ViewerNode::listen(Bus& bus) {
  listen(bus, kTrajectory);
  listen(bus, kLoopWeights);
}

template <typename T>
void ViewerNode::listen(Bus& bus, const Channel<T>& channel) {
  bus.subscribe(channel, [this, channel](const T& part) {
    const char* reason = part.utime > process_.now() + kClockToleranceUs ? "future" : team_.take(part);
    if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", channel.name, reason));
  });
}

void ViewerNode::draw_what_is_new() {
  if (team_.rounds() == drawn_rounds_ || team_.robots() == 0) return;
  try {
    draw();
  } catch (const std::exception& error) {
    process_.status().count("failed/picture");
    spdlog::warn("{}", error.what());
  }
}

void ViewerNode::draw() {
  FigureContent content = command_.content;
  team_.add_to(content);
  write_pictures(renderer_, command_, content);
  drawn_rounds_ = team_.rounds();
  process_.status().gauge("pictures", ++pictures_);
  process_.status().gauge("robots", team_.robots());
}

void ViewerNode::draw_end_of_log() {
  if (process_.loop().interrupted()) return;  // not the log's end, and run_process says so
  if (team_.robots() == 0) {
    throw_input_error("{}: no robot said a whole TRAJECTORY with poses; nothing to draw",
                      fmt::join(command_.watch->urls, ", "));
  }
  draw();
}

}  // namespace covey::viewer
