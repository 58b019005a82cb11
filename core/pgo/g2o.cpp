// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/g2o.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/geometry/se2.h"
#include "core/pgo/fields.h"

namespace covey::pgo {
namespace {

constexpr long kMaxId = std::numeric_limits<long>::max();

SE3 planar(double x, double y, double angle) {
  return {SO3::exp({0.0, 0.0, wrap_angle(angle)}), {x, y, 0.0}};
}

// The pose that begins at this field: x y theta, or x y z qx qy qz qw.
SE3 read_pose(const FieldReader& line, int field, int dimension) {
  if (dimension == 2) return planar(line.number(field), line.number(field + 1), line.number(field + 2));
  const Eigen::Quaterniond q(line.number(field + 6), line.number(field + 3), line.number(field + 4),
                             line.number(field + 5));
  if (!(std::abs(q.norm() - 1.0) <= 0.01)) line.refuse("the quaternion has norm {:.6g}, not 1", q.norm());
  return {SO3::from_quaternion(q), {line.number(field), line.number(field + 1), line.number(field + 2)}};
}

// The symmetric matrix whose upper triangle begins at this field, row by row.
Eigen::MatrixXd read_information(const FieldReader& line, int field, int size) {
  Eigen::MatrixXd information(size, size);
  for (int row = 0; row < size; ++row) {
    for (int column = row; column < size; ++column) {
      information(row, column) = information(column, row) = line.number(field++);
    }
  }
  // The cross terms between translation and rotation are not used, and cubicle has impossible ones.
  const int d = size / 2 + size % 2;
  if (information.topLeftCorner(d, d).llt().info() != Eigen::Success ||
      information.bottomRightCorner(size - d, size - d).llt().info() != Eigen::Success) {
    line.refuse("the information matrix is not positive definite");
  }
  return information;
}

// Rosen et al., SE-Sync, IJRR 2019: the isotropic precisions nearest to an information matrix.
void set_precisions(Edge& edge, const Eigen::MatrixXd& information, int dimension) {
  const int d = dimension;
  const auto trace_of_inverse = [](const Eigen::MatrixXd& m) {
    return m.llt().solve(Eigen::MatrixXd::Identity(m.rows(), m.cols())).trace();
  };
  edge.tau = d / trace_of_inverse(information.topLeftCorner(d, d));
  edge.kappa =
      d == 2 ? information(2, 2) : 3.0 / (2.0 * trace_of_inverse(information.bottomRightCorner(3, 3)));
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : line_(file, ' ') {
    while (line_.next()) read_line();
    if (edges_.empty())
      throw_input_error("{}: has no edge of a tag that is known (EDGE_SE2, EDGE_SE3:QUAT)", file.string());
  }

  G2oFile finish() {
    if (vertices_.empty()) {
      for (const auto& [from, to, edge, place] : edges_) vertices_[from], vertices_[to];
    }
    std::map<long, int> index;
    Poses start;
    for (const auto& [id, pose] : vertices_) {
      index.emplace(id, static_cast<int>(index.size()));
      file_.ids.push_back(id);
      if (pose) start.push_back(*pose);
    }
    if (start.size() == index.size()) file_.start = std::move(start);
    file_.graph.dimension = dimension_;
    file_.graph.poses_per_robot = {static_cast<int>(index.size())};
    for (auto& [from, to, edge, place] : edges_) {
      for (const long id : {from, to}) {
        if (!index.contains(id))
          throw_input_error("{}: the edge names vertex {}, which the file does not declare", place, id);
      }
      edge.from.index = index.at(from);
      edge.to.index = index.at(to);
      edge.known_inlier = edge.to.index == edge.from.index + 1;
      edge.kind = edge.known_inlier ? EdgeKind::kOdometry : EdgeKind::kLoop;
      file_.graph.edges.push_back(edge);
    }
    return std::move(file_);
  }

 private:
  struct RawEdge {
    long from;
    long to;
    Edge edge;
    std::string place;
  };

  void read_line() {
    const std::string_view tag = line_[0];
    if (tag == "VERTEX_SE2") return read_vertex(2);
    if (tag == "VERTEX_SE3:QUAT") return read_vertex(3);
    if (tag == "EDGE_SE2") return read_edge(2);
    if (tag == "EDGE_SE3:QUAT") return read_edge(3);
    if (tag != "FIX") ++file_.unknown_tags[std::string(tag)];
  }

  void expect(int dimension, int fields) {
    if (dimension_ == 0) dimension_ = dimension;
    if (dimension_ != dimension) line_.refuse("{} in a graph that is {}D so far", line_[0], dimension_);
    if (line_.size() != fields) line_.refuse("{} has {} fields, not {}", line_[0], line_.size(), fields);
  }

  void read_vertex(int dimension) {
    expect(dimension, dimension == 2 ? 5 : 9);
    const long id = line_.whole(1, "vertex id", 0, kMaxId);
    if (!vertices_.emplace(id, read_pose(line_, 2, dimension)).second)
      line_.refuse("vertex {} is declared twice", id);
  }

  void read_edge(int dimension) {
    expect(dimension, dimension == 2 ? 12 : 31);
    RawEdge raw{
        line_.whole(1, "vertex id", 0, kMaxId), line_.whole(2, "vertex id", 0, kMaxId), {}, line_.place()};
    if (raw.from == raw.to) line_.refuse("the edge joins vertex {} to itself", raw.from);
    raw.edge.measurement = read_pose(line_, 3, dimension);
    set_precisions(raw.edge, read_information(line_, dimension == 2 ? 6 : 10, dimension == 2 ? 3 : 6),
                   dimension);
    edges_.push_back(std::move(raw));
  }

  FieldReader line_;
  int dimension_ = 0;
  std::map<long, std::optional<SE3>> vertices_;
  std::vector<RawEdge> edges_;
  G2oFile file_;
};

std::string pose_fields(const SE3& T, int dimension) {
  const Eigen::Vector3d& t = T.translation;
  if (dimension == 2) return fmt::format("{:.17g} {:.17g} {:.17g}", t.x(), t.y(), T.rotation.log().z());
  const Eigen::Quaterniond q = T.rotation.canonical_quaternion();
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}", t.x(), t.y(), t.z(), q.x(),
                     q.y(), q.z(), q.w());
}

}  // namespace

G2oFile read_g2o(const std::filesystem::path& file) { return Reader(file).finish(); }

void write_g2o(const std::filesystem::path& file, const PoseGraph& graph, const std::optional<Poses>& poses) {
  std::ofstream stream(file);
  const int d = graph.dimension;
  const std::string space = d == 2 ? "SE2" : "SE3:QUAT";
  if (poses) {
    for (std::size_t i = 0; i < poses->size(); ++i) {
      stream << fmt::format("VERTEX_{} {} {}\n", space, i, pose_fields((*poses)[i], d));
    }
  }
  const std::vector<int> offsets = graph.offsets();
  const int size = d == 2 ? 3 : 6;
  for (const Edge& edge : graph.edges) {
    stream << fmt::format("EDGE_{} {} {} {}", space, offsets[edge.from.robot] + edge.from.index,
                          offsets[edge.to.robot] + edge.to.index, pose_fields(edge.measurement, d));
    for (int row = 0; row < size; ++row) {
      for (int column = row; column < size; ++column) {
        const double diagonal = row < d ? edge.tau : (d == 2 ? 1.0 : 2.0) * edge.kappa;
        stream << fmt::format(" {:.17g}", row == column ? diagonal : 0.0);
      }
    }
    stream << '\n';
  }
  stream.close();
  if (!stream) throw_input_error("{}: cannot be written", file.string());
}

}  // namespace covey::pgo
