// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/best_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/place/descriptor_matcher.h"

namespace covey::bench {
namespace {

constexpr int kTried = 400;   // candidates of two robots, the most similar first
constexpr int kRefused = 30;  // are enough
constexpr double kExplainedPx = 3.0;

using Robots = std::pair<int, int>;
using Keyframes = std::pair<std::size_t, std::size_t>;  // of the lower robot, of the higher

const cv::Scalar kGreen(60, 170, 40);
const cv::Scalar kRed(50, 50, 230);
const cv::Scalar kOrange(20, 150, 245);

struct Pair {
  Keyframes ends;
  place::Verification verification;
};

cv::Point2f pixel(const PinholeCamera& camera, const place::FrameFeatures& features, int k) {
  const auto seen = camera.project(features.bearings_C[static_cast<std::size_t>(k)].cast<double>());
  return seen ? cv::Point2f(static_cast<float>(seen->x()), static_cast<float>(seen->y()))
              : cv::Point2f(-1, -1);
}

// Where the pose says that point k of b is in a, if it has a depth.
bool is_explained(const PinholeCamera& camera, const SE3& T_A_B, const place::FrameFeatures& a, int i,
                  const place::FrameFeatures& b, int k) {
  const auto point = static_cast<std::size_t>(k);
  if (!b.has_depth(point)) return false;
  const auto foretold = camera.project(a.T_B_C.inverse() * (T_A_B * (b.T_B_C * b.point(point))));
  if (!foretold) return false;
  const cv::Point2f at = pixel(camera, a, i);
  return (*foretold - Eigen::Vector2d(at.x, at.y)).norm() < kExplainedPx;
}

class Drawing {
 public:
  Drawing(const BestPairs& options, const std::vector<Seen>& seen) : options_(options), seen_(seen) {}

  std::string draw(const Pair& pair, const Robots& robots) const {
    const Seen& a = seen_[pair.ends.first];
    const Seen& b = seen_[pair.ends.second];
    cv::Mat both;
    cv::hconcat(options_.picture(a.view), options_.picture(b.view), both);
    cv::cvtColor(both, both, cv::COLOR_GRAY2BGR);
    const cv::Point2f right(0.5F * static_cast<float>(both.cols), 0.0F);
    const bool accepted = pair.verification.refused == nullptr;
    for (const auto& [i, k] : place::match_descriptors(a.features.descriptors, b.features.descriptors,
                                                       options_.verification.match)) {
      cv::Scalar colour = kOrange;
      if (accepted) {
        const bool good =
            is_explained(options_.camera, pair.verification.T_A_B, a.features, i, b.features, k);
        if (!good && !b.features.has_depth(static_cast<std::size_t>(k))) continue;  // nothing says
        colour = good ? kGreen : kRed;
      }
      const cv::Point2f from = pixel(options_.camera, a.features, i);
      const cv::Point2f to = pixel(options_.camera, b.features, k) + right;
      cv::line(both, from, to, colour, 1, cv::LINE_AA);
      cv::circle(both, from, 3, colour, 1, cv::LINE_AA);
      cv::circle(both, to, 3, colour, 1, cv::LINE_AA);
    }
    std::filesystem::create_directories(options_.folder);
    const std::string name =
        fmt::format("{}-{}_{}.png", robots.first, robots.second, accepted ? "accepted" : "refused");
    if (!cv::imwrite((options_.folder / name).string(), both))
      throw_input_error("{}: cannot be written", (options_.folder / name).string());
    return name;
  }

 private:
  const BestPairs& options_;
  const std::vector<Seen>& seen_;
};

// How near a pair came.
int progress(const place::Verification& v) {
  return 1'000'000 * (v.inliers > 0) + 1000 * std::max(v.three_point, v.inliers) + v.five_point +
         v.matches / 10;
}

}  // namespace

nlohmann::json draw_best_pairs(const BestPairs& options, const std::vector<Seen>& seen,
                               const std::vector<Candidate>& candidates, const std::vector<loop_t>& loops) {
  std::map<place::KeyframeName, std::size_t> by_name;
  for (std::size_t k = 0; k < seen.size(); ++k) by_name[seen[k].view.name] = k;
  const auto robots_of = [&](const Keyframes& ends) {
    return Robots(seen[ends.first].view.name.robot, seen[ends.second].view.name.robot);
  };
  const auto in_order = [&](std::size_t i, std::size_t k) {
    return seen[i].view.name.robot <= seen[k].view.name.robot ? Keyframes(i, k) : Keyframes(k, i);
  };

  std::map<Robots, Pair> accepted;
  std::set<Keyframes> joined;
  for (const loop_t& loop : loops) {
    const Keyframes ends = in_order(by_name.at({loop.robot_a, loop.segment_a, loop.id_a}),
                                    by_name.at({loop.robot_b, loop.segment_b, loop.id_b}));
    joined.insert(ends);
    Pair& best = accepted[robots_of(ends)];
    if (loop.inliers <= best.verification.inliers) continue;
    best.ends = ends;
    best.verification.inliers = loop.inliers;
  }
  std::map<Robots, Pair> refused;
  std::map<Robots, int> tried;
  std::map<Robots, int> refusals;
  for (const Candidate& candidate : candidates) {
    const Keyframes ends = in_order(candidate.here, candidate.there);
    const Robots robots = robots_of(ends);
    if (joined.contains(ends) || tried[robots] >= kTried || refusals[robots] >= kRefused) continue;
    ++tried[robots];
    const auto verification =
        place::verify(seen[ends.first].features, seen[ends.second].features, options.verification);
    if (verification.refused == nullptr) continue;  // true neighbours of a closure, mostly
    ++refusals[robots];
    const auto found = refused.find(robots);
    if (found == refused.end() || progress(verification) > progress(found->second.verification))
      refused[robots] = {ends, verification};
  }

  const Drawing drawing(options, seen);
  nlohmann::json told = nlohmann::json::array();
  const auto tell = [&](const Robots& robots, const Pair& pair) {
    told.push_back({{"a", robots.first},
                    {"b", robots.second},
                    {"refused", pair.verification.refused ? pair.verification.refused : ""},
                    {"id_a", seen[pair.ends.first].view.name.id},
                    {"id_b", seen[pair.ends.second].view.name.id},
                    {"inliers", std::max(pair.verification.inliers, pair.verification.three_point)},
                    {"metres_apart", (seen[pair.ends.first].view.T_W_B.translation -
                                      seen[pair.ends.second].view.T_W_B.translation)
                                         .norm()},
                    {"picture", drawing.draw(pair, robots)}});
  };
  for (auto& [robots, pair] : accepted) {
    // The closure as it was told has numbers alone: its pose again, from all features.
    pair.verification =
        place::verify(seen[pair.ends.first].features, seen[pair.ends.second].features, options.verification);
    tell(robots, pair);
  }
  for (const auto& [robots, pair] : refused) tell(robots, pair);
  return told;
}

}  // namespace covey::bench
