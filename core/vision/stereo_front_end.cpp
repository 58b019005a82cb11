// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/stereo_front_end.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

// Of the tracks that are found again: fewer, where a picture shows nothing; more, where it goes on with the one before.
constexpr double kHardly = 0.1;
constexpr double kMost = 0.5;
constexpr std::size_t kEnough = 8;  // tracks that tell how bright a picture is
constexpr double kMostBrighter = 2.5;

cv::Mat wrap(std::span<const std::uint8_t> bytes, int width, int height) {
  return {height, width, CV_8UC1,
          const_cast<std::uint8_t*>(bytes.data())};  // OpenCV has no view of constant pixels
}

cv::Point2f to_cv(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

bool are_more(const auto& found, double share, const auto& tracks) {
  return static_cast<double>(found.size()) > share * static_cast<double>(tracks.size());
}

std::vector<cv::Point2f> pixels_of(const auto& tracks) {
  std::vector<cv::Point2f> pixels;
  pixels.reserve(tracks.size());
  for (const auto& track : tracks) pixels.push_back(track.pixel);
  return pixels;
}

}  // namespace

FrontEndOptions read_front_end_options(ConfigSection& section) {
  FrontEndOptions options;
  section.read("tracks", options.tracks, 20, 1000);
  section.read("even_light", options.even_light, 0.0, 10.0);
  section.read("sigma_px", options.sigma_px, 0.05, 10.0);
  section.read("motion_px", options.motion_px, 0.2, 50.0);
  section.read("refill_frames", options.refill_frames, 1, 100);
  section.read("passed_over_s", options.passed_over_s, 0.0, 2.0);
  section.read("remembered_s", options.remembered_s, 0.0, 10.0);
  section.read("search_frames", options.search_frames, 1, 100);
  section.read("window_px", options.flow.window_px, 5, 51);
  section.read("alike", options.flow.alike, -1.0, 1.0);
  section.read("levels", options.flow.levels, 2, 8);
  section.read("return_px", options.flow.return_px, 0.05, 10.0);
  section.read("columns", options.corners.columns, 1, 100);
  section.read("rows", options.corners.rows, 1, 100);
  section.read("min_distance_px", options.corners.min_distance_px, 1.0, 200.0);
  section.read("min_response", options.corners.min_response, 0.0, 1.0);
  section.read("nearest_m", options.stereo.nearest_m, 0.01, 100.0);
  section.read("epipolar_px", options.stereo.epipolar_px, 0.1, 20.0);
  if (options.flow.window_px % 2 == 0) {
    throw_input_error("{}: {} is even; a window has a pixel in its middle", section.where("window_px"),
                      options.flow.window_px);
  }
  return options;
}

StereoFrontEnd::StereoFrontEnd(const Rig& rig, const FrontEndOptions& options)
    : camera_(rig.left.camera), options_(options) {
  const int cells = options_.corners.columns * options_.corners.rows;
  options_.corners.per_cell = (options_.tracks + cells - 1) / cells;
  if (rig.right) matcher_.emplace(rig.left, *rig.right, options_.stereo);
  motion_.threshold = options_.motion_px / camera_.fx;
  motion_.nearest_m = options_.stereo.nearest_m;
  if (matcher_) motion_.inverse_depth_sigma = 0.5 / (camera_.fx * matcher_->baseline_m());
}

const char* StereoFrontEnd::refuse(const StereoPictures& pictures) const {
  if (pictures.width != camera_.width || pictures.height != camera_.height) return "size";
  const auto pixels = static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  if (pictures.left.size() != pixels) return "bytes";
  if (!pictures.right.empty() && pictures.right.size() != pixels) return "bytes";
  return nullptr;
}

FrontEndFrame StereoFrontEnd::process(const StereoPictures& pictures, const SO3& R_prev_cur) {
  COVEY_CHECK(refuse(pictures) == nullptr);
  FrontEndFrame frame;
  frame.tracks.utime = pictures.utime;
  const cv::Mat raw = wrap(pictures.left, pictures.width, pictures.height);
  const double brighter = before_ ? brightness(raw, R_prev_cur.inverse()) : 1.0;
  const auto even = [&](const cv::Mat& picture) {
    if (brighter == 1.0) return picture;
    cv::Mat scaled;
    picture.convertTo(scaled, -1, 1.0 / brighter);
    return scaled;
  };
  View now{pictures.utime, build_pyramid(even(raw), options_.flow), {}, {}, false};
  if (brighter != 1.0) now.raw = raw.clone();
  if (before_) {
    now.tracks = follow(*before_, R_prev_cur.inverse(), now.left);
    now.followed = are_more(now.tracks, kHardly, before_->tracks);
    if (!now.followed && !remembered_ && passes_over(pictures.utime)) return frame;
    go_on_with_remembered(R_prev_cur, now);
  }
  frame.tracked = static_cast<int>(now.tracks.size());
  add_corners(now);
  for (const Track& track : now.tracks) {
    frame.tracks.tracks.push_back({track.id, track.m, std::nullopt, options_.sigma_px / camera_.fx});
  }
  if (matcher_ && !pictures.right.empty()) {
    match_right(even(wrap(pictures.right, pictures.width, pictures.height)), now, frame);
  }
  before_ = std::move(now);
  return frame;
}

// Than the picture before, by the windows around where tracks were and where a still scene would have them; 1 where it is hardly so, or where it is too much to be made up for.
double StereoFrontEnd::brightness(const cv::Mat& left, const SO3& R_now_before) const {
  const cv::Mat& before = before_->left.picture(0);
  const int side = options_.flow.window_px;
  const cv::Rect picture(0, 0, left.cols, left.rows);
  const auto window = [&](const cv::Point2f& at) {
    return cv::Rect(cvRound(at.x) - side / 2, cvRound(at.y) - side / 2, side, side);
  };
  std::vector<double> ratios;
  for (const Track& track : before_->tracks) {
    const auto expected = camera_.project(R_now_before * track.m.homogeneous());
    if (!expected) continue;
    const cv::Rect then = window(track.pixel);
    const cv::Rect now = window(to_cv(*expected));
    if ((then & picture) != then || (now & picture) != now) continue;
    ratios.push_back((cv::sum(left(now))[0] + 1.0) / (cv::sum(before(then))[0] + 1.0));
  }
  if (ratios.size() < kEnough) return 1.0;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  const bool hardly = std::abs(*middle - 1.0) < options_.even_light;
  return hardly || *middle > kMostBrighter || *middle < 1.0 / kMostBrighter ? 1.0 : *middle;
}

// A picture that shows none of the tracks, where the one before it did not begin them itself: noise has corners, too.
bool StereoFrontEnd::passes_over(Utime utime) const {
  return before_->followed && std::abs(to_seconds(utime - before_->utime)) < options_.passed_over_s;
}

// Until most tracks go on again, the view before it all began may do better.
void StereoFrontEnd::go_on_with_remembered(const SO3& R_prev_now, View& now) {
  R_remembered_before_ = R_remembered_before_ * R_prev_now;
  const bool surely = are_more(now.tracks, kMost, before_->tracks);
  if (surely || (remembered_ && to_seconds(now.utime - remembered_->utime) > options_.remembered_s)) {
    remembered_.reset();
  } else if (remembered_) {
    auto tracks = follow(*remembered_, R_remembered_before_.inverse(), now.left);
    if (tracks.size() <= now.tracks.size()) return;
    now.followed = are_more(tracks, kHardly, remembered_->tracks);
    now.tracks = std::move(tracks);
  } else if (!now.followed && before_->followed) {
    remembered_ = std::move(before_);
    R_remembered_before_ = R_prev_now;
  }
}

std::optional<Utime> StereoFrontEnd::compared_with() const {
  return before_ ? std::optional(before_->utime) : std::nullopt;
}

bool StereoFrontEnd::repeats(const StereoPictures& pictures) const {
  if (!before_) return false;
  const cv::Mat& left = before_->raw.empty() ? before_->left.picture(0) : before_->raw;
  const auto width = static_cast<std::size_t>(pictures.width);
  for (int row = 0; row < pictures.height; ++row) {
    if (std::memcmp(left.ptr(row), &pictures.left[static_cast<std::size_t>(row) * width], width) != 0)
      return false;
  }
  return true;
}

// The tracks of an earlier view that go on in this picture.
std::vector<StereoFrontEnd::Track> StereoFrontEnd::follow(const View& then, const SO3& R_now_then,
                                                          const ImagePyramid& left) const {
  std::vector<cv::Point2f> start;
  for (const Track& track : then.tracks) {
    const auto expected = camera_.project(R_now_then * track.m.homogeneous());
    start.push_back(expected ? to_cv(*expected) : track.pixel);
  }
  const auto found =
      track_points(then.left, left, pixels_of(then.tracks), start, options_.flow.levels, options_.flow);
  std::vector<Track> before;
  std::vector<Track> after;
  for (std::size_t i = 0; i < then.tracks.size(); ++i) {
    const Track& track = then.tracks[i];
    const auto m = found[i] ? camera_.undistort({found[i]->x, found[i]->y}) : std::nullopt;
    if (!m) continue;
    before.push_back(track);
    after.push_back({track.id, *found[i], *m, track.inverse_depth, track.search_in});
  }
  return thin_out(check_motion(before, std::move(after), R_now_then));
}

// Drops what moved otherwise than the scene, and takes the depths over into this frame.
std::vector<StereoFrontEnd::Track> StereoFrontEnd::check_motion(const std::vector<Track>& before,
                                                                std::vector<Track> now,
                                                                const SO3& R_now_before) const {
  std::vector<TrackFlow> flows;
  for (std::size_t i = 0; i < now.size(); ++i) {
    flows.push_back({before[i].m, now[i].m, before[i].inverse_depth});
  }
  const auto motion = estimate_frame_motion(flows, R_now_before, motion_);
  if (!motion) return now;
  std::vector<Track> kept;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!motion->inliers[i]) continue;
    Track track = now[i];
    if (track.inverse_depth) {
      const SE3& T = motion->T_cur_prev;
      const double depth_ratio =
          (T.rotation * before[i].m.homogeneous() + *track.inverse_depth * T.translation).z();
      track.inverse_depth = depth_ratio > 0.0 ? *track.inverse_depth / depth_ratio : 0.0;
    }
    kept.push_back(track);
  }
  return kept;
}

// Two tracks on one spot say the same twice: the older one stays.
std::vector<StereoFrontEnd::Track> StereoFrontEnd::thin_out(const std::vector<Track>& tracks) const {
  const double closest = 0.5 * options_.corners.min_distance_px;
  std::vector<Track> kept;
  for (const Track& track : tracks) {
    const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Track& other) {
      const cv::Point2f d = other.pixel - track.pixel;
      return d.dot(d) < closest * closest;
    });
    if (!crowded) kept.push_back(track);
  }
  return kept;
}

void StereoFrontEnd::add_corners(View& now) {
  const bool few = 2 * static_cast<int>(now.tracks.size()) < options_.tracks;
  if (++since_corners_ < options_.refill_frames && !few) return;
  since_corners_ = 0;
  for (const cv::Point2f& pixel :
       detect_corners(now.left.picture(0), pixels_of(now.tracks), options_.corners)) {
    if (static_cast<int>(now.tracks.size()) >= options_.tracks) break;
    const auto m = camera_.undistort({pixel.x, pixel.y});
    if (!m) continue;
    now.tracks.push_back({next_id_++, pixel, *m, std::nullopt, 0});
  }
}

void StereoFrontEnd::match_right(const cv::Mat& right, View& now, FrontEndFrame& frame) {
  std::vector<StereoQuery> queries;
  std::vector<std::size_t> asked;
  for (std::size_t i = 0; i < now.tracks.size(); ++i) {
    Track& track = now.tracks[i];
    if (!track.inverse_depth && track.search_in-- > 0) continue;
    track.search_in = options_.search_frames - 1;
    queries.push_back({track.pixel, track.m, track.inverse_depth});
    asked.push_back(i);
  }
  const auto matches = matcher_->match(now.left, build_pyramid(right, options_.flow), queries, options_.flow);
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (!matches[k]) continue;
    frame.tracks.tracks[asked[k]].right = matches[k]->m;
    now.tracks[asked[k]].inverse_depth = std::max(0.0, matches[k]->inverse_depth);
    ++frame.matched;
  }
}

}  // namespace covey
