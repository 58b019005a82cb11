// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/truth_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "core/sim/contacts.h"
#include "core/sim/labels.h"
#include "procs/sim/interrupt.h"
#include "viewer_offscreen/ply.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) throw_input_error("{}: cannot be written", file.string());
}

std::string label_names() {
  Json names;
  for (std::size_t label = 0; label < sim::kLabelClasses.size(); ++label)
    names[std::to_string(label)] = sim::kLabelClasses[label].name;
  return names.dump(2) + "\n";
}

Trajectory trajectory(const sim::Ride& ride) {
  Trajectory poses;
  for (const ImuSample& sample : ride.imu.samples)
    poses.push_back({sample.utime, ride.motion.at(sample.utime).T_W_B});
  return poses;
}

double length_m(const Trajectory& poses) {
  double length = 0.0;
  for (std::size_t k = 1; k < poses.size(); ++k)
    length += (poses[k].pose.translation - poses[k - 1].pose.translation).norm();
  return length;
}

double rounded_mm(double metres) { return std::round(metres * 1e5) / 100.0; }

void add_evidence(Json& json, const sim::EurocEvidence& evidence) {
  json["truth_rms_mm"] = rounded_mm(evidence.truth_rms_m);
  json["misfit_median_mm"] = rounded_mm(evidence.misfit_median_m);
  json["misfit_max_mm"] = rounded_mm(evidence.misfit_max_m);
  json["tilt_deg"] = std::round(evidence.tilt_deg * 1e3) / 1e3;
  json["nodes"] = evidence.nodes;
  json["iterations"] = evidence.iterations;
}

}  // namespace

std::string format_states(const sim::Ride& ride) {
  std::string text =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z "
      "[],v_RS_R_x [m s^-1],"
      "v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],"
      "b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],b_a_RS_S_z [m s^-2]\n";
  for (std::size_t k = 0; k < ride.imu.samples.size(); ++k) {
    const Utime utime = ride.imu.samples[k].utime;
    const sim::MotionState state = ride.motion.at(utime);
    const Eigen::Vector3d& p = state.T_W_B.translation;
    const Eigen::Quaterniond q = state.T_W_B.rotation.canonical_quaternion();
    const Eigen::Vector3d& v = state.v_W;
    const Eigen::Vector3d& bg = ride.imu.biases[k].gyro;
    const Eigen::Vector3d& ba = ride.imu.biases[k].accel;
    fmt::format_to(
        std::back_inserter(text),
        "{},{:.9f},{:.9f},{:.9f},{:.12f},{:.12f},{:.12f},{:.12f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},"
        "{:.9f},{:.9f},{:.9f}\n",
        utime * 1000, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), bg.x(), bg.y(),
        bg.z(), ba.x(), ba.y(), ba.z());
  }
  return text;
}

void write_truth(const SimOptions& options, const sim::Scenario& scenario) {
  const std::filesystem::path& folder = options.truth;
  std::filesystem::create_directories(folder);
  viewer::write_ply(folder / "world.ply", scenario.world.mesh);
  write_text(folder / "labels.json", label_names());

  Json summary;
  summary["world"] = options.world;
  summary["robots"] = options.robots;
  summary["seconds"] = options.seconds;
  summary["seed"] = options.seed;
  summary["rides"] = Json::array();
  std::vector<sim::Motion> motions;
  for (int r = 0; r < scenario.robots; ++r) {
    throw_if_interrupted();
    const sim::Ride ride = scenario.ride(r);
    const Trajectory poses = trajectory(ride);
    write_tum(folder / fmt::format("robot{}.tum", r), poses);
    write_text(folder / fmt::format("robot{}.csv", r), format_states(ride));
    motions.push_back(ride.motion);
    Json json;
    json["id"] = r;
    if (!ride.name.empty()) json["sequence"] = ride.name;
    json["length_m"] = std::round(length_m(poses) * 100.0) / 100.0;
    if (ride.evidence) add_evidence(json, *ride.evidence);
    summary["rides"].push_back(json);
  }
  // Recorded motions end up to one sample apart.
  for (const sim::Motion& motion : motions) {
    for (sim::Motion& other : motions) other.end = std::min(other.end, motion.end);
  }
  write_text(folder / "contacts.yaml",
             sim::format_contacts(sim::find_contacts(motions, scenario.world.buildings_W)));
  write_text(folder / "sim.json", summary.dump(2) + "\n");
}

void write_smoothing_figures(const std::filesystem::path& data, const ImuNoise& imu,
                             const std::filesystem::path& file) {
  const std::filesystem::path motion = data / "euroc/motion";
  if (!std::filesystem::is_directory(motion))
    throw_input_error("{}: no such folder; --data needs EuRoC's IMU and ground truth there", motion.string());
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(motion)) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  Json rows = Json::array();
  for (const std::filesystem::path& folder : folders) {
    throw_if_interrupted();
    const sim::EurocSequence sequence = sim::read_euroc_sequence(folder);
    const Utime from = std::max(sequence.imu.front().utime, sequence.truth.front().utime);
    const Utime until = std::min(sequence.imu.back().utime, sequence.truth.back().utime);
    const std::string name = folder.filename().string();
    const sim::EurocMotion smoothed = sim::smooth_euroc(sequence, from, until, sim::euroc_options(name, imu));
    Json json;
    json["sequence"] = name;
    json["seconds"] = to_seconds(until - from);
    add_evidence(json, smoothed.evidence);
    fmt::print(
        "{:16} {:6.1f} s: {:5.2f} mm rms from the ground truth, misfit {:.2f} mm median, {:.2f} mm at most\n",
        name, to_seconds(until - from), 1e3 * smoothed.evidence.truth_rms_m,
        1e3 * smoothed.evidence.misfit_median_m, 1e3 * smoothed.evidence.misfit_max_m);
    rows.push_back(json);
  }
  write_text(file, Json{{"rows", rows}}.dump(2) + "\n");
}

}  // namespace covey
