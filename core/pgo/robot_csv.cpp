// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_csv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <numeric>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/pgo/fields.h"

namespace covey::pgo {
namespace {

constexpr std::array<const char*, 15> kColumns = {
    "robot_src", "pose_src", "robot_dst", "pose_dst",        "qx",    "qy", "qz", "qw", "tx", "ty",
    "tz",        "kappa",    "tau",       "is_known_inlier", "weight"};
constexpr long kMaxRobot = 999;
constexpr long kMaxPose = 9'999'999;
// Poses of all robots together, with edges or without: solvers hold something for each, so a small file must not
// ask for many.
constexpr std::int64_t kPosesAnyway = 10'000;
constexpr std::int64_t kPosesPerEdge = 100;
constexpr std::int64_t kMaxPoses = 10'000'000;

void check_header(FieldReader& line, const std::filesystem::path& file) {
  if (!line.next()) throw_input_error("{}: is empty", file.string());
  for (int i = 0; i < static_cast<int>(kColumns.size()); ++i) {
    if (i >= line.size() || line[i] != kColumns[i])
      line.refuse("column {} of the header is not '{}'", i + 1, kColumns[i]);
  }
}

Edge read_edge(const FieldReader& line) {
  if (line.size() != static_cast<int>(kColumns.size())) {
    line.refuse("has {} fields, not {}", line.size(), kColumns.size());
  }
  Edge edge;
  edge.from = {static_cast<int>(line.whole(0, "robot", 0, kMaxRobot)),
               static_cast<int>(line.whole(1, "pose", 0, kMaxPose))};
  edge.to = {static_cast<int>(line.whole(2, "robot", 0, kMaxRobot)),
             static_cast<int>(line.whole(3, "pose", 0, kMaxPose))};
  if (edge.from == edge.to)
    line.refuse("the edge joins pose {} of robot {} to itself", edge.from.index, edge.from.robot);
  const Eigen::Quaterniond q(line.number(7), line.number(4), line.number(5), line.number(6));
  if (!(std::abs(q.norm() - 1.0) <= 0.01)) line.refuse("the quaternion has norm {:.6g}, not 1", q.norm());
  edge.measurement = {SO3::from_quaternion(q), {line.number(8), line.number(9), line.number(10)}};
  edge.kappa = line.number(11);
  edge.tau = line.number(12);
  if (edge.kappa <= 0.0 || edge.tau <= 0.0)
    line.refuse("kappa and tau are {} and {}, not positive", edge.kappa, edge.tau);
  edge.known_inlier = line.whole(13, "truth value", 0, 1) == 1;
  const bool next = edge.from.robot == edge.to.robot && edge.to.index == edge.from.index + 1;
  edge.kind = next && edge.known_inlier ? EdgeKind::kOdometry : EdgeKind::kLoop;
  return edge;
}

struct PlacedEdge {
  Edge edge;
  int line = 0;
};

std::vector<PlacedEdge> read_file(const std::filesystem::path& file) {
  FieldReader line(file, ',');
  check_header(line, file);
  std::vector<PlacedEdge> edges;
  while (line.next()) edges.push_back({read_edge(line), line.line()});
  return edges;
}

// Who named a robot's largest index, and where.
struct LargestIndex {
  std::filesystem::path file;
  int line = 0;
};

void check_poses(const PoseGraph& graph, const std::vector<LargestIndex>& largest) {
  const auto poses =
      std::accumulate(graph.poses_per_robot.begin(), graph.poses_per_robot.end(), std::int64_t{0});
  const auto edges = static_cast<std::int64_t>(graph.edges.size());
  if (poses <= std::min(kMaxPoses, kPosesAnyway + kPosesPerEdge * edges)) return;
  const auto most = std::max_element(graph.poses_per_robot.begin(), graph.poses_per_robot.end());
  const auto robot = most - graph.poses_per_robot.begin();
  throw_input_error("{}:{}: pose {} of robot {} makes {} poses in all, too many for {} edges",
                    largest[robot].file.string(), largest[robot].line, *most - 1, robot, poses, edges);
}

// What makes two lines the same measurement.
std::array<double, 11> identity(const Edge& edge) {
  const Eigen::Quaterniond q = edge.measurement.rotation.canonical_quaternion();
  const Eigen::Vector3d& t = edge.measurement.translation;
  return {static_cast<double>(edge.from.robot),
          static_cast<double>(edge.from.index),
          static_cast<double>(edge.to.robot),
          static_cast<double>(edge.to.index),
          q.x(),
          q.y(),
          q.z(),
          q.w(),
          t.x(),
          t.y(),
          t.z()};
}

std::vector<std::filesystem::path> robot_files(const std::filesystem::path& file_or_folder) {
  if (!std::filesystem::is_directory(file_or_folder)) return {file_or_folder};
  static const std::regex kPattern("robot([0-9]{1,3})\\.csv");
  std::map<int, std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(file_or_folder)) {
    const std::string name = entry.path().filename().string();
    std::smatch match;
    if (std::regex_match(name, match, kPattern)) files[std::stoi(match[1])] = entry.path();
  }
  if (files.empty()) throw_input_error("{}: the folder has no robot<i>.csv", file_or_folder.string());
  std::vector<std::filesystem::path> paths;
  for (auto& [robot, path] : files) paths.push_back(std::move(path));
  return paths;
}

}  // namespace

PoseGraph read_robot_csv(const std::filesystem::path& file_or_folder) {
  PoseGraph graph;
  std::vector<LargestIndex> largest;  // per robot
  // The largest number of copies that any one file has: a measurement that a file repeats was made twice.
  std::map<std::array<double, 11>, int> known;
  for (const auto& file : robot_files(file_or_folder)) {
    std::map<std::array<double, 11>, int> here;
    for (const auto& [edge, line] : read_file(file)) {
      const int copies = ++here[identity(edge)];
      if (copies <= known[identity(edge)]) continue;
      known[identity(edge)] = copies;
      for (const PoseId id : {edge.from, edge.to}) {
        if (id.robot >= graph.robots()) {
          graph.poses_per_robot.resize(id.robot + 1, 0);
          largest.resize(id.robot + 1);
        }
        if (id.index < graph.poses_per_robot[id.robot]) continue;
        graph.poses_per_robot[id.robot] = id.index + 1;
        largest[id.robot] = {file, line};
      }
      graph.edges.push_back(edge);
    }
  }
  if (graph.edges.empty()) throw_input_error("{}: has no edges", file_or_folder.string());
  check_poses(graph, largest);
  return graph;
}

void write_robot_csv(const std::filesystem::path& folder, const PoseGraph& graph,
                     std::optional<int> only_robot) {
  COVEY_CHECK(graph.dimension == 3);
  std::error_code ignored;  // a folder that cannot be made shows below, when its files cannot be written
  std::filesystem::create_directories(folder, ignored);
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (only_robot && robot != *only_robot) continue;
    const std::filesystem::path file = folder / fmt::format("robot{}.csv", robot);
    std::ofstream stream(file);
    stream << fmt::format("{}\n", fmt::join(kColumns, ","));
    for (const Edge& edge : graph.edges) {
      if (edge.from.robot != robot && edge.to.robot != robot) continue;
      const Eigen::Quaterniond q = edge.measurement.rotation.canonical_quaternion();
      const Eigen::Vector3d& t = edge.measurement.translation;
      stream << fmt::format(
          "{},{},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{},1\n",
          edge.from.robot, edge.from.index, edge.to.robot, edge.to.index, q.x(), q.y(), q.z(), q.w(), t.x(),
          t.y(), t.z(), edge.kappa, edge.tau, edge.known_inlier ? 1 : 0);
    }
    stream.close();
    if (!stream) throw_input_error("{}: cannot be written", file.string());
  }
}

}  // namespace covey::pgo
