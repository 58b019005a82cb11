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
// Pictures that show nothing (black, white, covered) are passed over: the next ones are compared with those before, for a few tenths of a second; then all
// tracks end and new ones begin. Without a right picture tracks go on, and keep the depth
// that they had for step 2. The same pictures and rotations give the same tracks.

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
  double passed_over_s = 0.3;  // of pictures that show nothing; then all tracks end
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

  void follow(const ImagePyramid& left, const SO3& R_cur_prev, FrontEndFrame& frame);
  bool passes_over(Utime utime) const;
  void check_motion(const std::vector<Track>& before, const SO3& R_cur_prev);
  void thin_out();
  void add_corners(const ImagePyramid& left);
  void match_right(const ImagePyramid& left, const cv::Mat& right, FrontEndFrame& frame);

  PinholeCamera camera_;
  FrontEndOptions options_;
  FrameMotionOptions motion_;
  std::optional<StereoMatcher> matcher_;
  ImagePyramid left_;  // of the frame before
  Utime left_utime_ = 0;
  bool left_followed_ = false;  // it showed tracks of the one before it
  std::vector<Track> tracks_;   // by rising id
  std::int64_t next_id_ = 0;
  int since_corners_ = 0;  // frames since new corners were looked for
};

}  // namespace covey
