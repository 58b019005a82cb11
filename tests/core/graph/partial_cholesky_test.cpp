// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/partial_cholesky.h"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>

using namespace covey::graph;

namespace {

// Random cliques of two to four variables of different sizes, with random positive semi-definite blocks; and the same as one
// dense matrix.
struct World {
  std::vector<int> sizes;
  std::vector<int> offsets;
  std::vector<std::vector<int>> cliques;
  std::vector<Eigen::MatrixXd> blocks;
  std::vector<bool> kept;
  Eigen::VectorXd damping;
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};

World make_world(int variables, int cliques, double kept_share, int seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  World world;
  int size = 0;
  for (int v = 0; v < variables; ++v) {
    world.sizes.push_back(v % 3 == 0 ? 6 : v % 3 == 1 ? 3 : 1);
    world.offsets.push_back(size);
    size += world.sizes.back();
    world.kept.push_back(std::uniform_real_distribution<double>()(random) < kept_share);
  }
  world.damping = Eigen::VectorXd::Constant(size, 0.1);
  world.H = world.damping.asDiagonal();
  world.b = Eigen::VectorXd::NullaryExpr(size, [&] { return normal(random); });
  for (int c = 0; c < cliques; ++c) {
    std::vector<int> all(variables);
    std::iota(all.begin(), all.end(), 0);
    std::shuffle(all.begin(), all.end(), random);
    all.resize(std::min<std::size_t>(all.size(), 2 + c % 3));
    int rows = 0;
    for (const int v : all) rows += world.sizes[v];
    const Eigen::MatrixXd J = Eigen::MatrixXd::NullaryExpr(4, rows, [&] { return normal(random); });
    const Eigen::MatrixXd block = J.transpose() * J;
    int row = 0;
    for (const int v : all) {
      int column = 0;
      for (const int w : all) {
        world.H.block(world.offsets[v], world.offsets[w], world.sizes[v], world.sizes[w]) +=
            block.block(row, column, world.sizes[v], world.sizes[w]);
        column += world.sizes[w];
      }
      row += world.sizes[v];
    }
    world.cliques.push_back(std::move(all));
    world.blocks.push_back(block);
  }
  return world;
}

std::vector<int> rows_of(const World& world, bool kept) {
  std::vector<int> rows;
  for (std::size_t v = 0; v < world.sizes.size(); ++v) {
    if (world.kept[v] != kept) continue;
    for (int i = 0; i < world.sizes[v]; ++i) rows.push_back(world.offsets[v] + i);
  }
  return rows;
}

}  // namespace

TEST_CASE("a partial factorisation leaves the Schur complement and solves the whole") {
  for (int seed = 0; seed < 40; ++seed) {
    const World world = make_world(1 + seed, 3 * seed, (seed % 5) / 4.0, seed);
    PartialCholesky cholesky(world.sizes, world.cliques, world.kept);
    REQUIRE(cholesky.factorise(world.blocks, world.damping));

    const std::vector<int> e = rows_of(world, false);
    const std::vector<int> k = rows_of(world, true);
    REQUIRE(cholesky.kept_size() == static_cast<int>(k.size()));
    const Eigen::MatrixXd H_ee = world.H(e, e);
    const Eigen::MatrixXd H_ke = world.H(k, e);
    const Eigen::LDLT<Eigen::MatrixXd> inverse(H_ee);
    const Eigen::MatrixXd S = world.H(k, k) - H_ke * inverse.solve(H_ke.transpose());
    if (!k.empty()) {
      const Eigen::MatrixXd lower = (cholesky.schur() - S).triangularView<Eigen::Lower>();
      CHECK(lower.cwiseAbs().maxCoeff() < 1e-9);
    }
    Eigen::VectorXd x = cholesky.forward(world.b);
    if (!k.empty()) {
      const Eigen::VectorXd reduced = world.b(k) - H_ke * inverse.solve(world.b(e));
      CHECK((x.tail(cholesky.kept_size()) - reduced).cwiseAbs().maxCoeff() < 1e-9);
      x.tail(cholesky.kept_size()) = S.ldlt().solve(reduced);
    }
    if (!e.empty()) {
      CHECK(x.head(cholesky.size() - cholesky.kept_size()).squaredNorm() ==
            Approx(world.b(e).dot(inverse.solve(world.b(e)))));
    }
    CHECK((cholesky.backward(x) - world.H.ldlt().solve(world.b)).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a factorisation is repeated with other values") {
  World world = make_world(30, 60, 0.2, 1);
  PartialCholesky cholesky(world.sizes, world.cliques, world.kept);
  REQUIRE(cholesky.factorise(world.blocks, world.damping));
  const Eigen::MatrixXd S = cholesky.schur().triangularView<Eigen::Lower>();
  for (Eigen::MatrixXd& block : world.blocks) block *= 3.0;
  REQUIRE(cholesky.factorise(world.blocks, 3.0 * world.damping));
  const Eigen::MatrixXd again = cholesky.schur().triangularView<Eigen::Lower>();
  CHECK((again - 3.0 * S).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a matrix that is not positive definite is not factorised") {
  World world = make_world(10, 10, 0.2, 2);
  PartialCholesky cholesky(world.sizes, world.cliques, world.kept);
  CHECK_FALSE(cholesky.factorise(world.blocks, -world.damping));
  CHECK(cholesky.factorise(world.blocks, world.damping));
}
