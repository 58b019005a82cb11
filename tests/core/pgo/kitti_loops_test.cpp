// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/kitti_loops.h"

#include <zlib.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "scratch.h"
#include "tests/data.h"

using namespace covey;
using namespace covey::pgo;

namespace {

const std::string kGraph =
    "# space\nEDGE_SE2 10 11 1 0 0 4 0 0 4 0 9\nEDGE_SE2 11 12 1 0 0 4 0 0 4 0 9\nEDGE_SE2 12 10 0 0 0 4 0 0 "
    "4 0 9\n"
    "EDGE_SE2 12 10 -2 0 0 4 0 0 4 0 9\nEDGE_SE2 10 12 2 0 0 4 0 0 4 0 9\n";

std::string gzipped(const std::string& text) {
  const ScratchFile file;
  gzFile stream = gzopen(file.path.c_str(), "wb");
  gzwrite(stream, text.data(), static_cast<unsigned>(text.size()));
  gzclose(stream);
  std::ifstream read(file.path, std::ios::binary);
  return {std::istreambuf_iterator<char>(read), {}};
}

}  // namespace

TEST_CASE("gzipped graphs and lists read as plain ones") {
  const ScratchFile plain(kGraph);
  const ScratchFile packed(gzipped(kGraph));
  const G2oFile graph = read_g2o(packed.path);
  CHECK(graph.graph.edges.size() == read_g2o(plain.path).graph.edges.size());
  const ScratchFile list(gzipped("12 10\n"));
  CHECK(read_true_loops(list.path, graph) == std::vector<bool>{true, true, true, true, false});
}

TEST_CASE("a list of true loops that is not of this graph is refused by line") {
  const ScratchFile graph_file(kGraph);
  const G2oFile graph = read_g2o(graph_file.path);
  const auto refusal_of = [&](const std::string& text, const std::string& reason) {
    const ScratchFile list(text);
    CHECK(input_error_of([&] { read_true_loops(list.path, graph); }) == list.said(reason));
  };
  refusal_of("12 10\n13 10\n", ":2: the graph has no loop from vertex 13 to vertex 10");
  refusal_of("10 11\n", ":1: the graph has no loop from vertex 10 to vertex 11");  // odometry
  refusal_of("12 10 1\n", ":1: has 3 fields, not the two vertex ids of a true loop");
  refusal_of("12 ten\n",
             ":1: field 2 is 'ten', not a vertex id (a whole number from 0 to 9223372036854775807)");
}

TEST_CASE("a damaged gzipped file is refused") {
  std::string bytes = gzipped(kGraph);
  bytes.resize(bytes.size() / 2);
  const ScratchFile torn(bytes);
  CHECK_THAT(input_error_of([&] { read_g2o(torn.path); }),
             Catch::Contains(": the gzipped file is damaged: "));
}

TEST_CASE("truth is vertices, or the chain of the edges") {
  const ScratchFile chain(
      "EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n");
  const Poses poses = read_truth(chain.path);
  REQUIRE(poses.size() == 3);
  CHECK((poses[2].translation - Eigen::Vector3d(1, 1, 0)).norm() < 1e-9);
  const ScratchFile loops(kGraph);
  CHECK_THAT(input_error_of([&] { read_truth(loops.path); }), Catch::Contains("its edges are not one chain"));
}

TEST_CASE("KITTI's true loops are near the truth, and every wrong one measures no motion") {
  const auto folder = test_data("kitti_loops/06");
  if (!folder) return;
  const G2oFile file = read_g2o(*folder / "kitti_06_alpha_0.00.g2o.gz");
  const std::vector<bool> is_true = read_true_loops(*folder / "kitti_06_alpha_0.00_GT_LC.txt.gz", file);
  const Poses truth = read_truth(*folder / "kitti_06_GT.g2o.gz");
  REQUIRE(static_cast<int>(truth.size()) == file.graph.poses());
  int true_loops = 0;
  for (std::size_t e = 0; e < is_true.size(); ++e) {
    const Edge& edge = file.graph.edges[e];
    if (edge.kind != EdgeKind::kLoop) continue;
    true_loops += is_true[e] ? 1 : 0;
    REQUIRE(is_true[e] == (edge.measurement.translation.norm() > 0.0));
  }
  CHECK(true_loops == 45);
  CHECK(file.graph.loops() == 155);
}
