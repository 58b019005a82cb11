// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/mesh_job.h"

#include <algorithm>
#include <utility>

namespace covey::mesh {
namespace {

constexpr std::size_t kVerticesPerPiece = 50'000;

double longest_edge(const Face& face, std::span<const Eigen::Vector3f> p) {
  const auto& [a, b, c] = face;
  return std::max({(p[a] - p[b]).norm(), (p[b] - p[c]).norm(), (p[c] - p[a]).norm()});
}

}  // namespace

std::vector<Face> whole_faces(const MeasuredMesh& mesh, std::span<const Eigen::Vector3f> p_W,
                              const TearOptions& options) {
  std::vector<Face> whole;
  whole.reserve(mesh.faces.size());
  for (const Face& face : mesh.faces) {
    const double limit = options.factor * longest_edge(face, mesh.p_O) + options.beyond_m;
    if (longest_edge(face, p_W) <= limit) whole.push_back(face);
  }
  return whole;
}

MeshJob::MeshJob(MeshSnapshot snapshot, const DeformationOptions& options)
    : snapshot_(std::move(snapshot)), options_(options), p_W_(snapshot_.mesh.p_O.size()) {}

bool MeshJob::advance() {
  switch (stage_) {
    case Stage::kSimplify:
      deformation_.emplace(snapshot_.mesh, snapshot_.keyframes, options_);
      stage_ = Stage::kSolve;
      break;
    case Stage::kSolve:
      if (!deformation_->step()) stage_ = Stage::kMove;
      break;
    case Stage::kMove:
      move_some();
      if (next_ < p_W_.size()) break;
      cut();
      stage_ = Stage::kDone;
      break;
    case Stage::kDone:
      break;
  }
  return stage_ != Stage::kDone;
}

void MeshJob::move_some() {
  const std::size_t count = std::min(kVerticesPerPiece, p_W_.size() - next_);
  deformation_->move(std::span(snapshot_.mesh.p_O).subspan(next_, count),
                     std::span(snapshot_.mesh.seen_by).subspan(next_, count),
                     std::span(p_W_).subspan(next_, count));
  next_ += count;
}

void MeshJob::cut() {
  std::vector<Face> whole = whole_faces(snapshot_.mesh, p_W_);
  torn_ = static_cast<int>(snapshot_.mesh.faces.size() - whole.size());
  snapshot_.mesh.faces = std::move(whole);
}

}  // namespace covey::mesh
