// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/options.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey {
namespace {

pgo::AgentOptions read(const std::string& text) {
  Config config = Config::parse(text, "dpgo.yaml");
  const pgo::AgentOptions options = read_agent_options(config.root().section("dpgo"));
  config.check_all_read();
  return options;
}

TEST_CASE("the threshold is given as a probability or as itself") {
  REQUIRE(read("{}").dgnc.barc2 == Approx(16.812).epsilon(1e-4));
  REQUIRE(read("dpgo: {probability: 0.9}").dgnc.barc2 == Approx(10.645).epsilon(1e-4));
  REQUIRE(read("dpgo: {barc2: 100}").dgnc.barc2 == 100.0);
  REQUIRE(input_error_of([] { read("dpgo: {barc2: 100, probability: 0.9}"); }).find("not both") !=
          std::string::npos);
}

TEST_CASE("keys are read, with units and ranges") {
  const pgo::AgentOptions options = read("dpgo: {updates: 7, mu_step: 1.4, settle_s: 0.5}");
  REQUIRE(options.dgnc.updates == 7);
  REQUIRE(options.dgnc.mu_step == 1.4);
  REQUIRE(options.settle_us == 500'000);
  REQUIRE(input_error_of([] { read("dpgo: {mu_step: 0.5}"); }).find("mu_step") != std::string::npos);
  REQUIRE(input_error_of([] { read("dpgo: {no_such_key: 1}"); }).find("no_such_key") != std::string::npos);
}

TEST_CASE("the solver and what covariances count as are chosen by name") {
  REQUIRE(read("{}").dgnc.solver == pgo::RoundSolver::kDgnc);
  const pgo::DgncOptions full = read(
                                    "dpgo: {solver: elected, covariances: full, floor_rotation_sigma_deg: 1, "
                                    "floor_translation_sigma_m: 0.1}")
                                    .dgnc;
  REQUIRE(full.solver == pgo::RoundSolver::kElected);
  REQUIRE(full.full_covariances);
  REQUIRE(full.noise.floor_rotation_sigma == Approx(0.0174533));
  REQUIRE(full.noise.floor_translation_sigma == 0.1);
  REQUIRE(full.noise.floored_odometry);
  const pgo::NoiseOptions scaled = read("{}").dgnc.noise;
  REQUIRE_FALSE(scaled.floored_odometry);
  REQUIRE(scaled.floor_translation_sigma == 0.03);
  const pgo::DgncOptions paper = read("dpgo: {covariances: paper}").dgnc;
  REQUIRE(paper.noise.isotropic);
  REQUIRE(paper.barc2 == Approx(5.348).epsilon(1e-3));  // of probability 0.5
  REQUIRE(read("dpgo: {covariances: paper, probability: 0.99}").dgnc.barc2 == Approx(16.812).epsilon(1e-4));
  REQUIRE(input_error_of([] {
            read("dpgo: {solver: magic}");
          }).find("'magic' is not one of dgnc | elected") != std::string::npos);
  REQUIRE(input_error_of([] { read("dpgo: {covariances: full}"); }).find("wants solver: elected") !=
          std::string::npos);
}

}  // namespace
}  // namespace covey
