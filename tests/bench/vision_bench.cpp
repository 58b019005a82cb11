// SPDX-License-Identifier: BSD-3-Clause
// Time of the stereo front end and its parts, per 752x480 frame: on a generated wall, and on EuRoC's clip where the data folder is there.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <opencv2/core/utility.hpp>

#include "procs/player/asl_folder.h"
#include "tests/core/vision/plane_world.h"
#include "tests/data.h"

using namespace covey;

namespace {

Rig euroc() { return read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors/euroc.yaml"); }

std::vector<PictureSet> wall_pictures(const Rig& rig) {
  std::vector<PictureSet> pictures;
  for (int i = 0; i < 10; ++i) {
    const double s = i < 6 ? i : 10 - i;  // to and fro: the last is next to the first
    const SE3 T_W_B{SO3::exp({0.0, 0.0, 0.01 * s}), {0.02 * s, 0.01 * s, 0.0}};
    pictures.push_back(render_stereo(PlaneWorld(2.0), rig, T_W_B));
  }
  return pictures;
}

std::vector<PictureSet> clip_pictures() {
  const auto folder = test_data("euroc/mh01_clip");
  std::vector<PictureSet> pictures;
  if (!folder) return pictures;
  for (const AslPicture& picture : read_asl(*folder).pictures) {
    const stereo_t stereo = load_stereo(picture);
    pictures.push_back({stereo.width, stereo.height, stereo.left, stereo.right});
  }
  return pictures;
}

void process_all(benchmark::State& state, const std::vector<PictureSet>& pictures) {
  cv::setNumThreads(1);
  StereoFrontEnd front_end(euroc(), {});
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(front_end.process(pictures[next].view(static_cast<Utime>(next)), SO3()));
    next = (next + 1) % pictures.size();
  }
}

void frame_of_a_wall(benchmark::State& state) { process_all(state, wall_pictures(euroc())); }

void frame_of_the_clip(benchmark::State& state) {
  const auto pictures = clip_pictures();
  if (pictures.empty()) return state.SkipWithError("no data");
  process_all(state, pictures);
}

void pyramid(benchmark::State& state) {
  cv::setNumThreads(1);
  const PictureSet wall = render_stereo(PlaneWorld(2.0), euroc(), SE3());
  const cv::Mat picture(wall.height, wall.width, CV_8UC1, const_cast<std::uint8_t*>(wall.left.data()));
  for (auto _ : state) benchmark::DoNotOptimize(build_pyramid(picture, {}));
}

void corners_everywhere(benchmark::State& state) {
  cv::setNumThreads(1);
  const PictureSet wall = render_stereo(PlaneWorld(2.0), euroc(), SE3());
  const cv::Mat picture(wall.height, wall.width, CV_8UC1, const_cast<std::uint8_t*>(wall.left.data()));
  for (auto _ : state) benchmark::DoNotOptimize(detect_corners(picture, {}, {}));
}

BENCHMARK(frame_of_a_wall)->Unit(benchmark::kMillisecond);
BENCHMARK(frame_of_the_clip)->Unit(benchmark::kMillisecond)->Iterations(240);
BENCHMARK(pyramid)->Unit(benchmark::kMillisecond);
BENCHMARK(corners_everywhere)->Unit(benchmark::kMillisecond);

}  // namespace
