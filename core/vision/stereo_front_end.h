// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// From stereo pictures to tracks. Per frame:
//
//   1. where a gyroscope says that the camera turned, the tracks of the frame before are looked for (optical_flow.h);
//   2. tracks that do not move as the still scene does are given up (frame_motion.h), and the younger one of two that ran into each other;
//   3. cells of the picture with too few tracks get new corners (corners.h), every few frames or when half of the tracks are gone;
//   4. tracks are matched with the right picture, from the depth that they had or by a search (stereo_matcher.h); where a search finds nothing the
//      next one comes some frames later.
//
// Where the light flickers a picture is made as bright as the one before, by the ratio of what tracks look like in both (even_light): Lucas-Kanade
// takes grey values for constant. A change of less, as of a scene in steady light, is left alone.
//
// Pictures that show nothing (black, white, covered) are passed over: the next ones are compared with those before, for a few tenths of a second; then new
// tracks begin. The picture before is remembered for longer: one that does not go on with the new tracks may go on with those of then. Without a
// right picture tracks go on, and keep the depth that they had for step 2. The same pictures and rotations give the same tracks.

#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/base/config.h"
#include "core/geometry/rig.h"
#include "core/vision/corners.h"
#include "core/vision/frame_motion.h"
#include "core/vision/optical_flow.h"
#include "core/vision/stereo_matcher.h"
#include "core/vision/tracks.h"

namespace covey {

struct FrontEndOptions {
  int tracks = 140;            // at most
  double sigma_px = 0.5;       // of an observation's coordinate
  double motion_px = 2.0;      // farthest from where the still scene would be
  int refill_frames = 3;       // new corners are looked for that often
  int search_frames = 5;       // and tracks without a match searched for in the right picture
  double passed_over_s = 0.3;  // of pictures that show nothing; then new tracks begin
  double remembered_s = 3.0;   // of such pictures, after which the old ones may go on
  double even_light = 0.25;    // share by which the light must change to be made even
  FlowOptions flow;
  CornerOptions corners;
  StereoOptions stereo;
};
FrontEndOptions read_front_end_options(ConfigSection& section);

// Row by row from the top; right may be empty.
struct StereoPictures {
  Utime utime = 0;
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> left;
  std::span<const std::uint8_t> right;
};

struct FrontEndFrame {
  FrameTracks tracks;
  int tracked = 0;  // from the frame before
  int matched = 0;  // with the right picture
};

class StereoFrontEnd {
 public:
  StereoFrontEnd(const Rig& rig, const FrontEndOptions& options);

  // Why these pictures cannot be used: "size" (not the rig's), "bytes" (other than width height, right may be empty); else null.
  const char* refuse(const StereoPictures& pictures) const;

  // R_prev_cur: of the left camera since the picture that this one is compared with, as predicted; identity will do where nothing is known, for slow turns.
  FrontEndFrame process(const StereoPictures& pictures, const SO3& R_prev_cur);

  // The stamp of the picture that the next one is compared with; nothing before the first.
  std::optional<Utime> compared_with() const;
  // Whether the left picture is that one, byte for byte: real sensors have noise.
  bool repeats(const StereoPictures& pictures) const;

 private:
  struct Track {
    std::int64_t id = 0;
    cv::Point2f pixel;
    Eigen::Vector2d m;                    // undistorted
    std::optional<double> inverse_depth;  // in this frame's left camera
    int search_in = 0;                    // frames until the right picture is searched for it
  };

  struct View {
    Utime utime = 0;
    ImagePyramid left;
    cv::Mat raw;                // the picture as it came where it was made even; else empty
    std::vector<Track> tracks;  // by rising id
    bool followed = false;      // it shows tracks of an earlier one
  };

  std::vector<Track> follow(const View& then, const SO3& R_now_then, const ImagePyramid& left) const;
  void go_on_with_remembered(const SO3& R_prev_now, View& now);
  double brightness(const cv::Mat& left, const SO3& R_now_before) const;
  bool passes_over(Utime utime) const;
  std::vector<Track> check_motion(const std::vector<Track>& before, std::vector<Track> now,
                                  const SO3& R_now_before) const;
  std::vector<Track> thin_out(const std::vector<Track>& tracks) const;
  void add_corners(View& now);
  void match_right(const cv::Mat& right, View& now, FrontEndFrame& frame);

  PinholeCamera camera_;
  FrontEndOptions options_;
  FrameMotionOptions motion_;
  std::optional<StereoMatcher> matcher_;
  std::optional<View> before_;
  std::optional<View> remembered_;  // the last one before pictures began to show nothing, until they go on
  SO3 R_remembered_before_;
  std::int64_t next_id_ = 0;
  int since_corners_ = 0;  // frames since new corners were looked for
};

}  // namespace covey
