// SPDX-License-Identifier: BSD-3-Clause
// How well place recognition does in a simulated world: the keyframes of every robot's truth (each 0.5 m, 15 deg or 1 s) are rendered,
// the robots' agents talk over a network that loses nothing, and what they accept is compared with the truth. JSON on stdout.
//
//   bench_place [--world town] [--robots 3] [--seconds 45] [--seed 1] --config configs/robots/default.yaml [--images DIR]
//
// --images keeps the pictures, robot<r>/<utime>_{left,right}.png, and reads them where they are there.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/base/bytes.h"
#include "core/base/config.h"
#include "core/place/lcd_agent.h"
#include "core/sim/cameras.h"
#include "core/sim/scenario.h"
#include "procs/common/robot_config.h"
#include "procs/common/tool.h"
#include "procs/lcd/images.h"
#include "procs/lcd/options.h"

namespace covey {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr double kNearM = 2.0;  // two keyframes that a closure could join
constexpr double kNearDeg = 30.0;
constexpr double kWrongM = 0.5;
constexpr double kWrongDeg = 5.0;

struct Bench {
  std::string world = "town";
  int robots = 3;
  double seconds = 45.0;
  std::uint64_t seed = 1;
  std::filesystem::path config;
  std::filesystem::path images;
  int run() const;
};

struct View {
  place::KeyframeName name;
  Utime utime = 0;
  SE3 T_W_B;
};

std::vector<View> cut_keyframes(const sim::Motion& motion, int robot) {
  std::vector<View> views;
  constexpr Utime kFrameUs = kUsPerSecond / sim::kStereoHz;
  for (Utime utime = motion.begin; utime <= motion.end; utime += kFrameUs) {
    const SE3 T_W_B = motion.at(utime).T_W_B;
    if (!views.empty()) {
      const SE3 step = views.back().T_W_B.inverse() * T_W_B;
      if (step.translation.norm() < 0.5 && step.rotation.log().norm() < 15.0 * kRadPerDeg &&
          utime - views.back().utime < kUsPerSecond) {
        continue;
      }
    }
    views.push_back({{robot, motion.begin, static_cast<int>(views.size())}, utime, T_W_B});
  }
  return views;
}

class Pictures {
 public:
  Pictures(const Bench& bench, const sim::MeshWorld& world, const Rig& rig)
      : folder_(bench.images), world_(world), rig_(rig), seed_(bench.seed) {}

  std::pair<cv::Mat, cv::Mat> take(const View& view) {
    const auto folder = folder_ / ("robot" + std::to_string(view.name.robot));
    const auto left = folder / (std::to_string(view.utime) + "_left.png");
    const auto right = folder / (std::to_string(view.utime) + "_right.png");
    if (!folder_.empty() && std::filesystem::exists(right)) {
      return {cv::imread(left, cv::IMREAD_GRAYSCALE), cv::imread(right, cv::IMREAD_GRAYSCALE)};
    }
    if (!cameras_) {
      sim::CameraOptions options;
      options.seed = seed_;
      cameras_ = std::make_unique<sim::SensorCameras>(world_, rig_, options);
    }
    const stereo_t stereo = cameras_->stereo(view.T_W_B, view.utime);
    const auto pair = images_of(stereo);
    if (!folder_.empty()) {
      std::filesystem::create_directories(folder);
      cv::imwrite(left, pair->left);
      cv::imwrite(right, pair->right);
    }
    return {pair->left.clone(), pair->right.clone()};
  }

 private:
  std::filesystem::path folder_;
  const sim::MeshWorld& world_;
  const Rig& rig_;
  std::uint64_t seed_;
  std::unique_ptr<sim::SensorCameras> cameras_;
};

struct Score {
  int pairs_near = 0;
  int accepted = 0;
  int wrong = 0;
  double worst_m = 0.0;
  double worst_deg = 0.0;
  std::vector<double> errors_m;
  std::vector<double> errors_deg;
  double nees = 0.0;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

class Team {
 public:
  Team(const Bench& bench, const LcdNodeOptions& options, const place::StereoFeatures& features)
      : features_(features) {
    const auto vocabulary = std::make_shared<const place::Vocabulary>(
        place::Vocabulary::load(bench.config.parent_path() / options.vocabulary));
    for (int robot = 0; robot < bench.robots; ++robot) {
      agents_.push_back(std::make_unique<place::LcdAgent>(robot, 1, vocabulary, options.agent));
    }
    recent_us_ = options.agent.recent_us;
  }

  void add(const View& view, const std::pair<cv::Mat, cv::Mat>& pictures) {
    views_[view.name] = view;
    const std::clock_t begin = std::clock();
    auto features = features_.extract(pictures.first, pictures.second);
    extract_s_ += seconds_since(begin);
    for (std::size_t k = 0; k < features.size(); ++k) depths_ += features.has_depth(k) ? 1 : 0;
    points_ += static_cast<std::int64_t>(features.size());
    agents_[static_cast<std::size_t>(view.name.robot)]->add(view.name, view.utime, std::move(features),
                                                            view.utime);
    settle(view.utime);
  }

  void settle(Utime now) {
    const std::clock_t begin = std::clock();
    bool moved = true;
    while (moved) {
      moved = false;
      for (auto& agent : agents_) {
        agent->tick(now);
        moved = agent->work(now) || moved;
        for (const place::LcdMessage& message : agent->take_outgoing()) {
          moved = true;
          std::visit([&](const auto& m) { deliver(m, now); }, message);
        }
        agent->take_records();
        for (const loop_t& loop : agent->take_loops()) loops_.push_back(loop);
      }
    }
    work_s_ += seconds_since(begin);
  }

  nlohmann::json report() {
    nlohmann::json report;
    std::map<std::pair<int, int>, Score> scores;
    count_near(scores);
    std::vector<loop_t> seen;
    for (const loop_t& loop : loops_) {
      if (std::any_of(seen.begin(), seen.end(),
                      [&](const loop_t& o) { return place::is_same_closure(o, loop); }))
        continue;
      seen.push_back(loop);
      score(loop, scores[{loop.robot_a, loop.robot_b}]);
    }
    for (auto& [pair, s] : scores) {
      report["pairs"].push_back({{"a", pair.first},
                                 {"b", pair.second},
                                 {"near", s.pairs_near},
                                 {"accepted", s.accepted},
                                 {"wrong", s.wrong},
                                 {"median_m", median(s.errors_m)},
                                 {"median_deg", median(s.errors_deg)},
                                 {"worst_m", s.worst_m},
                                 {"worst_deg", s.worst_deg},
                                 {"nees", s.accepted > s.wrong ? s.nees / (s.accepted - s.wrong) : 0.0}});
    }
    for (const auto& agent : agents_) report["funnels"].push_back(agent->funnel().total());
    report["bytes"] = bytes_;
    report["keyframes"] = views_.size();
    report["depth_share"] = static_cast<double>(depths_) / static_cast<double>(points_);
    report["extract_ms"] = 1e3 * extract_s_ / static_cast<double>(views_.size());
    report["exchange_ms"] = 1e3 * work_s_ / static_cast<double>(views_.size());
    return report;
  }

 private:
  static double seconds_since(std::clock_t begin) {
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  }

  template <typename Message>
  void deliver(const Message& message, Utime now) {
    bytes_[Message::getTypeName()] += message.getEncodedSize();
    for (std::size_t robot = 0; robot < agents_.size(); ++robot) {
      const int to = static_cast<int>(robot);
      if (to != message.from && (message.to == -1 || message.to == to)) agents_[robot]->receive(message, now);
    }
  }

  void count_near(std::map<std::pair<int, int>, Score>& scores) const {
    for (const auto& [a, view_a] : views_) {
      for (const auto& [b, view_b] : views_) {
        if (!(a < b)) continue;
        Score& score = scores[{a.robot, b.robot}];
        const SE3 T_A_B = view_a.T_W_B.inverse() * view_b.T_W_B;
        const bool recent = a.robot == b.robot && view_b.utime - view_a.utime < recent_us_;
        const bool near =
            T_A_B.translation.norm() < kNearM && T_A_B.rotation.log().norm() < kNearDeg * kRadPerDeg;
        score.pairs_near += near && !recent ? 1 : 0;
      }
    }
  }

  void score(const loop_t& loop, Score& score) const {
    const View& a = views_.at({loop.robot_a, loop.segment_a, loop.id_a});
    const View& b = views_.at({loop.robot_b, loop.segment_b, loop.id_b});
    const SE3 truth = a.T_W_B.inverse() * b.T_W_B;
    const SE3 T_A_B{SO3::from_quaternion({loop.q_A_B[0], loop.q_A_B[1], loop.q_A_B[2], loop.q_A_B[3]}),
                    {loop.t_A_B[0], loop.t_A_B[1], loop.t_A_B[2]}};
    const Vector6d error = (T_A_B.inverse() * truth).log();
    const double m = error.head<3>().norm();
    const double deg = error.tail<3>().norm() / kRadPerDeg;
    ++score.accepted;
    if (m > kWrongM || deg > kWrongDeg) {
      ++score.wrong;
      std::cerr << "wrong: " << loop.robot_a << "/" << loop.id_a << " " << loop.robot_b << "/" << loop.id_b
                << ": " << m << " m " << deg << " deg, true distance " << truth.translation.norm() << " m, "
                << truth.rotation.log().norm() / kRadPerDeg << " deg, " << loop.inliers << " of "
                << loop.matches << " matches, similarity " << loop.similarity << "\n";
      return;
    }
    score.worst_m = std::max(score.worst_m, m);
    score.worst_deg = std::max(score.worst_deg, deg);
    score.errors_m.push_back(m);
    score.errors_deg.push_back(deg);
    const Eigen::Map<const Matrix6d> covariance(loop.covariance);
    score.nees += error.dot(covariance.ldlt().solve(error));
  }

  const place::StereoFeatures& features_;
  std::vector<std::unique_ptr<place::LcdAgent>> agents_;
  std::map<place::KeyframeName, View> views_;
  std::vector<loop_t> loops_;
  std::map<std::string, std::int64_t> bytes_;
  Utime recent_us_ = 0;
  std::int64_t points_ = 0;
  std::int64_t depths_ = 0;
  double extract_s_ = 0.0;
  double work_s_ = 0.0;
};

int Bench::run() const {
  cv::setNumThreads(1);
  Config robot_config = load_robot_config(config, "lcd");
  const Rig rig = load_robot_rig(config);
  const LcdNodeOptions options = read_lcd_options(robot_config.root().section("lcd"), rig);
  const char* data = std::getenv("COVEY_DATA");
  const sim::Scenario scenario = sim::make_scenario({.world = world,
                                                     .robots = robots,
                                                     .seconds = seconds,
                                                     .seed = seed,
                                                     .data = data ? data : "",
                                                     .imu = rig.imu});
  std::vector<View> views;
  for (int robot = 0; robot < robots; ++robot) {
    for (const View& view : cut_keyframes(scenario.ride(robot).motion, robot)) views.push_back(view);
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.utime < b.utime; });
  const place::StereoFeatures features(rig, options.features);
  Pictures pictures(*this, scenario.world, rig);
  Team team(*this, options, features);
  for (const View& view : views) team.add(view, pictures.take(view));
  for (int second = 1; second <= 30; ++second) team.settle(views.back().utime + second * kUsPerSecond);
  std::cout << team.report().dump(1) << "\n";
  return 0;
}

}  // namespace
}  // namespace covey

int main(int argc, char** argv) {
  covey::Bench bench;
  CLI::App app("place recognition in a simulated world, against the truth", "bench_place");
  app.add_option("--world", bench.world)->capture_default_str();
  app.add_option("--robots", bench.robots)->capture_default_str();
  app.add_option("--seconds", bench.seconds)->capture_default_str();
  app.add_option("--seed", bench.seed)->capture_default_str();
  app.add_option("--config", bench.config)->required();
  app.add_option("--images", bench.images, "folder that keeps the pictures");
  return covey::run_tool(argc, argv, app, [&bench] { return bench.run(); });
}
