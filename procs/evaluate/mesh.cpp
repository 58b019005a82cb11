// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/eval/ate.h"
#include "core/eval/mesh_score.h"
#include "core/eval/seen_surface.h"
#include "core/eval/surface_icp.h"
#include "procs/common/robot_config.h"
#include "procs/evaluate/commands.h"
#include "viewer_offscreen/ply.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

struct MeshOptions {
  std::vector<std::string> estimates;
  std::string reference;
  std::vector<std::string> trajectories;
  std::vector<std::string> truths;
  std::string align = "all";
  std::string alignment;
  bool icp = false;
  std::vector<std::string> seen_from;
  std::string config;
  double seen_within_m = 0.0;
  std::string placed;
  MeshScoreOptions score;
};

viewer::Mesh read_mesh(const std::string& file) {
  viewer::Mesh mesh = viewer::read_ply(file);
  if (mesh.faces.empty()) throw_input_error("{}: has no faces", file);
  return mesh;
}

void append(const viewer::Mesh& mesh, viewer::Mesh& whole) {
  const auto first = static_cast<std::uint32_t>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  whole.colours.insert(whole.colours.end(), mesh.colours.begin(), mesh.colours.end());
  whole.colours.resize(whole.vertices.size(), viewer::Rgb{200, 200, 200});
  whole.labels.insert(whole.labels.end(), mesh.labels.begin(), mesh.labels.end());
  whole.labels.resize(whole.vertices.size(), viewer::kFirstNoLabel);
  for (const auto& [a, b, c] : mesh.faces) whole.faces.push_back({first + a, first + b, first + c});
}

void move(viewer::Mesh& mesh, const SE3& T) {
  for (Eigen::Vector3f& p : mesh.vertices) p = (T * Eigen::Vector3d(p.cast<double>())).cast<float>();
}

// From the JSON that `evaluate trajectory` prints, or seven numbers.
SE3 read_alignment(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw_input_error("--alignment {}: cannot be read", file);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  std::vector<double> v;
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_object() && json.contains("T_reference_estimate") && json["T_reference_estimate"].is_array()) {
    for (const Json& each : json["T_reference_estimate"])
      v.push_back(each.is_number() ? each.get<double>() : NAN);
  } else {
    std::istringstream words(text);
    for (double number = 0.0; words >> number;) v.push_back(number);
  }
  const bool is_pose = v.size() == 7 &&
                       std::abs(Eigen::Vector4d(v[0], v[1], v[2], v[3]).norm() - 1.0) < 0.01 &&
                       Eigen::Vector3d(v[4], v[5], v[6]).allFinite();
  if (!is_pose) {
    throw_input_error("{}: neither JSON with T_reference_estimate nor seven numbers qw qx qy qz tx ty tz",
                      file);
  }
  return {SO3::from_quaternion({v[0], v[1], v[2], v[3]}), {v[4], v[5], v[6]}};
}

std::vector<TrajectoryPair> read_pairs(const MeshOptions& options) {
  if (options.trajectories.size() != options.truths.size()) {
    throw_input_error("--trajectory has {} files and --truth {}; give one truth for each trajectory",
                      options.trajectories.size(), options.truths.size());
  }
  std::vector<TrajectoryPair> pairs;
  for (std::size_t k = 0; k < options.truths.size(); ++k) {
    pairs.push_back({read_tum(options.trajectories[k]), read_tum(options.truths[k])});
  }
  return pairs;
}

SE3 first_pose_alignment(const std::vector<TrajectoryPair>& pairs, double max_difference_s) {
  for (const TrajectoryPair& pair : pairs) {
    const auto matches = match_stamps(pair.estimate, pair.reference, max_difference_s);
    if (matches.empty()) continue;
    const auto& [estimate, reference] = matches.front();
    return pair.reference[reference].pose * pair.estimate[estimate].pose.inverse();
  }
  return {};
}

SE3 placement(const MeshOptions& options) {
  if (!options.alignment.empty()) return read_alignment(options.alignment);
  if (options.trajectories.empty() && options.truths.empty()) return {};
  const std::vector<TrajectoryPair> pairs = read_pairs(options);
  const AteOptions ate;
  const TeamError error = team_error(pairs, ate);
  if (error.team.matched == 0) {
    throw_input_error("--trajectory and --truth have no stamps in common within {} s",
                      ate.max_stamp_difference_s);
  }
  if (options.align == "first") return first_pose_alignment(pairs, ate.max_stamp_difference_s);
  return error.team.T_reference_estimate;
}

struct Seen {
  std::vector<SurfacePoint> points;
  double share = 1.0;
};

Seen seen_of(const Surface& reference, const MeshOptions& options) {
  Seen seen{reference.sample(samples_per_m2(reference, options.score)), 1.0};
  if (options.seen_from.empty()) return seen;
  std::vector<Trajectory> ways;
  for (const std::string& file : options.seen_from) ways.push_back(read_tum(file));
  const Rig rig = load_robot_rig(options.config);
  if (!rig.depth) throw_input_error("{}: its sensors have no depth camera", options.config);
  DepthCamera camera = *rig.depth;
  if (options.seen_within_m > 0.0) camera.far_m = options.seen_within_m;
  viewer::Renderer renderer;
  const std::vector<bool> marks = seen_points(renderer, reference.mesh(), seen.points, ways, camera);
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (marks[i]) points.push_back(seen.points[i]);
  }
  seen.share = static_cast<double>(points.size()) / std::max<double>(1.0, static_cast<double>(marks.size()));
  seen.points = std::move(points);
  return seen;
}

Json to_json(const DistanceScore& score) {
  Json json = {{"mean_m", score.mean_m},
               {"median_m", score.median_m},
               {"rms_m", score.rms_m},
               {"samples", score.samples},
               {"samples_per_m2", score.per_m2}};
  for (std::size_t k = 0; k < kWithinM.size(); ++k) {
    json[fmt::format("within_{:.0f}_cm", 100.0 * kWithinM[k])] = score.within[k];
  }
  return json;
}

Json to_json(const SE3& T) {
  const Eigen::Quaterniond q = T.rotation.canonical_quaternion();
  return {q.w(), q.x(), q.y(), q.z(), T.translation.x(), T.translation.y(), T.translation.z()};
}

void print_mesh_score(const MeshOptions& options) {
  viewer::Mesh mesh;
  for (const std::string& file : options.estimates) append(read_mesh(file), mesh);
  SE3 T_reference_estimate = placement(options);
  move(mesh, T_reference_estimate);
  const Surface reference(read_mesh(options.reference));
  std::optional<IcpResult> icp;
  if (options.icp) {
    icp = align_surface(Surface(mesh), reference);
    move(mesh, icp->T_reference_estimate);
    T_reference_estimate = icp->T_reference_estimate * T_reference_estimate;
  }
  if (!options.placed.empty()) viewer::write_ply(options.placed, mesh);
  const Surface estimate(std::move(mesh));
  const Seen seen = seen_of(reference, options);
  const MeshScore score = score_mesh(estimate, reference, seen.points, seen.share, options.score);

  Json json = {{"error_m", score.error.mean_m}};
  if (score.completeness.samples > 0) json["completeness_m"] = score.completeness.mean_m;
  if (score.compared > 0) json.update({{"labels", score.labels}, {"labelled", score.labelled}});
  json.update({{"error", to_json(score.error)},
               {"completeness", to_json(score.completeness)},
               {"seen", score.seen},
               {"estimate_area_m2", estimate.area_m2()},
               {"reference_area_m2", reference.area_m2()},
               {"T_reference_estimate", to_json(T_reference_estimate)}});
  if (icp) {
    json["icp"] = {{"iterations", icp->iterations},
                   {"rms_m", icp->rms_m},
                   {"pairs", icp->pairs},
                   {"T_reference_placed", to_json(icp->T_reference_estimate)}};
  }
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_mesh_command(CLI::App& app) {
  auto options = std::make_shared<MeshOptions>();
  CLI::App* command =
      app.add_subcommand("mesh", "a mesh against the world's: distances both ways, and labels");
  command->add_option("--estimate", options->estimates, "PLY files in one frame; several are taken together")
      ->required();
  command->add_option("--reference", options->reference, "PLY file of the world")->required();
  auto* trajectory =
      command->add_option("--trajectory", options->trajectories,
                          "TUM files in the estimate's frame: their alignment with --truth places the mesh");
  command->add_option("--truth", options->truths, "TUM files in the reference's frame, one per trajectory")
      ->needs(trajectory);
  command->add_option("--align", options->align, "over all poses, or at the first")
      ->check(CLI::IsMember({"all", "first"}))
      ->capture_default_str();
  command
      ->add_option("--alignment", options->alignment,
                   "places the mesh: what `evaluate trajectory` prints, or qw qx qy qz tx ty tz of "
                   "T_reference_estimate")
      ->excludes(trajectory);
  command->add_flag("--icp", options->icp, "then align the surfaces too: hides what is wrong as a whole");
  auto* config = command->add_option("--config", options->config,
                                     "a robot's configuration, whose sensors name the depth camera");
  command
      ->add_option("--seen-from", options->seen_from,
                   "TUM files of true poses: completeness is of what the depth camera saw from there")
      ->needs(config);
  command->add_option("--seen-within-m", options->seen_within_m, "range, where shorter than the camera's")
      ->check(CLI::PositiveNumber);
  command->add_option("--samples", options->score.most_samples, "of either mesh, at most")
      ->check(CLI::Range(100, 20'000'000))
      ->capture_default_str();
  command->add_option("--samples-per-m2", options->score.samples_per_m2, "at most")
      ->check(CLI::Range(0.01, 1e6))
      ->capture_default_str();
  command->add_option("--placed", options->placed, "write the mesh, placed, to this PLY file");
  command->callback([options] { print_mesh_score(*options); });
}

}  // namespace covey
