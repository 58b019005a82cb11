// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/max_clique.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

using Bits = std::vector<std::uint64_t>;

std::size_t words_for(int size) { return (static_cast<std::size_t>(size) + 63) / 64; }

void insert(Bits& bits, int k) { bits[k / 64] |= std::uint64_t{1} << (k % 64); }
void erase(Bits& bits, int k) { bits[k / 64] &= ~(std::uint64_t{1} << (k % 64)); }

int count(const Bits& bits) {
  return std::accumulate(bits.begin(), bits.end(), 0,
                         [](int sum, std::uint64_t word) { return sum + std::popcount(word); });
}

// The first bit that is set at k or after it; -1 for none.
int next(const Bits& bits, int k) {
  std::size_t word = static_cast<std::size_t>(k) / 64;
  if (word >= bits.size()) return -1;
  std::uint64_t rest = bits[word] & (~std::uint64_t{0} << (k % 64));
  while (rest == 0) {
    if (++word == bits.size()) return -1;
    rest = bits[word];
  }
  return static_cast<int>(64 * word) + std::countr_zero(rest);
}

void intersect(const Bits& a, const Bits& b, Bits& both) {
  for (std::size_t w = 0; w < both.size(); ++w) both[w] = a[w] & b[w];
}

// Vertices from the densest part of the graph to the thinnest: backwards, each has the fewest neighbours among those
// before it. Also how many it has.
struct Degeneracy {
  std::vector<int> order;
  std::vector<int> core;  // per vertex: no clique with it is larger than core + 1
};
Degeneracy degeneracy_of(const BitGraph& graph) {
  const int n = graph.size();
  std::vector<int> degree(n);
  std::vector<bool> taken(n, false);
  for (int v = 0; v < n; ++v) degree[v] = graph.degree(v);
  Degeneracy result{std::vector<int>(n), std::vector<int>(n)};
  int core = 0;
  for (int place = n - 1; place >= 0; --place) {
    int thinnest = -1;
    for (int v = 0; v < n; ++v) {
      if (!taken[v] && (thinnest < 0 || degree[v] < degree[thinnest])) thinnest = v;
    }
    taken[thinnest] = true;
    core = std::max(core, degree[thinnest]);
    result.order[place] = thinnest;
    result.core[thinnest] = core;
    const Bits& row = graph.row(thinnest);
    for (int v = next(row, 0); v >= 0; v = next(row, v + 1)) --degree[v];
  }
  return result;
}

class Search {
 public:
  // Cliques with at most `known` vertices are of no interest.
  Search(BitGraph graph, std::size_t known, const CliqueOptions& options)
      : graph_(std::move(graph)), options_(options), known_(known), levels_(graph_.size() + 1) {
    if (options_.clock) end_ = options_.clock() + options_.time_limit_s;
  }

  void run() {
    Bits all(words_for(graph_.size()), 0);
    for (int v = 0; v < graph_.size(); ++v) insert(all, v);
    expand(all, 0);
  }

  const std::vector<int>& best() const {
    return best_;
  }  // empty: there is nothing larger than what was known
  bool complete() const { return !out_of_time_; }
  std::int64_t branches() const { return branches_; }

 private:
  struct Level {  // scratch of one depth of the recursion
    Bits uncoloured;
    Bits colour_class;
    Bits candidates;
    std::vector<int> order;   // candidates that may lead to a larger clique
    std::vector<int> colour;  // their colours, from 1, ascending
  };

  void expand(Bits& candidates, std::size_t depth) {
    Level& level = levels_[depth];
    colour(candidates, level);
    for (std::size_t k = level.order.size(); k-- > 0;) {
      if (clique_.size() + level.colour[k] <= known_ || is_out_of_time()) return;
      const int v = level.order[k];
      clique_.push_back(v);
      level.candidates.resize(candidates.size());
      intersect(candidates, graph_.row(v), level.candidates);
      if (next(level.candidates, 0) >= 0) {
        expand(level.candidates, depth + 1);
      } else if (clique_.size() > known_) {
        known_ = clique_.size();
        best_ = clique_;
      }
      clique_.pop_back();
      erase(candidates, v);
    }
  }

  // Colour by colour, each a set of vertices no two of which are joined. Those of the first colours cannot lead to anything
  // larger than what is known and are not listed.
  void colour(const Bits& candidates, Level& level) const {
    level.order.clear();
    level.colour.clear();
    level.uncoloured = candidates;
    const auto hopeless = static_cast<std::ptrdiff_t>(known_) - static_cast<std::ptrdiff_t>(clique_.size());
    for (int colour = 1; next(level.uncoloured, 0) >= 0; ++colour) {
      level.colour_class = level.uncoloured;
      for (int v = next(level.colour_class, 0); v >= 0; v = next(level.colour_class, v + 1)) {
        erase(level.uncoloured, v);
        const Bits& row = graph_.row(v);
        for (std::size_t w = static_cast<std::size_t>(v) / 64; w < row.size(); ++w)
          level.colour_class[w] &= ~row[w];
        if (colour > hopeless) {
          level.order.push_back(v);
          level.colour.push_back(colour);
        }
      }
    }
  }

  bool is_out_of_time() {
    constexpr std::int64_t kBranchesBetweenLooks = 256;
    if (++branches_ % kBranchesBetweenLooks == 0 && options_.clock) out_of_time_ = options_.clock() > end_;
    return out_of_time_;
  }

  BitGraph graph_;
  const CliqueOptions& options_;
  std::size_t known_;
  std::vector<Level> levels_;
  std::vector<int> clique_;
  std::vector<int> best_;
  double end_ = 0.0;
  bool out_of_time_ = false;
  std::int64_t branches_ = 0;
};

}  // namespace

BitGraph::BitGraph(int size) : rows_(size, Bits(words_for(size), 0)) {}

int BitGraph::add_vertex() {
  const std::size_t words = words_for(size() + 1);
  if (!rows_.empty() && rows_.front().size() < words) {
    for (Bits& row : rows_) row.resize(words, 0);
  }
  rows_.emplace_back(words, 0);
  return size() - 1;
}

void BitGraph::join(int a, int b) {
  COVEY_CHECK(a != b);
  insert(rows_[a], b);
  insert(rows_[b], a);
}

int BitGraph::degree(int vertex) const { return count(rows_[vertex]); }

Clique greedy_clique(const BitGraph& graph) {
  const int n = graph.size();
  std::vector<int> degree(n);
  for (int v = 0; v < n; ++v) degree[v] = graph.degree(v);
  std::vector<int> starts(n);
  std::iota(starts.begin(), starts.end(), 0);
  std::stable_sort(starts.begin(), starts.end(), [&](int a, int b) { return degree[a] > degree[b]; });
  Clique best;
  for (const int start : starts) {
    if (degree[start] < static_cast<int>(best.vertices.size())) break;
    std::vector<int> clique = {start};
    Bits candidates = graph.row(start);
    while (next(candidates, 0) >= 0 && clique.size() + count(candidates) > best.vertices.size()) {
      int densest = next(candidates, 0);
      for (int v = densest; v >= 0; v = next(candidates, v + 1)) {
        if (degree[v] > degree[densest]) densest = v;
      }
      clique.push_back(densest);
      intersect(candidates, graph.row(densest), candidates);
    }
    if (clique.size() > best.vertices.size()) best.vertices = std::move(clique);
  }
  std::sort(best.vertices.begin(), best.vertices.end());
  best.exact = n <= 1;
  return best;
}

Clique maximum_clique(const BitGraph& graph, const CliqueOptions& options) {
  Clique clique = greedy_clique(graph);
  if (!options.exact || clique.exact) return clique;
  // What is left of the graph where a larger clique could be, densest vertices first.
  const Degeneracy degeneracy = degeneracy_of(graph);
  std::vector<int> vertices;
  for (const int v : degeneracy.order) {
    if (degeneracy.core[v] >= static_cast<int>(clique.vertices.size())) vertices.push_back(v);
  }
  BitGraph rest(static_cast<int>(vertices.size()));
  for (int a = 0; a < rest.size(); ++a) {
    for (int b = 0; b < a; ++b) {
      if (graph.joined(vertices[a], vertices[b])) rest.join(a, b);
    }
  }
  Search search(std::move(rest), clique.vertices.size(), options);
  search.run();
  clique.exact = search.complete();
  clique.branches = search.branches();
  if (!search.best().empty()) {
    clique.vertices.clear();
    for (const int v : search.best()) clique.vertices.push_back(vertices[v]);
    std::sort(clique.vertices.begin(), clique.vertices.end());
  }
  return clique;
}

}  // namespace covey::pgo
