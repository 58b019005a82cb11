// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The largest set of vertices that are all joined to each other, in an undirected graph kept as rows of bits.
//
// exact    branch and bound: a clique takes at most one vertex of each colour, so the colours that a greedy colouring of the
//          candidates needs bound what they can add; candidates of the highest colours are tried first. Vertices begin in
//          degeneracy order, and start from the greedy clique. Exponential in the worst case, hence the time limit.
//          Source: San Segundo, Rodriguez-Losada, Jimenez, "An exact bit-parallel algorithm for the maximum clique problem",
//          Computers and Operations Research 2011; the bound: Tomita and Seki, DMTCS 2003.
// greedy   from every vertex, always on to the candidate with most neighbours; the best of these. Polynomial, and what PCM
//          does in practice. Source: Pattabiraman, Patwary, Gebremedhin, Liao, Choudhary, "Fast algorithms for the maximum
//          clique problem on massive graphs", WAW 2013, algorithm 2.
//
// The same graph gives the same clique, but for an exact search that its time limit ends.

#include <cstdint>
#include <functional>
#include <vector>

namespace covey::pgo {

class BitGraph {
 public:
  BitGraph() = default;
  explicit BitGraph(int size);

  int size() const { return static_cast<int>(rows_.size()); }
  int add_vertex();  // its number
  void join(int a, int b);
  bool joined(int a, int b) const { return (rows_[a][b / 64] >> (b % 64) & 1) != 0; }
  int degree(int vertex) const;
  const std::vector<std::uint64_t>& row(int vertex) const { return rows_[vertex]; }

 private:
  std::vector<std::vector<std::uint64_t>> rows_;  // all of one length
};

struct CliqueOptions {
  bool exact = true;
  // The time of the exact search is limited where the caller lends a clock: s since whenever, preferably of this process's CPU.
  std::function<double()> clock{};
  double time_limit_s = 5.0;
};

struct Clique {
  std::vector<int> vertices;  // ascending
  bool exact = false;         // no larger one exists
  std::int64_t branches = 0;  // of the exact search
};

Clique greedy_clique(const BitGraph& graph);
Clique maximum_clique(const BitGraph& graph, const CliqueOptions& options = {});

}  // namespace covey::pgo
