// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/options.h"

#include <Eigen/Core>

#include "core/base/error.h"
#include "procs/common/read_seconds.h"

namespace covey {
namespace {

void read_features(ConfigSection& section, place::StereoFeatureOptions& features) {
  section.read("features", features.orb.features, 50, place::kMostFeatures);
  section.read("levels", features.orb.levels, 1, 12);
  section.read("fast_threshold", features.orb.fast_threshold, 1, 100);
  section.read("near_m", features.near_m, 0.05, 100.0);
  section.read("far_m", features.far_m, 0.1, 1000.0);
  section.read("view_px", features.view_px, 0.05, 100.0);
  section.read("disparity_px", features.disparity_px, 0.05, 100.0);
}

void read_verification(ConfigSection& section, const Rig& rig, place::VerificationOptions& verification) {
  double ransac_px = 3.0;
  section.read("ransac_px", ransac_px, 0.1, 100.0);
  verification.ransac_direction = ransac_px / rig.left.camera.fx;
  section.read("match_ratio", verification.match.ratio, 0.1, 1.0);
  section.read("match_bits", verification.match.most_distance, 1, place::kDescriptorBits);
  section.read("five_point_iterations", verification.five_point_iterations, 1, 100'000);
  section.read("three_point_iterations", verification.three_point_iterations, 1, 100'000);
  section.read("least_matches", verification.least_matches, 8, place::kMostFeatures);
  section.read("least_inliers", verification.least_inliers, 6, place::kMostFeatures);
  section.read("least_share", verification.least_share, 0.0, 1.0);
  section.read("least_spread", verification.least_spread, 0.0, 1.0);
  section.read("least_thickness", verification.least_thickness, 0.0, 1.0);
  section.read("most_sigma_m", verification.most_sigma_m, 1e-3, 1e3);
  section.read("most_sigma_deg", verification.most_sigma_deg, 1e-3, 180.0);
  section.read("most_distance_m", verification.most_distance_m, 0.1, 1e3);
  section.read("least_overlap", verification.least_overlap, 0.0, 1.0);
  section.read("correlation", verification.correlation, 0.1, 100.0);
  section.read("calibration", verification.calibration, 0.0, 1.0);
}

}  // namespace

LcdNodeOptions read_lcd_options(ConfigSection& section, const Rig& rig) {
  if (!rig.right)
    throw_input_error("the sensors' file has no right camera, and lcd takes its depths from a stereo pair");
  LcdNodeOptions options;
  section.read("vocabulary", options.vocabulary);
  if (options.vocabulary.empty()) {
    throw_input_error(
        "{} is missing: it names the file of visual words, configs/place/vocabulary.bin, relative to the "
        "configuration",
        section.where("vocabulary"));
  }
  read_features(section, options.features);
  place::LcdOptions& agent = options.agent;
  section.read("least_similarity", agent.least_similarity, 0.0, 1.0);
  section.read("least_self_similarity", agent.least_self_similarity, 0.0, 1.0);
  section.read("ask_similarity", agent.ask_similarity, 0.0, 10.0);
  section.read("asks_per_keyframe", agent.asking.per_keyframe, 0.0, 100.0);
  section.read("candidates", agent.candidates, 1, 100);
  section.read("least_features", agent.least_features, 1, place::kMostFeatures);
  read_seconds(section, "recent_s", agent.recent_us, 0.0, 3600.0);
  section.read("redundant", agent.redundant, 0, 1000);
  section.read("verifications_per_s", agent.verifications_per_s, 0.1, 1000.0);
  section.read("waiting", agent.waiting, 1, 100'000);
  section.read("keyframes", agent.keyframes, 1, 1'000'000);
  section.read("sent_features", agent.sent_features, 20, place::kMostFeatures);
  section.read("more_features", agent.more_features, 0, place::kMostFeatures);
  section.read("nearly_matches", agent.nearly_matches, 1, place::kMostFeatures);
  section.read("others_features", agent.others_features, 1, 100'000);
  section.read("asked_at_once", agent.asking.at_once, 1, place::kMostAskedFor);
  read_seconds(section, "ask_again_s", agent.asking.again_us, 0.1, 600.0);
  section.read("ask_times", agent.asking.times, 1, 20);
  read_seconds(section, "repeat_loop_s", agent.repeat_loop_us, 0.1, 600.0);
  read_verification(section, rig, agent.verification);
  return options;
}

}  // namespace covey
