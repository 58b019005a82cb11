// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/routes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "core/sim/random.h"

namespace covey::sim {
namespace {

using Cell = std::tuple<int, int, int>;  // a metre of lane: from junction, to junction, metre

struct Walk {
  std::vector<int> junctions;
  double start_m = 0.0;  // along the first street
};

struct Visit {
  Cell cell;
  Cell opposite;      // the same metre of street on the other lane
  double when = 0.0;  // share of the robot's way that is driven
};

struct Route {
  Walk walk;
  std::vector<Visit> visits;  // in order
};

Eigen::Vector2d right_of(const Eigen::Vector2d& direction) { return {direction.y(), -direction.x()}; }

// What a corner adds to the way: the right-hand lane is shorter to the right and longer to the left.
double turn_m(const Eigen::Vector2d& in, const Eigen::Vector2d& out, double lane_m) {
  return -2.0 * lane_m * out.dot(right_of(in));
}

class Streets {
 public:
  explicit Streets(const RoadGraph& roads) : roads_(roads), neighbours_(roads.junctions_W.size()) {
    for (const auto& [a, b] : roads.roads) {
      neighbours_[a].push_back(b);
      neighbours_[b].push_back(a);
    }
  }

  Eigen::Vector2d along(int from, int to) const {
    return (roads_.junctions_W[to] - roads_.junctions_W[from]).normalized();
  }
  double length(int from, int to) const { return (roads_.junctions_W[to] - roads_.junctions_W[from]).norm(); }
  const Eigen::Vector2d& junction(int k) const { return roads_.junctions_W[k]; }

  Walk random_walk(double length_m, Random& random) const {
    const auto& road = roads_.roads[random.below(static_cast<int>(roads_.roads.size()))];
    const bool back = random.chance(0.5);
    return go_on(road[back ? 1 : 0], road[back ? 0 : 1], length_m, random);
  }

  // One that begins on a street that another one took.
  Walk random_walk_after(const Walk& other, double length_m, Random& random) const {
    const int k = random.below(static_cast<int>(other.junctions.size()) - 1);
    return go_on(other.junctions[k], other.junctions[k + 1], length_m, random);
  }

  // The metres of lane that are driven on the first length_m of the way.
  Route route(const Walk& walk, double length_m, double lane_m) const {
    Route route{walk, {}};
    double driven_m = 0.0;
    double along_m = walk.start_m;
    for (std::size_t k = 0; k + 1 < walk.junctions.size(); ++k) {
      const int from = walk.junctions[k];
      const int to = walk.junctions[k + 1];
      if (k > 0) driven_m += turn_m(along(walk.junctions[k - 1], from), along(from, to), lane_m);
      for (; along_m < length(from, to); along_m += 1.0, driven_m += 1.0) {
        if (driven_m >= length_m) continue;
        route.visits.push_back({{from, to, static_cast<int>(along_m)},
                                {to, from, static_cast<int>(length(from, to) - along_m)},
                                driven_m / length_m});
      }
      along_m -= length(from, to);
    }
    return route;
  }

 private:
  Walk go_on(int first, int second, double length_m, Random& random) const {
    Walk walk{{first, second}, std::floor(length(first, second) * random.uniform(0.0, 0.9))};
    double done = length(first, second) - walk.start_m;
    while (done < length_m) {
      const int from = walk.junctions[walk.junctions.size() - 2];
      const int at = walk.junctions.back();
      std::vector<int> onwards;
      for (const int next : neighbours_[at]) {
        if (next != from) onwards.push_back(next);
      }
      COVEY_CHECK(!onwards.empty());
      walk.junctions.push_back(onwards[random.below(static_cast<int>(onwards.size()))]);
      done += length(at, walk.junctions.back());
    }
    return walk;
  }

  const RoadGraph& roads_;
  std::vector<std::vector<int>> neighbours_;
};

// How good a route is beside those that are chosen already.
class Judge {
 public:
  explicit Judge(const RouteOptions& options) : options_(options) {}

  void choose(const Route& route) {
    chosen_.emplace_back();
    for (const Visit& visit : route.visits) {
      chosen_.back()[visit.cell].push_back(visit.when);
      seen_.insert(visit.cell);
    }
  }

  double score(const Route& route) const {
    double score = 0.0;
    for (const auto& other : chosen_) score += score_with(route, other);
    std::set<Cell> own;
    int again = 0;
    int fresh = 0;
    for (const Visit& visit : route.visits) {
      if (!own.insert(visit.cell).second) {
        ++again;
      } else if (!seen_.contains(visit.cell)) {
        ++fresh;
      }
    }
    return score + kAgain * std::min<double>(again, options_.again_m) + kFresh * fresh;
  }

 private:
  // A metre shared is worth several that are new; sharing early is worth a little.
  static constexpr double kShared = 20.0;
  static constexpr double kAgain = 30.0;
  static constexpr double kFresh = 3.0;
  static constexpr double kEarly = 30.0;
  static constexpr double kCrash = 50.0;

  using Times = std::map<Cell, std::vector<double>>;

  int crashes(const Visit& visit, const Cell& cell, const Times& other, double headway) const {
    const auto found = other.find(cell);
    if (found == other.end()) return 0;
    return static_cast<int>(std::count_if(found->second.begin(), found->second.end(), [&](double then) {
      return std::abs(visit.when - then) < headway;
    }));
  }

  double score_with(const Route& route, const Times& other) const {
    const double headway = options_.headway_m / options_.lengths_m.front();
    int shared = 0;
    int crashed = 0;
    double met_at = 1.0;
    for (const Visit& visit : route.visits) {
      crashed += crashes(visit, visit.opposite, other, headway);
      const auto found = other.find(visit.cell);
      if (found == other.end()) continue;
      crashed += crashes(visit, visit.cell, other, headway);
      ++shared;
      met_at = std::min(met_at, std::max(visit.when, found->second.front()));
    }
    return kShared * std::min<double>(shared, options_.shared_m) - kEarly * met_at - kCrash * crashed;
  }

  RouteOptions options_;
  std::vector<Times> chosen_;  // when each cell is driven
  std::set<Cell> seen_;
};

// The lane's lines meet where both are lane_m to the right of their streets.
std::vector<Eigen::Vector3d> lane(const Streets& streets, const Walk& walk, double lane_m) {
  const auto on_ground = [](const Eigen::Vector2d& p) { return Eigen::Vector3d(p.x(), p.y(), 0.0); };
  const auto& at = walk.junctions;
  const Eigen::Vector2d first = streets.along(at[0], at[1]);
  std::vector<Eigen::Vector3d> corners = {
      on_ground(streets.junction(at[0]) + walk.start_m * first + lane_m * right_of(first))};
  for (std::size_t k = 1; k < at.size(); ++k) {
    const Eigen::Vector2d in = right_of(streets.along(at[k - 1], at[k]));
    const Eigen::Vector2d out = k + 1 < at.size() ? right_of(streets.along(at[k], at[k + 1])) : in;
    corners.push_back(on_ground(streets.junction(at[k]) + lane_m / (1.0 + in.dot(out)) * (in + out)));
  }
  return corners;
}

struct Team {
  std::vector<Walk> walks;
  double score = 0.0;
};

Team choose_team(const Streets& streets, const RouteOptions& options, int candidates, Random& random) {
  constexpr double kCutCorners = 1.25;  // a walk is at least so much longer than its lane
  Judge judge(options);
  Team team;
  for (const double length_m : options.lengths_m) {
    const double walk_m = kCutCorners * length_m + 10.0;
    Route best;
    double best_score = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < candidates; ++k) {
      const bool alone = team.walks.empty() || random.chance(0.3);
      const Walk walk =
          alone ? streets.random_walk(walk_m, random)
                : streets.random_walk_after(team.walks[random.below(static_cast<int>(team.walks.size()))],
                                            walk_m, random);
      const Route route = streets.route(walk, length_m, options.lane_m);
      const double score = judge.score(route);
      if (score <= best_score) continue;
      best = route;
      best_score = score;
    }
    judge.choose(best);
    team.walks.push_back(best.walk);
    team.score += best_score;
  }
  return team;
}

}  // namespace

std::vector<std::vector<Eigen::Vector3d>> choose_routes(const RoadGraph& roads, const RouteOptions& options) {
  COVEY_CHECK(!roads.roads.empty() && !options.lengths_m.empty());
  constexpr double kMostMetres = 2.5e6;  // that are looked at in all
  const Streets streets(roads);
  Random random(options.seed);
  const double longest_m = *std::max_element(options.lengths_m.begin(), options.lengths_m.end());
  const double routes_looked_at = kMostMetres / longest_m / static_cast<double>(options.lengths_m.size());
  const int candidates = std::clamp(static_cast<int>(routes_looked_at), 100, options.candidates);
  const int teams = std::clamp(static_cast<int>(routes_looked_at / candidates), 1, options.teams);
  Team best = choose_team(streets, options, candidates, random);
  for (int k = 1; k < teams; ++k) {
    Team team = choose_team(streets, options, candidates, random);
    if (team.score > best.score) best = std::move(team);
  }
  std::vector<std::vector<Eigen::Vector3d>> routes;
  for (const Walk& walk : best.walks) routes.push_back(lane(streets, walk, options.lane_m));
  return routes;
}

}  // namespace covey::sim
