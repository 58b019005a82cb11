// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/command.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/eval/ate.h"
#include "core/pgo/central.h"
#include "core/pgo/certificate.h"
#include "core/pgo/chi_square.h"
#include "core/pgo/cost.h"
#include "core/pgo/pcm.h"
#include "core/pgo/start.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

const Solver& solver_named(const std::string& name) {
  std::string known;
  for (const Solver& solver : all_solvers()) {
    if (solver.name == name) return solver;
    known += (known.empty() ? "" : ", ") + solver.name;
  }
  throw_input_error("--solver: '{}' is not a solver; there are {}", name, known);
}

std::string solvers_help() {
  std::string text = "one of";
  for (const Solver& solver : all_solvers())
    text += fmt::format("\n  {:<10} {}", solver.name, solver.summary);
  return text;
}

CLI::Validator positive() {
  const auto refuse = [](const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool good = !text.empty() && *end == '\0' && std::isfinite(value) && value > 0.0;
    return good ? std::string() : text + " is not a positive number";
  };
  return {refuse, "POSITIVE"};
}

struct Timed {
  Solution solution;
  double seconds = 0.0;  // of CPU
  double wall_seconds = 0.0;
};

Timed solve_timed(const Solver& solver, const pgo::PoseGraph& graph, const SolverOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  Timed timed;
  timed.solution = solver.solve(graph, options);
  timed.seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  if (timed.solution.team) timed.seconds -= timed.solution.team->watch_seconds;
  timed.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return timed;
}

// Against --reference, else against the optimum of the graph without the outliers that were added, in the form of the cost
// that the solver minimises.
std::optional<double> trajectory_error_of(const Problem& problem, const pgo::Poses& poses, bool robust) {
  std::optional<Trajectory> reference = problem.reference;
  if (!reference && problem.truth_known) {
    const pgo::PoseGraph& clean = problem.without_outliers;
    const pgo::PoseGraph form = robust ? pgo::robust_form(clean) : clean;
    reference = to_trajectory(pgo::solve_least_squares(form, pgo::chordal_start(form)).poses);
  }
  if (!reference) return std::nullopt;
  const TrajectoryError error = trajectory_error({to_trajectory(poses), *reference});
  if (error.matched == 0)
    throw_input_error("--reference: no stamp is that of a pose (pose k stands at k + 1 s)");
  return error.rmse_m;
}

// Of the weighted problem that was solved last; by the team where a team solved it.
void report_certificate(const pgo::PoseGraph& graph, const Solution& solution, bool robust, Json& json) {
  const std::clock_t begin = std::clock();
  const pgo::PoseGraph form = robust ? pgo::robust_form(graph) : graph;
  const pgo::Certificate certificate =
      pgo::certify(solution.team ? form : pgo::as_one_robot(form), solution.poses, solution.weights);
  json["certified_gap"] = certificate.gap;
  json["certified_eta"] = certificate.eta;
  json["certified_lower_bound"] = certificate.lower_bound;
  if (solution.team) json["certificate_bytes"] = certificate.bytes;
  json["certificate_seconds"] = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

struct SharedLoops {  // between robots
  int all = 0;
  int kept = 0;
};

SharedLoops shared_loops(const pgo::PoseGraph& graph, const std::vector<bool>& kept) {
  SharedLoops count;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].between_robots()) continue;
    ++count.all;
    count.kept += kept[e] ? 1 : 0;
  }
  return count;
}

// A character for each loop: 1 where it was kept.
std::string decisions(const pgo::PoseGraph& graph, const std::vector<bool>& kept) {
  std::string text;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (graph.edges[e].kind == pgo::EdgeKind::kLoop) text += kept[e] ? '1' : '0';
  }
  return text;
}

void write_json(const Json& json, const std::filesystem::path& file) {
  if (file.empty() || file == "-") {
    std::cout << json.dump(2) << std::endl;
    return;
  }
  std::ofstream stream(file);
  stream << json.dump(2) << std::endl;
  if (!stream) throw_input_error("--json: {} cannot be written", file.string());
}

}  // namespace

void PgoCommand::add_options(CLI::App& app) {
  app.add_option("--graph", problem_.graph, "F.g2o or F.g2o.gz, robot<i>.csv, or a folder of robot<i>.csv");
  app.add_option("--world", problem_.world,
                 "a graph made up by --seed instead: stata (three robots, hardly any loops between)");
  app.add_option("--robots", problem_.robots, "cut a g2o graph into this many ranges of poses")
      ->check(CLI::Range(1, 1000));
  app.add_option("--solver", solver_.name, solvers_help())->required();
  app.add_option("--schedule", solver_.schedule, "rbcd's order of updates; coloured where not said")
      ->transform(
          CLI::CheckedTransformer(pgo::schedules()).description("greedy|round-robin|coloured|asynchronous"));
  app.add_option("--outliers", problem_.outliers, "add random loops until this part of all loops is wrong")
      ->check(CLI::Range(0.0, 0.99));
  app.add_option("--seed", problem_.seed, "of the outliers and of what a solver draws")
      ->capture_default_str();
  auto* probability = app.add_option("--probability", probability_,
                                     "of a true loop lying below the threshold of robust solvers");
  probability->check(CLI::Range(1e-6, 1.0 - 1e-9))->capture_default_str();
  app.add_option("--barc2", solver_.barc2,
                 "the threshold itself: the largest squared residual of a true loop")
      ->check(positive())
      ->excludes(probability);
  app.add_option("--start", solver_.start,
                 "where l2 and gnc begin: chordal (l2's own), robust (gnc's own) or odometry")
      ->check(CLI::IsMember({"chordal", "robust", "odometry"}));
  app.add_option("--mu-step", solver_.mu_step,
                 "of dgnc: a fixed factor between its stages (the paper's is 1.4) instead of ten stages")
      ->check(CLI::Range(1.01, 100.0));
  auto* optimum = app.add_option("--optimum", solver_.optimum, "cost to compare with")->check(positive());
  app.add_option("--gap", solver_.gap,
                 "stop at this relative gap to --optimum; exit 1 where it is not reached")
      ->check(positive())
      ->needs(optimum);
  app.add_option("--reference", problem_.reference,
                 "poses to compare with: TUM (pose k at k + 1 s), g2o vertices, or g2o edges of one chain");
  app.add_flag("--certify", certify_, "prove how far the cost can be from the best there is");
  app.add_option(
      "--true-loops", problem_.true_loops,
      "the true loops of a g2o graph, a line with two vertex ids each: gives precision and recall");
  app.add_flag("--decisions", decisions_,
               "add to a robust solver's report which loops were kept, 1 or 0 each");
  app.add_option("--json", json_, "write the report here instead of stdout");
  app.add_option("--tum", tum_, "write the poses here, pose k at k + 1 s");
}

int PgoCommand::run() {
  const Solver& solver = solver_named(solver_.name);
  if (!solver_.start.empty() && !solver.any_start)
    throw_input_error("--start: {} has a start of its own; l2 and gnc have a choice", solver.name);
  const Problem problem = load_problem(problem_);
  const pgo::PoseGraph& graph = problem.graph;
  solver_.seed = problem_.seed;
  if (solver_.barc2 <= 0.0) {
    solver_.barc2 = pgo::chi_square_quantile(probability_, pgo::pose_degrees_of_freedom(graph.dimension));
  }

  const Timed timed = solve_timed(solver, graph, solver_);
  const Solution& solution = timed.solution;
  pgo::RobustCost robust = pgo::robust_cost(graph, solution.poses, solver_.barc2);
  if (!solution.kept.empty()) {
    robust.kept = solution.kept;
    robust.kept_loops = pgo::keep_edges(graph, solution.kept).loops();
  }
  const double cost = solver.robust ? robust.cost : pgo::cost(graph, solution.poses);

  Json json;
  json["solver"] = solver.name;
  json["dimension"] = graph.dimension;
  json["poses"] = graph.poses();
  json["edges"] = graph.edges.size();
  json["robots"] =
      std::count_if(graph.poses_per_robot.begin(), graph.poses_per_robot.end(), [](int n) { return n > 0; });
  json["cost"] = cost;
  if (solver_.optimum) json["gap"] = cost / *solver_.optimum - 1.0;
  json["iterations"] = solution.iterations;
  if (solution.converged) json["converged"] = *solution.converged;
  if (solution.team) {
    json["block_updates"] = solution.team->block_updates;
    json["rounds"] = solution.team->rounds;
    json["bytes_sent"] = solution.team->bytes_sent;
  }
  json["seconds"] = timed.seconds;
  json["wall_seconds"] = timed.wall_seconds;
  json["loops"] = robust.loops;
  if (solver.robust) {
    json["barc2"] = solver_.barc2;
    json["kept_loops"] = robust.kept_loops;
    const SharedLoops shared = shared_loops(graph, robust.kept);
    json["shared_loops"] = shared.all;
    json["kept_shared_loops"] = shared.kept;
    if (decisions_) json["decisions"] = decisions(graph, robust.kept);
    if (robust.loops > 0 && robust.kept_loops == 0) {
      fmt::print(
          stderr,
          "pgo: every one of {} loops was rejected: the threshold barc2 = {:.4g} is below their noise\n",
          robust.loops, solver_.barc2);
    }
    if (problem.truth_known) {
      const pgo::LoopScore score = pgo::score_loops(graph, robust.kept, problem.is_true);
      json["precision"] = score.precision;
      json["recall"] = score.recall;
    }
  }
  if (const auto ate = trajectory_error_of(problem, solution.poses, solver.robust)) json["ate_m"] = *ate;
  if (certify_) report_certificate(graph, solution, solver.robust, json);

  if (!tum_.empty()) write_tum(tum_, to_trajectory(solution.poses));
  write_json(json, json_);
  if (solver_.gap && !(cost <= *solver_.optimum * (1.0 + *solver_.gap))) {
    fmt::print(stderr, "pgo: the cost {:.9g} is not within {} of --optimum {:.9g}\n", cost, *solver_.gap,
               *solver_.optimum);
    return 1;
  }
  return 0;
}

}  // namespace covey
