// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/cameras.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/sim/labels.h"
#include "core/sim/lens.h"
#include "core/sim/sensor_noise.h"
#include "viewer_offscreen/sensor_renderer.h"
#include "viewer_offscreen/textured_scene.h"

namespace covey::sim {
namespace {

constexpr viewer::Rgb kSky = {205, 212, 220};
constexpr std::uint8_t kGreySky = 211;

// What a frame's random numbers are for; each use has its own.
enum class Use : std::uint64_t { kLeft, kRight, kDepth, kDropout, kLabels };

viewer::Camera view_of(const PinholeCamera& camera, const SE3& T_W_C, double near, double far) {
  viewer::Camera view;
  view.T_C_W = T_W_C.inverse();
  view.fx = camera.fx;
  view.fy = camera.fy;
  view.cx = camera.cx;
  view.cy = camera.cy;
  view.width = camera.width;
  view.height = camera.height;
  view.near = near;
  view.far = far;
  return view;
}

struct GreyCamera {
  Lens lens;
  Exposure exposure;
  SE3 T_B_C;
};

GreyCamera make_grey(const MountedCamera& mounted, const CameraOptions& options) {
  return {Lens(mounted.camera, options.view_scale), Exposure(mounted.camera, options.exposure, options.seed),
          mounted.T_B_C};
}

// Beside a jump in depth. On a plane 1 / z is linear in the pixel, however slanted it is: what jumps has a second difference.
bool is_edge(const std::vector<float>& depth, const PinholeCamera& camera, int u, int v) {
  if (u == 0 || v == 0 || u + 1 == camera.width || v + 1 == camera.height) return false;
  constexpr float kJump = 0.01F;  // 1 / m
  const auto inverse = [&](int column, int row) {
    const float z = depth[static_cast<std::size_t>(row * camera.width + column)];
    return z > 0.0F ? 1.0F / z : 0.0F;
  };
  const float middle = 2.0F * inverse(u, v);
  return std::abs(inverse(u - 1, v) + inverse(u + 1, v) - middle) > kJump ||
         std::abs(inverse(u, v - 1) + inverse(u, v + 1) - middle) > kJump;
}

std::vector<std::uint8_t> classes_of(const viewer::Mesh& mesh) {
  const std::set<std::uint16_t> found(mesh.labels.begin(), mesh.labels.end());
  return {found.begin(), found.end()};
}

}  // namespace

void read_cameras(ConfigSection& section, CameraOptions& options) {
  section.read("view_scale", options.view_scale, 0.25, 4.0);
  section.read("samples", options.samples, 1, 4);
  if (options.samples != 1 && options.samples != 4) {
    throw_input_error("{}: samples are 1 or 4", section.where("samples"));
  }
  section.read("read_noise", options.read_noise, 0.0, 50.0);
  section.read("shot_noise", options.shot_noise, 0.0, 5.0);
  section.read("vignette", options.exposure.vignette, 0.0, 0.95);
  section.read("exposure_stops", options.exposure.stops, 0.0, 5.0);
  section.read("exposure_period_s", options.exposure.period_s, 0.1, 1000.0);
  section.read("shutter_s", options.exposure.open_s, 0.0, 0.05);
  section.read("shutter_steps", options.exposure.steps, 2, 50);
  section.read("depth_noise_m", options.depth_noise_m, 0.0, 1.0);
  section.read("depth_edge_dropout", options.depth_edge_dropout, 0.0, 1.0);
  section.read("wrong_labels", options.wrong_labels, 0.0, 1.0);
  section.read("labels", options.labels);
  section.read("colours", options.colours);
}

struct SensorCameras::Parts {
  Parts(const MeshWorld& world, const Rig& rig_given, const CameraOptions& options_given)
      : rig(rig_given),
        options(options_given),
        classes(classes_of(world.mesh)),
        left(make_grey(rig.left, options)),
        right(rig.right ? std::optional(make_grey(*rig.right, options)) : std::nullopt),
        noise(options.read_noise, options.shot_noise),
        scene(renderer.context(), world.mesh, world.textures) {}

  Random random(Utime utime, Use use) const {
    return Random(mix_seeds(mix_seeds(options.seed, static_cast<std::uint64_t>(utime)),
                            static_cast<std::uint64_t>(use)));
  }

  // The mean of what is seen from the poses.
  void draw(const GreyCamera& camera, std::span<const SE3> T_W_B) {
    constexpr double kNear = 0.1;
    constexpr double kFar = 200.0;
    std::vector<std::uint32_t> sums;
    for (const SE3& pose : T_W_B) {
      renderer.draw_grey(scene, view_of(camera.lens.ideal(), pose * camera.T_B_C, kNear, kFar),
                         options.samples, kGreySky, ideal_view);
      if (T_W_B.size() == 1) return;
      sums.resize(ideal_view.size());
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += ideal_view[i];
    }
    const auto count = static_cast<std::uint32_t>(T_W_B.size());
    for (std::size_t i = 0; i < sums.size(); ++i)
      ideal_view[i] = static_cast<std::uint8_t>((sums[i] + count / 2) / count);
  }

  std::vector<std::uint8_t> picture(const GreyCamera& camera, std::span<const SE3> T_W_B, Utime utime,
                                    Random random_numbers) {
    draw(camera, T_W_B);
    std::vector<std::uint8_t> pixels(
        static_cast<std::size_t>(camera.lens.camera().width * camera.lens.camera().height));
    camera.lens.distort(ideal_view, pixels);
    camera.exposure.apply(utime, pixels);
    noise.add(random_numbers, pixels);
    return pixels;
  }

  void measure_depth(const std::vector<float>& exact, Utime utime, depth_t& message) const {
    const DepthCamera& depth = *rig.depth;
    const auto& normal = normal_table();
    Random deviates = random(utime, Use::kDepth);
    Random dropouts = random(utime, Use::kDropout);
    message.depth_mm.resize(exact.size());
    std::size_t i = 0;
    for (int v = 0; v < depth.camera.height; ++v) {
      for (int u = 0; u < depth.camera.width; ++u, ++i) {
        const double z = exact[i];
        const bool dropped =
            is_edge(exact, depth.camera, u, v) && dropouts.chance(options.depth_edge_dropout);
        const double deviate = normal[deviates.next() % kNormalTableSize];
        const double measured = z + options.depth_noise_m * z * z * deviate;
        const bool in_range = z > 0.0 && measured >= depth.near_m && measured <= depth.far_m;
        message.depth_mm[i] =
            in_range && !dropped ? static_cast<std::int16_t>(std::lround(1e3 * measured)) : std::int16_t{0};
      }
    }
  }

  // Wrong labels come in blocks of 8 x 8 pixels, as a network's mistakes do: single pixels would be outvoted at once.
  void label(const std::vector<std::uint16_t>& exact, Utime utime, depth_t& message) const {
    constexpr int kBlock = 8;
    const PinholeCamera& camera = rig.depth->camera;
    message.labels.resize(exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      message.labels[i] = exact[i] == viewer::kNoLabel ? kUnknownLabel : static_cast<std::uint8_t>(exact[i]);
    }
    if (options.wrong_labels <= 0.0 || classes.size() < 2) return;
    Random mistakes = random(utime, Use::kLabels);
    for (int top = 0; top < camera.height; top += kBlock) {
      for (int left_edge = 0; left_edge < camera.width; left_edge += kBlock) {
        const std::size_t turn =
            1 + static_cast<std::size_t>(mistakes.below(static_cast<int>(classes.size()) - 1));
        if (!mistakes.chance(options.wrong_labels)) continue;
        for (int v = top; v < std::min(top + kBlock, camera.height); ++v) {
          for (int u = left_edge; u < std::min(left_edge + kBlock, camera.width); ++u) {
            std::uint8_t& found = message.labels[static_cast<std::size_t>(v * camera.width + u)];
            const auto place = std::find(classes.begin(), classes.end(), found);
            if (place == classes.end()) continue;
            found = classes[(static_cast<std::size_t>(place - classes.begin()) + turn) % classes.size()];
          }
        }
      }
    }
  }

  Rig rig;
  CameraOptions options;
  std::vector<std::uint8_t> classes;  // of this world
  GreyCamera left;
  std::optional<GreyCamera> right;
  PictureNoise noise;
  viewer::SensorRenderer renderer;
  viewer::TexturedScene scene;
  std::vector<std::uint8_t> ideal_view;
};

SensorCameras::SensorCameras(const MeshWorld& world, const Rig& rig, const CameraOptions& options)
    : parts_(std::make_unique<Parts>(world, rig, options)) {}

SensorCameras::~SensorCameras() = default;

const CameraOptions& SensorCameras::options() const { return parts_->options; }

stereo_t SensorCameras::stereo(std::span<const SE3> T_W_B, Utime utime) {
  stereo_t message{};
  message.utime = utime;
  message.width = parts_->rig.left.camera.width;
  message.height = parts_->rig.left.camera.height;
  message.left = parts_->picture(parts_->left, T_W_B, utime, parts_->random(utime, Use::kLeft));
  message.n_left = static_cast<std::int32_t>(message.left.size());
  if (parts_->right)
    message.right = parts_->picture(*parts_->right, T_W_B, utime, parts_->random(utime, Use::kRight));
  message.n_right = static_cast<std::int32_t>(message.right.size());
  return message;
}

depth_t SensorCameras::depth(const SE3& T_W_B, Utime utime) {
  COVEY_CHECK(parts_->rig.depth);
  const DepthCamera& camera = *parts_->rig.depth;
  // Beyond far_m something is still seen, has a class and a colour.
  constexpr double kNear = 0.1;
  constexpr double kFar = 200.0;
  viewer::Measurement exact = parts_->renderer.measure(
      parts_->scene, view_of(camera.camera, T_W_B * camera.T_B_C, kNear, kFar), kSky);
  depth_t message{};
  message.utime = utime;
  message.width = camera.camera.width;
  message.height = camera.camera.height;
  parts_->measure_depth(exact.depth, utime, message);
  message.n_depth = static_cast<std::int32_t>(message.depth_mm.size());
  if (parts_->options.labels) parts_->label(exact.labels, utime, message);
  message.n_labels = static_cast<std::int32_t>(message.labels.size());
  if (parts_->options.colours) message.colours = std::move(exact.rgb);
  message.n_colours = static_cast<std::int32_t>(message.colours.size());
  return message;
}

}  // namespace covey::sim
