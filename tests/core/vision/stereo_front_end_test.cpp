// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/stereo_front_end.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "tests/core/vision/plane_world.h"

using namespace covey;

namespace {

constexpr double kDistance = 2.0;

// One frame after the other of a camera that flies sideways, forward and turns.
SE3 pose_at(int frame) {
  const double s = frame;
  return {SO3::exp({0.004 * s, -0.015 * s, 0.02 * s}), {0.03 * s, 0.01 * s, 0.02 * s}};
}

double percentile(std::vector<double> values, double share) {
  REQUIRE(!values.empty());
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

PictureSet flat(const Rig& rig, std::uint8_t grey) {
  const auto pixels =
      static_cast<std::size_t>(rig.left.camera.width) * static_cast<std::size_t>(rig.left.camera.height);
  return {rig.left.camera.width, rig.left.camera.height, std::vector<std::uint8_t>(pixels, grey),
          std::vector<std::uint8_t>(pixels, grey)};
}

PictureSet noise(const Rig& rig, unsigned seed) {
  PictureSet set = flat(rig, 0);
  std::mt19937 random(seed);
  for (auto* picture : {&set.left, &set.right}) {
    for (std::uint8_t& pixel : *picture) pixel = static_cast<std::uint8_t>(random() & 0xFFU);
  }
  return set;
}

std::vector<FrontEndFrame> run(const Rig& rig, const std::vector<PictureSet>& pictures) {
  StereoFrontEnd front_end(rig, {});
  std::vector<FrontEndFrame> frames;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const auto frame = static_cast<int>(i);
    const SO3 R_prev_cur =
        frame == 0 ? SO3() : pose_at(frame - 1).rotation.inverse() * pose_at(frame).rotation;
    frames.push_back(front_end.process(pictures[i].view(50'000 * frame), R_prev_cur));
  }
  return frames;
}

}  // namespace

TEST_CASE("tracks are where the scene's points are, to a small part of a pixel") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance);
  std::vector<PictureSet> pictures;
  for (int i = 0; i < 8; ++i) pictures.push_back(render_stereo(world, rig, pose_at(i)));
  const auto frames = run(rig, pictures);

  std::map<std::int64_t, Eigen::Vector3d> points;  // in W, from where each track began
  std::vector<double> left_px;
  std::vector<double> right_px;
  for (int i = 0; i < 8; ++i) {
    const FrontEndFrame& frame = frames[static_cast<std::size_t>(i)];
    const SE3 T_W_L = pose_at(i) * rig.left.T_B_C;
    const SE3 T_W_R = pose_at(i) * rig.right->T_B_C;
    CHECK(frame.tracks.utime == 50'000 * i);
    CHECK(frame.tracks.tracks.size() >= 50);
    if (i > 0) CHECK(frame.tracked >= 0.75 * frames[static_cast<std::size_t>(i) - 1].tracks.tracks.size());
    CHECK(frame.matched >= 0.6 * frame.tracks.tracks.size());
    for (const TrackObservation& track : frame.tracks.tracks) {
      const Eigen::Vector3d& p_W = points.try_emplace(track.id, world.point(track.left, T_W_L)).first->second;
      const Eigen::Vector3d p_L = T_W_L.inverse() * p_W;
      left_px.push_back(rig.left.camera.fx * (track.left - p_L.head<2>() / p_L.z()).norm());
      if (!track.right) continue;
      const Eigen::Vector3d p_R = T_W_R.inverse() * world.point(track.left, T_W_L);
      right_px.push_back(rig.right->camera.fx * (*track.right - p_R.head<2>() / p_R.z()).norm());
    }
  }
  CHECK(percentile(left_px, 0.5) < 0.2);
  CHECK(percentile(left_px, 0.95) < 0.8);
  CHECK(percentile(right_px, 0.5) < 0.08);
  CHECK(percentile(right_px, 0.95) < 0.4);
}

TEST_CASE("tracks rise by id, keep their distance when they begin, and their count is bounded") {
  const Rig rig = test_rig();
  FrontEndOptions options;
  options.tracks = 40;
  StereoFrontEnd front_end(rig, options);
  const PictureSet pictures = render_stereo(PlaneWorld(kDistance), rig, SE3());
  const FrameTracks tracks = front_end.process(pictures.view(0), SO3()).tracks;
  CHECK(tracks.tracks.size() == 40);
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    CHECK(tracks.tracks[i].id == static_cast<std::int64_t>(i));
    CHECK(tracks.tracks[i].sigma == Approx(options.sigma_px / rig.left.camera.fx));
    const auto a = rig.left.camera.project(tracks.tracks[i].left.homogeneous());
    for (std::size_t j = 0; j < i; ++j) {
      const auto b = rig.left.camera.project(tracks.tracks[j].left.homogeneous());
      REQUIRE((a && b));
      CHECK((*a - *b).norm() > options.corners.min_distance_px - 0.01);
    }
  }
}

TEST_CASE("a gyroscope that says how far the camera turned lets tracks survive a fast turn") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance);
  const SO3 turn = SO3::exp({0.0, 0.25, 0.0});  // 57 pixels
  const PictureSet before = render_stereo(world, rig, SE3());
  const PictureSet after = render_stereo(world, rig, {turn, Eigen::Vector3d::Zero()});
  StereoFrontEnd told(rig, {});
  told.process(before.view(0), SO3());
  StereoFrontEnd untold(rig, {});
  untold.process(before.view(0), SO3());
  const int with = told.process(after.view(50'000), turn).tracked;
  const int without = untold.process(after.view(50'000), SO3()).tracked;
  CHECK(with >= 25);
  CHECK(with > 2 * without);
}

TEST_CASE("pictures that show nothing for a moment are passed over") {
  const Rig rig = test_rig();
  const PictureSet scene = render_stereo(PlaneWorld(kDistance), rig, SE3());
  for (const PictureSet& nothing : {flat(rig, 0), flat(rig, 255), noise(rig, 3)}) {
    StereoFrontEnd front_end(rig, {});
    CHECK_FALSE(front_end.compared_with());
    front_end.process(scene.view(0), SO3());
    const auto second = front_end.process(scene.view(50'000), SO3());
    CHECK(front_end.process(nothing.view(100'000), SO3()).tracks.tracks.empty());
    CHECK(front_end.compared_with() == 50'000);
    const auto again = front_end.process(scene.view(150'000), SO3());
    CHECK(again.tracked >= 0.9 * second.tracks.tracks.size());
    CHECK(front_end.compared_with() == 150'000);
  }
}

TEST_CASE("pictures that show nothing for two seconds do not end the tracks for good, those for five do") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance);
  const SO3 turn = SO3::exp({0.0, 0.1, 0.0});
  const PictureSet scene = render_stereo(world, rig, SE3());
  const PictureSet turned = render_stereo(world, rig, {turn, Eigen::Vector3d::Zero()});
  const auto tracked_after = [&](Utime dark, bool noisy) {
    StereoFrontEnd front_end(rig, {});
    front_end.process(scene.view(0), SO3());
    front_end.process(scene.view(50'000), SO3());
    const SO3 a_step =
        SO3::exp({0.0, 0.05, 0.0});  // the two pictures that begin tracks of their own: half of the turn each
    front_end.process((noisy ? noise(rig, 3) : flat(rig, 0)).view(50'000 + dark / 2), a_step);
    front_end.process((noisy ? noise(rig, 4) : flat(rig, 0)).view(50'000 + dark), a_step);
    return front_end.process(turned.view(100'000 + dark), SO3()).tracked;
  };
  for (const bool noisy : {false, true}) {
    CHECK(tracked_after(2'000'000, noisy) >= 25);
    CHECK(tracked_after(5'000'000, noisy) <= 3);
  }
}

TEST_CASE("light that flickers, and hardly is there, does not end tracks") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance);
  std::vector<PictureSet> pictures;
  for (int i = 0; i < 10; ++i) {
    pictures.push_back(render_stereo(world, rig, pose_at(i)));
    const double light = 0.25 * (i % 2 == 0 ? 1.4 : 0.7);
    for (auto* picture : {&pictures.back().left, &pictures.back().right}) {
      for (std::uint8_t& pixel : *picture) pixel = static_cast<std::uint8_t>(std::lround(light * pixel));
    }
  }
  const auto frames = run(rig, pictures);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    CAPTURE(i);
    CHECK(frames[i].tracked >= 0.7 * frames[i - 1].tracks.tracks.size());
    CHECK(frames[i].matched >= 0.5 * frames[i].tracks.tracks.size());
  }
  FrontEndOptions never;
  never.even_light = 10.0;
  StereoFrontEnd front_end(rig, never);
  const auto before = front_end.process(pictures[0].view(0), SO3());
  const auto after =
      front_end.process(pictures[1].view(50'000), pose_at(0).rotation.inverse() * pose_at(1).rotation);
  CHECK(after.tracked < 0.4 * before.tracks.tracks.size());
}

TEST_CASE("a picture that is the one before, byte for byte, is told") {
  const Rig rig = test_rig();
  const PictureSet scene = render_stereo(PlaneWorld(kDistance), rig, SE3());
  PictureSet other = scene;
  other.left.back() ^= 1U;
  StereoFrontEnd front_end(rig, {});
  CHECK_FALSE(front_end.repeats(scene.view(0)));
  front_end.process(scene.view(0), SO3());
  CHECK(front_end.repeats(scene.view(50'000)));
  CHECK_FALSE(front_end.repeats(other.view(50'000)));
}

TEST_CASE("pictures that show nothing for longer end the tracks, and the next ones begin new ones") {
  const Rig rig = test_rig();
  const PictureSet scene = render_stereo(PlaneWorld(kDistance), rig, SE3());
  for (const PictureSet& nothing : {flat(rig, 0), flat(rig, 255), noise(rig, 3)}) {
    StereoFrontEnd front_end(rig, {});
    const auto first = front_end.process(scene.view(0), SO3());
    REQUIRE(first.tracks.tracks.size() > 40);
    const std::int64_t last_id = first.tracks.tracks.back().id;
    const auto blind = front_end.process(nothing.view(400'000), SO3());
    CHECK(blind.tracked <= 0.1 * first.tracks.tracks.size());
    const auto again = front_end.process(scene.view(450'000), SO3());
    CHECK(again.tracked <= 3);
    CHECK(again.matched > 30);
    CHECK(again.tracks.tracks.back().id > last_id);
  }
}

TEST_CASE("noise matches nothing on the right, and nothing of the noise before") {
  const Rig rig = test_rig();
  StereoFrontEnd front_end(rig, {});
  CHECK(front_end.process(noise(rig, 3).view(0), SO3()).matched <= 3);
  CHECK(front_end.process(noise(rig, 4).view(400'000), SO3()).tracked <= 3);
}

TEST_CASE("without a right picture tracks go on") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance);
  StereoFrontEnd front_end(rig, {});
  const auto first = front_end.process(render_stereo(world, rig, pose_at(0)).view(0), SO3());
  PictureSet left_only = render_stereo(world, rig, pose_at(1));
  left_only.right.clear();
  const auto second =
      front_end.process(left_only.view(50'000), pose_at(0).rotation.inverse() * pose_at(1).rotation);
  CHECK(second.tracked > 0.7 * first.tracks.tracks.size());
  CHECK(second.matched == 0);
}

TEST_CASE("pictures that are not the rig's are refused by name") {
  const Rig rig = test_rig();
  const StereoFrontEnd front_end(rig, {});
  PictureSet pictures = flat(rig, 9);
  CHECK(front_end.refuse(pictures.view(0)) == nullptr);
  pictures.right.clear();
  CHECK(front_end.refuse(pictures.view(0)) == nullptr);
  pictures.right.resize(17);
  CHECK(std::string(front_end.refuse(pictures.view(0))) == "bytes");
  pictures = flat(rig, 9);
  pictures.left.pop_back();
  CHECK(std::string(front_end.refuse(pictures.view(0))) == "bytes");
  pictures = flat(rig, 9);
  std::swap(pictures.width, pictures.height);
  CHECK(std::string(front_end.refuse(pictures.view(0))) == "size");
}

TEST_CASE("the same pictures give the same tracks") {
  const Rig rig = test_rig();
  const PlaneWorld world(kDistance, 5);
  std::vector<PictureSet> pictures;
  for (int i = 0; i < 4; ++i) pictures.push_back(render_stereo(world, rig, pose_at(i)));
  const auto a = run(rig, pictures);
  const auto b = run(rig, pictures);
  for (std::size_t i = 0; i < a.size(); ++i) {
    REQUIRE(a[i].tracks.tracks.size() == b[i].tracks.tracks.size());
    for (std::size_t j = 0; j < a[i].tracks.tracks.size(); ++j) {
      CHECK(a[i].tracks.tracks[j].id == b[i].tracks.tracks[j].id);
      CHECK(a[i].tracks.tracks[j].left == b[i].tracks.tracks[j].left);
      CHECK(a[i].tracks.tracks[j].right == b[i].tracks.tracks[j].right);
    }
  }
}
