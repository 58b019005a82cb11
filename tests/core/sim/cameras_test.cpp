// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/cameras.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/sim/labels.h"
#include "tests/core/sim/scenes.h"

namespace covey::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

CameraOptions without_noise() {
  CameraOptions options;
  options.read_noise = 0.0;
  options.shot_noise = 0.0;
  options.depth_noise_m = 0.0;
  options.depth_edge_dropout = 0.0;
  return options;
}

// What the board looks like at a place of the picture, -1 ... 1, by the ray through it; edges are as soft as pictures have them.
double pattern(const Chessboard& board, const MountedCamera& mounted, const Vector2d& pixel) {
  const SE3 T_P_C = board.T_W_P.inverse() * mounted.T_B_C;
  const Vector3d direction_P = T_P_C.rotation * mounted.camera.undistort(pixel)->homogeneous();
  const Vector3d p_P = T_P_C.translation - T_P_C.translation.z() / direction_P.z() * direction_P;
  const double step = board.side_m / board.squares;
  constexpr double kSoftness = 0.01;  // metres
  double value = 1.0;
  for (const double x : {p_P.x(), p_P.y()}) {
    const double edge = std::round(x / step);
    const bool odd = static_cast<int>(edge + board.squares) % 2 != 0;
    value *= (odd ? -1.0 : 1.0) * std::tanh((x - edge * step) / kSoftness);
  }
  return value;
}

// How far the picture around a pixel is shifted from that: least squares over shift, contrast and brightness.
Vector2d shift_of(const std::vector<std::uint8_t>& picture, int width, const Chessboard& board,
                  const MountedCamera& mounted, const Vector2d& corner) {
  constexpr int kReach = 6;
  Vector2d shift = Vector2d::Zero();
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    for (int v = static_cast<int>(corner.y()) - kReach; v <= static_cast<int>(corner.y()) + kReach; ++v) {
      for (int u = static_cast<int>(corner.x()) - kReach; u <= static_cast<int>(corner.x()) + kReach; ++u) {
        const auto at = [&](double du, double dv) {
          return pattern(board, mounted, Vector2d(u + du, v + dv) - shift);
        };
        // To first order picture = a + c at(-step) = a + c at(0) - c gradient . step.
        const Eigen::Vector4d row(1.0, at(0, 0), at(-0.25, 0) - at(0.25, 0), at(0, -0.25) - at(0, 0.25));
        A += row * row.transpose();
        b += row * static_cast<double>(picture[static_cast<std::size_t>(v * width + u)]);
      }
    }
    const Eigen::Vector4d x = A.inverse() * b;
    shift += 0.5 * x.tail<2>() / x[1];
  }
  return shift;
}

TEST_CASE("corners in both pictures lie within 0.05 pixels of their projection through the lens") {
  const Rig rig = lens_rig();
  double worst = 0.0;
  Vector2d sum(0, 0);
  int count = 0;
  double farthest = 0.0;  // from the picture's middle
  for (int view = 0; view < 6; ++view) {
    // Square on, slanted, turned, and beside the middle, where the lens bends the most.
    const std::array<Vector3d, 6> turns = {Vector3d(0, 0, 0),        {0.4, 0, 0},   {0, -0.5, 0.3},
                                           Vector3d(0.2, 0.3, -0.8), {0, 0.6, 0.1}, {-0.3, -0.4, 0.2}};
    const std::array<Vector3d, 6> places = {Vector3d(0, 0, 2),       {0.2, 0.3, 2.5},  {-1.0, -0.4, 2.4},
                                            Vector3d(1.1, 0.5, 2.2), {1.5, -0.8, 2.6}, {-1.5, 0.9, 2.6}};
    const auto i = static_cast<std::size_t>(view);
    const Chessboard board = {{SO3::exp(turns[i]), places[i]}};
    SensorCameras cameras(chessboard_world(board, Label::kWall), rig, without_noise());
    const stereo_t stereo = cameras.stereo(SE3{}, 1);
    for (const bool left : {true, false}) {
      const MountedCamera& mounted = left ? rig.left : *rig.right;
      const std::vector<std::uint8_t>& picture = left ? stereo.left : stereo.right;
      for (int row = 1; row < board.squares; ++row) {
        for (int column = 1; column < board.squares; ++column) {
          const Vector2d projected =
              *mounted.camera.project(mounted.T_B_C.inverse() * board.corner(column, row));
          if (projected.x() < 10 || projected.y() < 10 || projected.x() > 741 || projected.y() > 469)
            continue;
          const Vector2d error = shift_of(picture, stereo.width, board, mounted, projected);
          worst = std::max(worst, error.norm());
          sum += error;
          ++count;
          farthest = std::max(farthest, (projected - Vector2d(375.5, 239.5)).norm());
        }
      }
    }
  }
  CAPTURE(worst, count, farthest, sum.transpose() / count);
  CHECK(count > 300);
  CHECK(farthest > 350.0);
  CHECK(worst < 0.05);
  CHECK((sum / count).norm() < 0.01);
}

TEST_CASE("depth is exact to a millimetre, labels are exact") {
  const Rig rig = lens_rig();
  const Chessboard board = {{SO3::exp(Vector3d(0.5, -0.6, 0.2)), Vector3d(0.2, -0.1, 4.0)}, 3.0};
  SensorCameras cameras(chessboard_world(board, Label::kTable), rig, without_noise());
  const SE3 T_W_B = {SO3::exp(Vector3d(0.05, 0.1, 0.7)), {0.1, 0.2, -0.3}};
  const depth_t depth = cameras.depth(T_W_B, 1);
  REQUIRE(depth.n_depth == 376 * 240);
  REQUIRE(depth.n_labels == 376 * 240);
  REQUIRE(depth.n_colours == 3 * 376 * 240);
  const SE3 T_P_C = board.T_W_P.inverse() * T_W_B * rig.depth->T_B_C;
  int on_board = 0;
  int wrong = 0;
  double farthest_off = 0.0;  // mm
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 376; ++u) {
      const PinholeCamera& camera = rig.depth->camera;
      const Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const Vector3d direction_P = T_P_C.rotation * ray;
      const double z = -T_P_C.translation.z() / direction_P.z();
      const Vector3d p_P = T_P_C * Vector3d(z * ray);
      const double rim = 0.5 * board.side_m - p_P.head<2>().cwiseAbs().maxCoeff();
      const auto i = static_cast<std::size_t>(v * 376 + u);
      if (rim > 0.001) {
        ++on_board;
        farthest_off = std::max(farthest_off, std::abs(depth.depth_mm[i] - 1e3 * z));
        wrong += depth.labels[i] != static_cast<std::uint8_t>(Label::kTable);
      } else if (rim < -0.001) {
        wrong += depth.depth_mm[i] != 0 || depth.labels[i] != kUnknownLabel;
      }
    }
  }
  CHECK(on_board > 10'000);
  CHECK(farthest_off <= 1.0);
  CHECK(wrong == 0);
}

TEST_CASE("depth ends at the camera's range and beside jumps, and its noise grows with the square of depth") {
  Rig rig = lens_rig();
  rig.depth->far_m = 8.0;
  const auto spread = [&](double z) {
    const Chessboard board = {{SO3(), Vector3d(0, 0, z)}, 2.0 * z};
    CameraOptions options = without_noise();
    options.depth_noise_m = 0.002;
    SensorCameras cameras(chessboard_world(board, Label::kWall), rig, options);
    const depth_t depth = cameras.depth(SE3{}, 1);
    double sum = 0.0;
    int count = 0;
    for (const std::int16_t mm : depth.depth_mm) {
      if (mm == 0) continue;
      sum += std::pow(1e-3 * mm - z, 2);
      ++count;
    }
    return count == 0 ? -1.0 : std::sqrt(sum / count);
  };
  CHECK(spread(2.0) == Approx(0.008).epsilon(0.05));
  CHECK(spread(6.0) == Approx(0.072).epsilon(0.05));
  CHECK(spread(9.0) == -1.0);

  // A board half a metre before a wall: a share of the pixels along its rim has no depth, those away from it have.
  CameraOptions options = without_noise();
  options.depth_edge_dropout = 1.0;
  const Chessboard board = {{SO3(), Vector3d(0, 0, 2.0)}, 1.0};
  SensorCameras cameras(chessboard_world(board, Label::kWall), rig, options);
  const depth_t depth = cameras.depth(SE3{}, 1);
  const auto at = [&](int u, int v) { return depth.depth_mm[static_cast<std::size_t>(v * 376 + u)]; };
  CHECK(at(187, 119) == 2000);
  // The rim at x = 0.5 m is seen at u = 229 / 4 + 187.5 = 244.75: pixel 244 is the board's last.
  CHECK(at(244, 119) == 0);
  CHECK(at(240, 119) == 2000);
}

TEST_CASE("wrong labels come at the rate that is asked for, and are classes of the world") {
  MeshBuilder builder("two walls", 16);
  const int layer = builder.add_texture(Canvas(16));
  const auto wall = [&](double x0, double x1, Label label) {
    builder.quad({Vector3d(x0, -9, 3), Vector3d(x0, 9, 3), Vector3d(x1, 9, 3), Vector3d(x1, -9, 3)}, Patch{},
                 {layer, label});
  };
  wall(-9, 0, Label::kHouse);
  wall(0, 9, Label::kTree);
  CameraOptions options = without_noise();
  options.wrong_labels = 0.2;
  SensorCameras cameras(builder.world(), lens_rig(), options);
  double wrong = 0.0;
  int foreign = 0;
  constexpr int kFrames = 8;
  for (int frame = 0; frame < kFrames; ++frame) {
    const depth_t depth = cameras.depth(SE3{}, frame);
    for (std::size_t i = 0; i < depth.labels.size(); ++i) {
      const Label right = i % 376 < 188 ? Label::kHouse : Label::kTree;
      const Label found = static_cast<Label>(depth.labels[i]);
      foreign += found != Label::kHouse && found != Label::kTree;
      wrong += found != right;
    }
  }
  CHECK(foreign == 0);
  CHECK(wrong / (kFrames * 376 * 240) == Approx(0.2).margin(0.02));
}

TEST_CASE("the noise of pictures has the spread of photons and read-out") {
  MeshBuilder builder("wall", 16);
  Canvas canvas(16);
  canvas.fill({150.0F, 150.0F, 150.0F});
  const int layer = builder.add_texture(canvas);
  builder.quad({Vector3d(-9, -9, 2), Vector3d(-9, 9, 2), Vector3d(9, 9, 2), Vector3d(9, -9, 2)}, Patch{},
               {layer, Label::kWall});
  CameraOptions options = without_noise();
  SensorCameras clean(builder.world(), lens_rig(), options);
  const double level = clean.stereo(SE3{}, 1).left[100'000];
  options.read_noise = 2.0;
  options.shot_noise = 0.3;
  SensorCameras noisy(builder.world(), lens_rig(), options);
  const stereo_t stereo = noisy.stereo(SE3{}, 1);
  double sum = 0.0;
  double squares = 0.0;
  for (const std::uint8_t grey : stereo.left) {
    sum += grey - level;
    squares += (grey - level) * (grey - level);
  }
  const double count = static_cast<double>(stereo.left.size());
  CHECK(sum / count == Approx(0.0).margin(0.02));
  CHECK(std::sqrt(squares / count) == Approx(std::sqrt(4.0 + 0.09 * level + 1.0 / 12.0)).epsilon(0.02));
  CHECK(stereo.left != stereo.right);
}

TEST_CASE("a frame is the same bytes whatever was drawn before it, and another with another seed or time") {
  const MeshWorld world = make_room({.seed = 3, .texture_side = 64});
  const Rig rig = lens_rig();
  const SE3 T_W_B = {SO3::exp(Vector3d(-1.5, 0.1, 0)), {0, 0, 1.5}};
  SensorCameras one(world, rig, {.seed = 5, .wrong_labels = 0.1});
  SensorCameras two(world, rig, {.seed = 5, .wrong_labels = 0.1});
  one.stereo(SE3{}, 7);
  one.depth(SE3{}, 8);
  const stereo_t stereo = one.stereo(T_W_B, 1000);
  const depth_t depth_two = two.depth(T_W_B, 1000);
  const stereo_t stereo_two = two.stereo(T_W_B, 1000);
  const depth_t depth = one.depth(T_W_B, 1000);
  CHECK(stereo.left == stereo_two.left);
  CHECK(stereo.right == stereo_two.right);
  CHECK(depth.depth_mm == depth_two.depth_mm);
  CHECK(depth.labels == depth_two.labels);
  CHECK(depth.colours == depth_two.colours);
  CHECK(two.stereo(T_W_B, 1001).left != stereo.left);
  SensorCameras other(world, rig, {.seed = 6});
  CHECK(other.stereo(T_W_B, 1000).left != stereo.left);
  CHECK(other.depth(T_W_B, 1000).depth_mm != depth.depth_mm);
}

TEST_CASE("corners are darker, brightness wanders with the seed's phase, and motion smears along its way") {
  const MeshWorld world = chessboard_world({{SO3(), Vector3d(0, 0, 2)}}, Label::kWall);
  const Rig rig = lens_rig();
  const std::vector<std::uint8_t> plain = SensorCameras(world, rig, without_noise()).stereo(SE3{}, 1).left;
  const auto sum = [](const std::vector<std::uint8_t>& picture) {
    double total = 0.0;
    for (const std::uint8_t grey : picture) total += grey;
    return total / static_cast<double>(picture.size());
  };

  CameraOptions dim = without_noise();
  dim.exposure.vignette = 0.5;
  const auto dimmed = SensorCameras(world, rig, dim).stereo(SE3{}, 1).left;
  CHECK(std::abs(dimmed[0] - 0.5 * plain[0]) < 1.0);
  const std::size_t middle = 240UL * 752 + 376;
  CHECK(std::abs(dimmed[middle] - plain[middle]) <= 1);

  CameraOptions wander = without_noise();
  wander.exposure.stops = 1.0;
  wander.exposure.period_s = 8.0;
  SensorCameras cameras(world, rig, wander);
  double darkest = 1e3;
  double brightest = 0.0;
  for (Utime t = 0; t < 8; ++t) {
    const double level = sum(cameras.stereo(SE3{}, t * kUsPerSecond).left);
    darkest = std::min(darkest, level);
    brightest = std::max(brightest, level);
  }
  CHECK(darkest < 0.6 * sum(plain));
  CHECK(brightest > 1.2 * sum(plain));  // white is clipped

  ExposureOptions open;
  CHECK(open_times(open, 7) == std::vector<Utime>{7});
  open.open_s = 0.01;
  open.steps = 2;
  CHECK(open_times(open, 100'000) == std::vector<Utime>{97'500, 102'500});
  SensorCameras blurring(world, rig, without_noise());
  const std::vector<SE3> way = {{SO3(), Vector3d(-0.02, 0, 0)}, {SO3(), Vector3d(0.02, 0, 0)}};
  const auto blurred = blurring.stereo(way, 1).left;
  const auto first = blurring.stereo(way[0], 1).left;
  const auto last = blurring.stereo(way[1], 1).left;
  double worst = 0.0;
  for (std::size_t i = 0; i < blurred.size(); ++i)
    worst = std::max(worst, std::abs(blurred[i] - 0.5 * (first[i] + last[i])));
  CHECK(worst < 2.0);
  CHECK(blurred != plain);
  const std::vector<SE3> still = {SE3{}, SE3{}};
  CHECK(blurring.stereo(still, 1).left == plain);
}

TEST_CASE("corners seen by a fisheye lens lie where it projects them") {
  Rig rig = lens_rig();
  rig.left.camera = {
      512, 480, 300.0, 300.0, 255.5, 239.5, {0.003, 0.0007, -0.002, 0.0002}, LensModel::kEquidistant};
  const Chessboard board = {{SO3::exp(Vector3d(0.2, 0.3, -0.4)), Vector3d(0.3, 0.1, 1.0)}};
  SensorCameras cameras(chessboard_world(board, Label::kWall), rig, without_noise());
  const stereo_t stereo = cameras.stereo(SE3{}, 1);
  double worst = 0.0;
  int count = 0;
  for (int row = 1; row < board.squares; ++row) {
    for (int column = 1; column < board.squares; ++column) {
      const Vector2d projected = *rig.left.camera.project(board.corner(column, row));
      if (projected.x() < 10 || projected.y() < 10 || projected.x() > 501 || projected.y() > 469) continue;
      worst = std::max(worst, shift_of(stereo.left, stereo.width, board, rig.left, projected).norm());
      ++count;
    }
  }
  CAPTURE(worst, count);
  CHECK(count > 30);
  CHECK(worst < 0.1);
}

TEST_CASE("a rig without a right camera gives single pictures") {
  Rig rig = lens_rig();
  rig.right.reset();
  SensorCameras cameras(chessboard_world({{SO3(), Vector3d(0, 0, 2)}}, Label::kWall), rig,
                        {.labels = false, .colours = false});
  const stereo_t stereo = cameras.stereo(SE3{}, 1);
  CHECK(stereo.n_left == 752 * 480);
  CHECK(stereo.n_right == 0);
  const depth_t depth = cameras.depth(SE3{}, 1);
  CHECK(depth.n_labels == 0);
  CHECK(depth.n_colours == 0);
}

TEST_CASE("camera options are read and refused in words") {
  CameraOptions options;
  Config config = Config::parse("cameras: {samples: 4, depth_noise_m: 0.01}", "sim.yaml");
  read_cameras(config.root().section("cameras"), options);
  config.check_all_read();
  CHECK(options.samples == 4);
  CHECK(options.depth_noise_m == 0.01);
  Config wrong = Config::parse("cameras: {samples: 2}", "sim.yaml");
  CHECK_THROWS_AS(read_cameras(wrong.root().section("cameras"), options), InputError);
}

}  // namespace
}  // namespace covey::sim
