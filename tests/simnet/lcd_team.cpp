// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/lcd_team.h"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using testing::RandomGeometry;

constexpr double kStepM = 0.8;
constexpr double kRightM = 0.3;  // and rad

// A street with things on both sides, as long as it is looked at.
class Street {
 public:
  std::vector<testing::Landmark> around(double x) {
    while (length_ < x + 30.0) grow();
    std::vector<testing::Landmark> near;
    for (const testing::Landmark& landmark : landmarks_) {
      if (std::abs(landmark.p_W.x() - x) < 20.0) near.push_back(landmark);
    }
    return near;
  }

 private:
  void grow() {
    for (int k = 0; k < 120; ++k) {
      const double side = k % 2 == 0 ? 1.0 : -1.0;
      landmarks_.push_back({{random_.uniform(length_, length_ + 10.0), side * random_.uniform(2.5, 6.0),
                             random_.uniform(-1.0, 4.0)},
                            testing::random_descriptor(random_)});
    }
    length_ += 10.0;
  }

  RandomGeometry random_{3};
  std::vector<testing::Landmark> landmarks_;
  double length_ = 0.0;
};

LcdOptions impatient() {
  LcdOptions options;
  options.asking.again_us = kSecond;
  options.repeat_loop_us = kSecond;
  options.verifications_per_s = 20.0;
  return options;
}

}  // namespace

std::shared_ptr<const Vocabulary> street_vocabulary() {
  static const auto kVocabulary = std::make_shared<const Vocabulary>(
      Vocabulary::load(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/place/vocabulary.bin"));
  return kVocabulary;
}

std::vector<Seen> drive(int robot, const Drive& drive) {
  static Street street;
  RandomGeometry random(100 + static_cast<std::uint64_t>(robot));
  std::vector<Seen> seen;
  for (int k = 0; k < drive.keyframes; ++k) {
    SE3 T_W_B;
    T_W_B.translation = {drive.from_m + kStepM * k + 0.3 * robot, 0.25 * robot + random.uniform(-0.1, 0.1),
                         0.0};
    T_W_B.rotation = SO3::exp({0.0, 0.0, random.uniform(-0.05, 0.05)});
    const bool anew = drive.new_segment_at >= 0 && k >= drive.new_segment_at;
    const KeyframeName name{robot, 7 + robot + (anew ? 100 : 0), anew ? k - drive.new_segment_at : k};
    seen.push_back({name, k * kKeyframeUs, T_W_B,
                    see(street.around(T_W_B.translation.x()), T_W_B, testing::forward_camera(), random,
                        {.turned_bits = 5, .strangers = 40, .far_m = 14.0})});
  }
  return seen;
}

Team::Team(int robots, LinkFaults faults, std::uint64_t seed)
    : Team(std::make_unique<BareAir>(robots, faults, seed),
           std::vector<Drive>(static_cast<std::size_t>(robots)), impatient()) {}

Team::Team(std::unique_ptr<Air> air, const std::vector<Drive>& drives, const LcdOptions& options)
    : options_(options), air_(std::move(air)) {
  for (const Drive& each : drives) {
    const int robot = robots();
    drives_.push_back(drive(robot, each));
    published_[robot] = {};
    sent_[robot] = 0;
    bags_of_[robot] = {};
    for (int other = 0; other < static_cast<int>(drives.size()); ++other) got_[{robot, other}] = 0;
    start(robot);
  }
}

void Team::start(int robot) {
  agents_[robot] = std::make_unique<LcdAgent>(robot, now_ + 1, street_vocabulary(), options_);
  for (const LcdRecord& record : records_[robot]) agents_[robot]->restore(record);
  collect(robot);
}

void Team::restart(int robot, bool with_state) {
  air_->restart(robot);
  if (!with_state) records_[robot].clear();
  start(robot);
}

void Team::run_for(Utime duration) {
  for (const Utime end = now_ + duration; now_ < end; now_ += 20'000) {
    if (now_ % kKeyframeUs == 0) {
      for (auto& [robot, agent] : agents_) feed(robot);
    }
    air_->pass(now_, [this](int to, const LcdMessage& message, Utime now) { receive(to, message, now); });
    for (auto& [robot, agent] : agents_) {
      agent->tick(now_);
      agent->work(now_);
      collect(robot);
    }
  }
}

void Team::run_until_told(int robot) {
  while (agents_.at(robot)->is_busy(now_)) run_for(20'000);
}

bool Team::is_quiet() const {
  return std::none_of(agents_.begin(), agents_.end(), [this](const auto& each) {
    return each.second->is_busy(now_) || fed_.at(each.first) < drive_of(each.first).size();
  });
}

void Team::run_until_quiet() {
  run_for(kKeyframes * kKeyframeUs + kSecond);
  for (int k = 0; k < 120 && !is_quiet(); ++k) run_for(kSecond);
}

std::map<KeyframeName, loop_t> Team::closures(int robot, int other) const {
  std::map<KeyframeName, loop_t> result;
  for (const loop_t& loop : published_.at(robot)) {
    if (std::pair(loop.robot_a, loop.robot_b) != std::pair(std::min(robot, other), std::max(robot, other)))
      continue;
    const Utime segments = 1000 * loop.segment_a + loop.segment_b;
    result[{static_cast<int>(1e6 * loop.t_A_B[0]), segments, loop.id_a * 1000 + loop.id_b}] = loop;
  }
  return result;
}

SE3 Team::truth(const loop_t& loop) const {
  const auto pose = [this](const KeyframeName& name) {
    const auto& drive = drive_of(name.robot);
    return std::find_if(drive.begin(), drive.end(), [&](const Seen& seen) { return seen.name == name; })
        ->T_W_B;
  };
  return pose({loop.robot_a, loop.segment_a, loop.id_a}).inverse() *
         pose({loop.robot_b, loop.segment_b, loop.id_b});
}

void Team::feed(int robot) {
  const auto next = fed_[robot];
  const auto& drive = drives_[static_cast<std::size_t>(robot)];
  if (next >= drive.size()) return;
  ++fed_[robot];
  REQUIRE(agents_.at(robot)->add(drive[next].name, drive[next].utime, drive[next].features, now_) == nullptr);
  collect(robot);
}

void Team::receive(int to, const LcdMessage& message, Utime now) {
  const char* refused = std::visit([&](const auto& m) { return agents_.at(to)->receive(m, now); }, message);
  if (const auto* bag = std::get_if<lcd_bag_t>(&message)) {
    ++got_[{to, bag->from}];
    bags_of_[to].insert({bag->from, bag->segment, bag->id});
    if (refused != nullptr && refused == std::string("duplicate")) ++in_vain_;
  }
  collect(to);
}

bool Team::has_bags(int robot, int from, Utime before) const {
  const auto& drive = drive_of(from);
  return std::all_of(drive.begin(), drive.end(), [&](const Seen& seen) {
    return seen.utime >= before || bags_of_.at(robot).contains(seen.name);
  });
}

void Team::collect(int robot) {
  LcdAgent& agent = *agents_.at(robot);
  for (LcdRecord& record : agent.take_records()) records_[robot].push_back(std::move(record));
  for (const LcdMessage& message : agent.take_outgoing()) {
    sent_[robot] += std::holds_alternative<lcd_bag_t>(message) ? 1 : 0;
    air_->send(robot, message, now_);
  }
  for (const loop_t& loop : agent.take_loops()) published_[robot].push_back(loop);
}

std::string disagreement(const Team& team, std::size_t least) {
  for (int a = 0; a < team.robots(); ++a) {
    for (int b = a + 1; b < team.robots(); ++b) {
      const auto of_a = team.closures(a, b);
      const auto of_b = team.closures(b, a);
      if (of_a.size() < least || of_a.size() != of_b.size())
        return fmt::format("of {} and {}: {} and {} closures", a, b, of_a.size(), of_b.size());
      for (const auto& [name, loop] : of_a) {
        if (of_b.count(name) == 0 || !is_same_closure(loop, of_b.at(name)))
          return fmt::format("{} and {} have other closures", a, b);
        const SE3 T_A_B{SO3::from_quaternion({loop.q_A_B[0], loop.q_A_B[1], loop.q_A_B[2], loop.q_A_B[3]}),
                        {loop.t_A_B[0], loop.t_A_B[1], loop.t_A_B[2]}};
        if ((T_A_B.inverse() * team.truth(loop)).log().norm() >= kRightM)
          return fmt::format("{} and {} have a wrong closure", a, b);
      }
    }
  }
  return "";
}

bool has_good_streams(const Team& team) {
  for (int robot = 0; robot < team.robots(); ++robot) {
    std::map<std::int64_t, std::set<std::int32_t>> numbers;
    for (const loop_t& loop : team.published(robot)) numbers[loop.stream].insert(loop.number);
    for (const auto& [stream, of_stream] : numbers) {
      if (*of_stream.begin() != 0 || *of_stream.rbegin() + 1 != static_cast<int>(of_stream.size()))
        return false;
    }
  }
  return true;
}

}  // namespace covey::place
