// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/lcd_agent.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace covey::place {
namespace {

constexpr int kBeforeAtMost = 5;  // ids, to a keyframe that still is "the one before"

KeyframeName end_a(const loop_t& loop) { return {loop.robot_a, loop.segment_a, loop.id_a}; }
KeyframeName end_b(const loop_t& loop) { return {loop.robot_b, loop.segment_b, loop.id_b}; }

}  // namespace

LcdAgent::LcdAgent(int robot, std::int64_t stream, std::shared_ptr<const Vocabulary> vocabulary,
                   const LcdOptions& options)
    : robot_(robot),
      stream_(stream),
      vocabulary_(std::move(vocabulary)),
      options_(options),
      exchange_(robot, static_cast<std::int64_t>(vocabulary_->hash()), options.exchange),
      asking_(robot, options.asking),
      allowance_(options_.verifications_per_s) {}

const char* LcdAgent::add(const KeyframeName& name, Utime utime, FrameFeatures features, Utime now) {
  if (name.robot != robot_) return "robot";
  if (static_cast<int>(features.size()) < options_.least_features) return "few_features";
  const WordCounts counts = vocabulary_->counts(features.descriptors);
  if (counts.words.empty()) return "few_features";
  if (const char* reason = remember(name, utime, vocabulary_->bag(counts))) return reason;
  const lcd_bag_t bag = bag_message(name, utime, counts, vocabulary_->hash());
  records_.emplace_back(bag);
  records_.emplace_back(frame_message(name, utime, robot_, features));
  own_bags_[name] = bag;
  exchange_.offer(name);
  exchange_bags(now);
  own_features_[name] = std::move(features);
  for (const auto& [robot, places] : robots_) look_for(name, robot);
  ask(now);
  return nullptr;
}

const char* LcdAgent::receive(const lcd_inventory_t& message, Utime now) {
  if (message.from == robot_ || !is_robot(message.from)) return "robot";
  hear(message.from, now);
  const char* reason = exchange_.receive(message, now);
  exchange_bags(now);
  return reason;
}

const char* LcdAgent::receive(const lcd_bag_t& message, Utime now) {
  if (message.from == robot_ || !is_robot(message.from)) return "robot";
  hear(message.from, now);
  if (message.vocabulary != static_cast<std::int64_t>(vocabulary_->hash())) return "vocabulary";
  WordCounts counts;
  if (const char* reason = read_bag(message, vocabulary_->words(), counts)) return reason;
  BagOfWords bag = vocabulary_->bag(counts);
  if (bag.words.empty()) return "words";
  funnel_.count(message.from, "received");
  if (verifier_of(robot_, message.from) != robot_) return nullptr;
  const KeyframeName name{message.from, message.segment, message.id};
  if (!exchange_.take(name)) return "duplicate";
  if (const char* reason = remember(name, message.utime, std::move(bag))) return reason;
  records_.emplace_back(message);
  asking_.allow(name.robot);
  look_for(name, robot_);
  ask(now);
  return nullptr;
}

const char* LcdAgent::receive(const lcd_request_t& message, Utime now) {
  if (message.from == robot_ || message.to != robot_ || !is_robot(message.from)) return "robot";
  if (message.n <= 0 || message.n > kMostAskedFor) return "values";
  hear(message.from, now);
  for (std::size_t k = 0; k < message.ids.size(); ++k) {
    const KeyframeName name{robot_, message.segments[k], message.ids[k]};
    const FrameFeatures* own = features_of(name);
    // What is not there is said too, so that nobody waits for it.
    outgoing_.emplace_back(frame_message(name, now, message.from,
                                         own ? best_of(*own, options_.sent_features) : FrameFeatures{}));
  }
  return nullptr;
}

const char* LcdAgent::receive(const lcd_more_t& message, Utime now) {
  if (message.from == robot_ || message.to != robot_ || !is_robot(message.from)) return "robot";
  if (message.known <= 0 || message.known > kMostFeatures) return "values";
  hear(message.from, now);
  const KeyframeName name{robot_, message.segment, message.id};
  const FrameFeatures* own = features_of(name);
  outgoing_.emplace_back(frame_message(
      name, now, message.from,
      own ? best_of(*own, message.known + options_.more_features, message.known) : FrameFeatures{}));
  return nullptr;
}

const char* LcdAgent::receive(const lcd_frame_t& message, Utime now) {
  if (message.from == robot_ || message.to != robot_) return "robot";
  const KeyframeName name{message.from, message.segment, message.id};
  const auto known = asking_.known(name);
  if (!known) return "unasked";
  FrameFeatures features;
  if (const char* reason = read_frame(message, features)) return reason;
  hear(message.from, now);
  if (*known > 0) return take_more(name, features);
  asking_.end(name);
  funnel_.count(message.from, "answered");
  if (features.size() == 0) {
    forget_candidates(name, "gone");
  } else {
    keep_features_of_other(name, std::move(features));
  }
  ask(now);
  return nullptr;
}

const char* LcdAgent::receive(const lcd_loop_t& message, Utime now) {
  const loop_t& loop = message.loop;
  if (message.to != robot_ || message.from == robot_ || !is_robot(message.from)) return "robot";
  if (loop.robot_a != std::min(robot_, message.from) || loop.robot_b != std::max(robot_, message.from))
    return "robot";
  hear(message.from, now);
  const auto known = std::find_if(loops_.begin(), loops_.end(),
                                  [&loop](const loop_t& other) { return is_same_closure(loop, other); });
  if (verifier_of(robot_, message.from) == robot_) {
    if (known == loops_.end()) return "unasked";
    if (untold_.erase(static_cast<std::size_t>(known - loops_.begin())) > 0) records_.emplace_back(message);
    return nullptr;
  }
  if (!is_good(loop)) return "values";
  if (known == loops_.end() && loops() >= options_.most_loops) return "full";
  const bool is_new = known == loops_.end();
  if (is_new) {
    funnel_.count(message.from, "told");
    take_loop(loop, now);
  }
  lcd_loop_t answer = message;
  answer.utime = now;
  answer.from = robot_;
  answer.to = message.from;
  outgoing_.emplace_back(answer);
  return is_new ? nullptr : "duplicate";
}

void LcdAgent::tick(Utime now) {
  const auto in_range = [&](int robot) { return exchange_.present(robot, now); };
  for (const KeyframeName& name : asking_.give_up(now, in_range)) forget_candidates(name, "unanswered");
  tell(now);
  ask(now);
  exchange_bags(now);
}

bool LcdAgent::work(Utime now) {
  std::erase_if(waiting_, [this](const Candidate& candidate) {
    if (!is_redundant(candidate)) return false;
    funnel_.refuse(candidate.other.robot, "redundant");
    return true;
  });
  const auto best = std::find_if(waiting_.begin(), waiting_.end(),
                                 [this](const Candidate& candidate) { return can_verify(candidate); });
  if (best == waiting_.end()) return look_again(now);
  if (!spend_verification(now)) return false;
  const Candidate candidate = *best;
  waiting_.erase(best);
  verify_candidate(candidate, now);
  ask(now);
  return true;
}

bool LcdAgent::is_busy(Utime now) const {
  const bool telling = std::any_of(untold_.begin(), untold_.end(), [&](const auto& each) {
    return each.second.period <= 2 * options_.repeat_loop_us && exchange_.present(each.second.to, now);
  });
  const bool ready = std::any_of(waiting_.begin(), waiting_.end(),
                                 [this](const Candidate& candidate) { return can_verify(candidate); });
  const auto in_range = [&](int robot) { return exchange_.present(robot, now); };
  return asking_.waits(in_range) || telling || ready || !restored_.empty() || exchange_.owes(now);
}

void LcdAgent::restore(const LcdRecord& record) {
  if (const auto* bag = std::get_if<lcd_bag_t>(&record)) {
    WordCounts counts;
    if (bag->vocabulary != static_cast<std::int64_t>(vocabulary_->hash())) return;
    if (read_bag(*bag, vocabulary_->words(), counts)) return;
    const KeyframeName name{bag->from, bag->segment, bag->id};
    if (remember(name, bag->utime, vocabulary_->bag(counts))) return;
    restored_.push_back(name);
    if (name.robot != robot_) {
      exchange_.take(name);
      return;
    }
    own_bags_[name] = *bag;
    exchange_.offer(name);
  } else if (const auto* frame = std::get_if<lcd_frame_t>(&record)) {
    FrameFeatures own;
    if (read_frame(*frame, own)) return;
    own_features_[{robot_, frame->segment, frame->id}] = std::move(own);
  } else if (const auto* loop = std::get_if<loop_t>(&record)) {
    if (!is_good(*loop)) return;
    note_loop(*loop);
    new_loops_.push_back(*loop);
  } else if (const auto* answer = std::get_if<lcd_loop_t>(&record)) {
    for (std::size_t k = 0; k < loops_.size(); ++k) {
      if (is_same_closure(loops_[k], answer->loop)) untold_.erase(k);
    }
  }
}

int LcdAgent::keyframes(int robot) const {
  const auto places = robots_.find(robot);
  return places == robots_.end() ? 0 : places->second.words.size();
}

int LcdAgent::others_keyframes() const {
  int n = 0;
  for (const auto& [robot, places] : robots_) n += robot == robot_ ? 0 : places.words.size();
  return n;
}

std::map<Utime, int> LcdAgent::own_positions() const {
  std::map<Utime, int> next;
  const auto own = robots_.find(robot_);
  if (own == robots_.end()) return next;
  for (const Place& place : own->second.places) {
    next[place.name.segment] = std::max(next[place.name.segment], place.name.id + 1);
  }
  return next;
}

// One that comes into range has waited for nothing until now: what is under way is given its time again.
void LcdAgent::hear(int robot, Utime now) {
  if (!exchange_.hear(robot, now)) return;
  asking_.hear(robot, now);
  for (auto& [loop, untold] : untold_) {
    if (untold.to != robot) continue;
    untold.period = options_.repeat_loop_us;
    if (untold.again > 0) untold.again = now + untold.period;
  }
}

void LcdAgent::exchange_bags(Utime now) {
  while (const auto due = exchange_.next(now)) {
    lcd_bag_t bag = own_bags_.at(due->name);
    bag.to = due->to;
    outgoing_.emplace_back(std::move(bag));
  }
  if (auto inventory = exchange_.say(now)) outgoing_.emplace_back(std::move(*inventory));
}

const char* LcdAgent::remember(const KeyframeName& name, Utime utime, BagOfWords bag) {
  RobotPlaces& robot = robots_[name.robot];
  if (robot.entries.contains(name)) return "duplicate";
  if (robot.words.size() >= options_.keyframes) return "full";
  robot.entries[name] = robot.words.add(std::move(bag));
  robot.places.push_back({name, utime});
  return nullptr;
}

// To the nearest keyframe before it, or after it where words came in disorder; 0: there is none near.
double LcdAgent::self_similarity(const KeyframeName& name) const {
  const RobotPlaces& robot = robots_.at(name.robot);
  const BagOfWords& bag = robot.words.bag(robot.entries.at(name));
  for (int away = 1; away <= kBeforeAtMost; ++away) {
    for (const int id : {name.id - away, name.id + away}) {
      const auto beside = robot.entries.find({name.robot, name.segment, id});
      if (beside != robot.entries.end()) return similarity(bag, robot.words.bag(beside->second));
    }
  }
  return 0.0;
}

void LcdAgent::look_for(const KeyframeName& name, int robot) {
  const auto known = robots_.find(robot);
  const double expected = self_similarity(name);
  if (known == robots_.end() || expected < options_.least_self_similarity) return;
  const RobotPlaces& own = robots_.at(name.robot);
  const int entry = own.entries.at(name);
  const RobotPlaces& others = known->second;
  std::vector<KeyframeName> chosen;
  for (const auto& hit : others.words.query(own.words.bag(entry), options_.least_similarity * expected)) {
    if (static_cast<int>(chosen.size()) == options_.candidates) break;
    const Place& place = others.places[static_cast<std::size_t>(hit.entry)];
    const bool same_segment = place.name.robot == name.robot && place.name.segment == name.segment;
    const Utime apart = std::abs(place.utime - own.places[static_cast<std::size_t>(entry)].utime);
    if (same_segment && apart < options_.recent_us) continue;
    const bool beside = std::any_of(chosen.begin(), chosen.end(), [&](const KeyframeName& other) {
      return other.segment == place.name.segment && std::abs(other.id - place.name.id) <= options_.redundant;
    });
    if (beside) continue;
    chosen.push_back(place.name);
    add_candidate({own_end(name, place.name), other_end(name, place.name), hit.similarity / expected});
  }
}

// What was found before a restart and not verified yet; what was verified in vain is found once more too, and pays out of the same budget.
bool LcdAgent::look_again(Utime now) {
  if (restored_.empty()) return false;
  const KeyframeName name = restored_.back();
  restored_.pop_back();
  look_for(name, robot_);
  ask(now);
  return true;
}

void LcdAgent::add_candidate(const Candidate& candidate) {
  const bool waits = std::any_of(waiting_.begin(), waiting_.end(), [&](const Candidate& other) {
    return other.own == candidate.own && other.other == candidate.other;
  });
  if (waits) return;  // found again after a restart, from its other end
  funnel_.count(candidate.other.robot, "candidate");
  if (is_redundant(candidate)) {
    funnel_.refuse(candidate.other.robot, "redundant");
    return;
  }
  insert_candidate(candidate);
}

// Kept in order, the most similar first.
void LcdAgent::insert_candidate(const Candidate& candidate) {
  const auto place =
      std::upper_bound(waiting_.begin(), waiting_.end(), candidate,
                       [](const Candidate& a, const Candidate& b) { return a.similarity > b.similarity; });
  waiting_.insert(place, candidate);
  if (static_cast<int>(waiting_.size()) > options_.waiting) {
    funnel_.refuse(waiting_.back().other.robot, "too_many");
    waiting_.pop_back();
  }
}

// Of two own keyframes the later one counts as the own end.
KeyframeName LcdAgent::own_end(const KeyframeName& a, const KeyframeName& b) const {
  if (a.robot != b.robot) return a.robot == robot_ ? a : b;
  return std::max(a, b);
}

KeyframeName LcdAgent::other_end(const KeyframeName& a, const KeyframeName& b) const {
  return own_end(a, b) == a ? b : a;
}

bool LcdAgent::is_redundant(const Candidate& candidate) const {
  const auto joint = joints_.find({candidate.own.segment, candidate.other.robot, candidate.other.segment});
  if (joint == joints_.end()) return false;
  return std::any_of(joint->second.begin(), joint->second.end(), [&](const std::pair<int, int>& ids) {
    return std::abs(ids.first - candidate.own.id) <= options_.redundant &&
           std::abs(ids.second - candidate.other.id) <= options_.redundant;
  });
}

const FrameFeatures* LcdAgent::features_of(const KeyframeName& name) const {
  const auto& features = name.robot == robot_ ? own_features_ : others_features_;
  const auto known = features.find(name);
  return known == features.end() ? nullptr : &known->second;
}

void LcdAgent::keep_features_of_other(const KeyframeName& name, FrameFeatures features) {
  if (others_features_.insert_or_assign(name, std::move(features)).second) others_order_.push_back(name);
  if (static_cast<int>(others_order_.size()) > options_.others_features) {
    others_features_.erase(others_order_.front());
    asking_.forget(others_order_.front());
    others_order_.pop_front();
  }
}

// For the most similar candidates whose features are not here.
void LcdAgent::ask(Utime now) {
  for (const Candidate& candidate : waiting_) {
    const KeyframeName& name = candidate.other;
    if (candidate.similarity < options_.ask_similarity) break;
    if (features_of(name) || !exchange_.present(name.robot, now) || is_redundant(candidate)) continue;
    if (asking_.ask(name, now)) funnel_.count(name.robot, "asked");
  }
  send_questions(now);
}

void LcdAgent::send_questions(Utime now) {
  for (const Asking::Question& question : asking_.take(now))
    std::visit([this](const auto& message) { outgoing_.emplace_back(message); }, question);
}

bool LcdAgent::can_verify(const Candidate& candidate) const {
  return !candidate.awaits_more && features_of(candidate.other) && features_of(candidate.own);
}

// Too few of another robot's best features agreed, and not so few that its others could not change that. Only while nothing joins the two
// trajectories: later the same bytes find more among keyframes that were not asked for yet.
bool LcdAgent::is_nearly_enough(const Candidate& candidate, const Verification& verification) const {
  if (candidate.other.robot == robot_ || verification.matches < options_.nearly_matches) return false;
  if (joints_.contains({candidate.own.segment, candidate.other.robot, candidate.other.segment})) return false;
  const std::string_view why = verification.refused;
  return why == "matches" || why == "five_point" || why == "three_point" || why == "inliers";
}

void LcdAgent::ask_for_more(Candidate candidate, Utime now) {
  const KeyframeName& name = candidate.other;
  if (!asking_.known(name)) {
    const auto known = static_cast<int>(features_of(name)->size());
    if (!exchange_.present(name.robot, now) || !asking_.ask_for_more(name, known, now)) return;
    funnel_.count(name.robot, "asked_more");
    send_questions(now);
  }
  candidate.awaits_more = true;
  insert_candidate(candidate);
}

const char* LcdAgent::take_more(const KeyframeName& name, const FrameFeatures& features) {
  const auto known = others_features_.find(name);
  // An answer to what was asked first, once more.
  if (known != others_features_.end() && features.size() > 0 &&
      features.descriptors.front() == known->second.descriptors.front())
    return "duplicate";
  asking_.end(name);
  if (known == others_features_.end() || features.size() == 0) {
    forget_candidates(name, "gone");
    return nullptr;
  }
  FrameFeatures& all = known->second;
  all.bearings_C.insert(all.bearings_C.end(), features.bearings_C.begin(), features.bearings_C.end());
  all.depths_m.insert(all.depths_m.end(), features.depths_m.begin(), features.depths_m.end());
  all.descriptors.insert(all.descriptors.end(), features.descriptors.begin(), features.descriptors.end());
  for (Candidate& candidate : waiting_) {
    if (candidate.other == name) candidate.awaits_more = false;
  }
  return nullptr;
}

void LcdAgent::forget_candidates(const KeyframeName& other, const char* why) {
  const auto n =
      std::erase_if(waiting_, [&](const Candidate& candidate) { return candidate.other == other; });
  funnel_.refuse(other.robot, why, static_cast<std::int64_t>(n));
}

void LcdAgent::verify_candidate(const Candidate& candidate, Utime now) {
  const auto [a, b] = std::minmax(candidate.own, candidate.other);
  const Verification verification = verify(*features_of(a), *features_of(b), options_.verification);
  count_steps(candidate.other.robot, verification);
  if (verification.refused) {
    if (is_nearly_enough(candidate, verification)) ask_for_more(candidate, now);
    return;
  }
  if (loops() >= options_.most_loops) return;
  loop_t loop = loop_message(a, b, verification, candidate.similarity);
  take_loop(loop, now);
  tell(now);
}

void LcdAgent::count_steps(int robot, const Verification& verification) {
  const int least = options_.verification.least_inliers;
  funnel_.count(robot, "verified");
  if (verification.matches >= options_.verification.least_matches) funnel_.count(robot, "matched");
  if (verification.five_point >= least) funnel_.count(robot, "five_point");
  if (verification.three_point >= least) funnel_.count(robot, "three_point");
  if (verification.inliers >= least) funnel_.count(robot, "refined");
  if (verification.refused) {
    funnel_.refuse(robot, verification.refused);
  } else {
    funnel_.count(robot, "accepted");
  }
}

void LcdAgent::take_loop(loop_t loop, Utime now) {
  loop.utime = now;
  loop.stream = stream_;
  loop.number = next_number_++;
  note_loop(loop);
  records_.emplace_back(loop);
  new_loops_.push_back(loop);
}

void LcdAgent::note_loop(const loop_t& loop) {
  const KeyframeName own = own_end(end_a(loop), end_b(loop));
  const KeyframeName other = other_end(end_a(loop), end_b(loop));
  joints_[{own.segment, other.robot, other.segment}].emplace_back(own.id, other.id);
  if (other.robot != robot_ && verifier_of(robot_, other.robot) == robot_) {
    untold_[loops_.size()] = {other.robot, 0, options_.repeat_loop_us};
  }
  loops_.push_back(loop);
}

void LcdAgent::tell(Utime now) {
  for (auto& [loop, untold] : untold_) {
    if (now < untold.again || !exchange_.present(untold.to, now)) continue;
    if (untold.again > 0) untold.period = std::min(2 * untold.period, 12 * options_.repeat_loop_us);
    untold.again = now + untold.period;
    lcd_loop_t message{};
    message.utime = now;
    message.from = robot_;
    message.to = untold.to;
    message.loop = loops_[loop];
    outgoing_.emplace_back(message);
  }
}

bool LcdAgent::spend_verification(Utime now) {
  const double grown = to_seconds(std::max<Utime>(0, now - allowance_at_)) * options_.verifications_per_s;
  allowance_ = std::min(allowance_ + grown, std::max(1.0, options_.verifications_per_s));
  allowance_at_ = now;
  if (allowance_ < 1.0) return false;
  allowance_ -= 1.0;
  return true;
}

}  // namespace covey::place
