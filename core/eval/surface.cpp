// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

constexpr double kMostSites = 400'000.0;  // beside one for each face
constexpr double kSitesPerM2 = 100.0;
constexpr int kSitesLookedAt = 8;

double face_area(const viewer::Mesh& mesh, std::size_t face) {
  const auto& [a, b, c] = mesh.faces[face];
  const Eigen::Vector3d p = mesh.vertices[a].cast<double>();
  return 0.5 * (mesh.vertices[b].cast<double>() - p).cross(mesh.vertices[c].cast<double>() - p).norm();
}

}  // namespace

Surface::Surface(viewer::Mesh mesh, std::uint64_t seed) : mesh_(std::move(mesh)), seed_(seed), sites_({}) {
  COVEY_CHECK(!mesh_.faces.empty());
  for (std::size_t face = 0; face < mesh_.faces.size(); ++face) area_m2_ += face_area(mesh_, face);
  std::vector<Eigen::Vector3f> places;
  for (const SurfacePoint& site :
       spread(std::min(kSitesPerM2, kMostSites / std::max(area_m2_, 1e-9)), true)) {
    places.push_back(site.p);
    face_of_site_.push_back(site.face);
  }
  sites_ = KdTree(std::move(places));
}

SurfacePoint Surface::point_on(std::uint32_t face, const Eigen::Vector3f& weights) const {
  SurfacePoint point;
  point.face = face;
  int nearest = 0;
  weights.maxCoeff(&nearest);
  for (int i = 0; i < 3; ++i) point.p += weights[i] * mesh_.vertices[mesh_.faces[face][i]];
  if (!mesh_.labels.empty()) point.label = mesh_.labels[mesh_.faces[face][nearest]];
  return point;
}

// Walks over the faces, area after area, and sets a point wherever another 1 / per_m2 is full.
std::vector<SurfacePoint> Surface::spread(double per_m2, bool on_every_face) const {
  std::mt19937_64 random(seed_);
  std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
  std::vector<SurfacePoint> points;
  double due = 0.5;
  for (std::uint32_t face = 0; face < mesh_.faces.size(); ++face) {
    double count = face_area(mesh_, face) * per_m2;
    if (on_every_face && count < due)
      points.push_back(point_on(face, Eigen::Vector3f::Constant(1.0F / 3.0F)));
    for (; count >= due; due = 1.0) {
      count -= due;
      const float along = std::sqrt(uniform(random));
      const float across = uniform(random);
      points.push_back(point_on(face, {1.0F - along, along * (1.0F - across), along * across}));
    }
    due -= count;
  }
  return points;
}

std::vector<SurfacePoint> Surface::sample(double per_m2) const { return spread(per_m2, false); }

// Barycentric weights of the triangle's point nearest to p, by the region of the plane that p projects to. Source: Ericson,
// "Real-Time Collision Detection", 2005, section 5.1.5.
Eigen::Vector3f Surface::nearest_weights(std::uint32_t face, const Eigen::Vector3f& p) const {
  const auto& corners = mesh_.faces[face];
  const Eigen::Vector3d a = mesh_.vertices[corners[0]].cast<double>();
  const Eigen::Vector3d ab = mesh_.vertices[corners[1]].cast<double>() - a;
  const Eigen::Vector3d ac = mesh_.vertices[corners[2]].cast<double>() - a;
  const Eigen::Vector3d ap = p.cast<double>() - a;
  const auto weights = [](double b, double c) {
    return Eigen::Vector3f(static_cast<float>(1.0 - b - c), static_cast<float>(b), static_cast<float>(c));
  };
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return weights(0.0, 0.0);
  const double d3 = d1 - ab.squaredNorm();
  const double d4 = d2 - ab.dot(ac);
  if (d3 >= 0.0 && d4 <= d3) return weights(1.0, 0.0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return weights(d1 / (d1 - d3), 0.0);
  const double d5 = d1 - ab.dot(ac);
  const double d6 = d2 - ac.squaredNorm();
  if (d6 >= 0.0 && d5 <= d6) return weights(0.0, 1.0);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return weights(0.0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return weights(1.0 - w, w);
  }
  const double all = va + vb + vc;
  return all > 0.0 ? weights(vb / all, vc / all) : weights(0.0, 0.0);  // a triangle without area
}

NearestPoint Surface::nearest(const Eigen::Vector3f& p) const {
  std::vector<KdTree::Neighbour> near;
  sites_.nearest(p, kSitesLookedAt, near);
  NearestPoint nearest;
  nearest.distance_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < near.size(); ++k) {
    const std::uint32_t face = face_of_site_[near[k].index];
    const SurfacePoint point = point_on(face, nearest_weights(face, p));
    const double distance = (point.p - p).cast<double>().norm();
    if (distance < nearest.distance_m) nearest = {distance, point};
  }
  return nearest;
}

}  // namespace covey
