// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/mesh_job.h"

#include <algorithm>
#include <utility>

namespace covey::mesh {
namespace {

constexpr std::size_t kVerticesPerPiece = 50'000;

}  // namespace

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
      if (next_ == p_W_.size()) stage_ = Stage::kDone;
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

}  // namespace covey::mesh
