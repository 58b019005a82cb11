// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loop_weights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

struct SamePoses {
  std::vector<std::size_t> edges;
  std::vector<SaidWeight> said;
};

struct Match {
  double distance;
  std::size_t edge;  // in SamePoses
  std::size_t said;
};

// Every edge with every weight, the nearest first; as lengths, so that far outliers do not outvote the others.
std::vector<Match> matches(const SamePoses& same, const std::vector<double>& residuals_sq) {
  std::vector<Match> all;
  for (std::size_t e = 0; e < same.edges.size(); ++e) {
    for (std::size_t s = 0; s < same.said.size(); ++s) {
      const double distance =
          std::abs(std::sqrt(residuals_sq[same.edges[e]]) - std::sqrt(same.said[s].residual_sq));
      all.push_back({std::isfinite(distance) ? distance : INFINITY, e, s});
    }
  }
  std::sort(all.begin(), all.end(), [](const Match& a, const Match& b) {
    return std::tie(a.distance, a.edge, a.said) < std::tie(b.distance, b.edge, b.said);
  });
  return all;
}

void decide(const SamePoses& same, const std::vector<double>& residuals_sq, std::vector<bool>& kept) {
  std::vector<bool> edge_has(same.edges.size(), false);
  std::vector<bool> said_has(same.said.size(), false);
  for (const Match& match : matches(same, residuals_sq)) {
    if (edge_has[match.edge] || said_has[match.said]) continue;
    edge_has[match.edge] = true;
    said_has[match.said] = true;
    kept[same.edges[match.edge]] = same.said[match.said].weight > 0.5;
  }
}

}  // namespace

std::vector<bool> kept_by_weights(const pgo::PoseGraph& graph, const std::vector<double>& residuals_sq,
                                  const std::vector<SaidWeight>& said) {
  COVEY_CHECK(residuals_sq.size() == graph.edges.size());
  std::map<std::pair<pgo::PoseId, pgo::PoseId>, SamePoses> closures;
  std::vector<bool> kept(graph.edges.size(), false);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const pgo::Edge& edge = graph.edges[e];
    kept[e] = edge.kind == pgo::EdgeKind::kOdometry;
    if (!kept[e]) closures[{edge.from, edge.to}].edges.push_back(e);
  }
  for (const SaidWeight& each : said) {
    const auto known = closures.find({each.from, each.to});
    if (known != closures.end()) known->second.said.push_back(each);
  }
  for (const auto& [poses, same] : closures) decide(same, residuals_sq, kept);
  return kept;
}

}  // namespace covey
