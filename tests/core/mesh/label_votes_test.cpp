// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/label_votes.h"

#include <catch2/catch.hpp>
#include <initializer_list>

using namespace covey::mesh;

namespace {

LabelVotes votes_of(std::initializer_list<int> labels) {
  LabelVotes votes;
  for (const int label : labels) votes.observe(static_cast<std::uint8_t>(label));
  return votes;
}

}  // namespace

TEST_CASE("The posterior of a label is Bayes' rule by hand") {
  // p = 0.8, n = 5: an observation is right with 0.8, each other class has 0.05.
  const LabelModel model{.accuracy = 0.8, .classes = 5};
  CHECK(LabelVotes{}.posterior(3, model) == Approx(0.2));
  CHECK(votes_of({3}).posterior(3, model) == Approx(0.8));
  CHECK(votes_of({3}).posterior(1, model) == Approx(0.05));
  // 3, 3, 1: likelihoods 0.8^2 0.05 for 3, 0.05^2 0.8 for 1, 0.05^3 for each of the other three.
  const double of_3 = 0.8 * 0.8 * 0.05;
  const double of_1 = 0.05 * 0.05 * 0.8;
  const double sum = of_3 + of_1 + 3 * 0.05 * 0.05 * 0.05;
  CHECK(votes_of({3, 1, 3}).posterior(3, model) == Approx(of_3 / sum));
  CHECK(votes_of({3, 1, 3}).posterior(1, model) == Approx(of_1 / sum));
  CHECK(votes_of({3, 1, 3}).posterior(0, model) == Approx(0.05 * 0.05 * 0.05 / sum));
}

TEST_CASE("The majority of labels wins and an unknown label says nothing") {
  CHECK(LabelVotes{}.likeliest() == kUnknownLabel);
  CHECK(votes_of({255, 255}).likeliest() == kUnknownLabel);
  CHECK(votes_of({7, 255, 255, 255}).likeliest() == 7);
  CHECK(votes_of({7, 255}).posterior(7, {}) == votes_of({7}).posterior(7, {}));
  CHECK(votes_of({2, 9, 9, 2, 9}).likeliest() == 9);
  CHECK(votes_of({9, 2}).likeliest() == 2);
  CHECK(votes_of({0, 0, 1}).likeliest() == 0);
}

TEST_CASE("A label with a third of the votes is kept among many others, in any order") {
  LabelVotes votes;
  for (int i = 0; i < 60; ++i) {
    votes.observe(static_cast<std::uint8_t>(100 + (i * 7) % 20));
    votes.observe(static_cast<std::uint8_t>(50 + (i * 3) % 20));
    votes.observe(4);
  }
  CHECK(votes.likeliest() == 4);
}

TEST_CASE("Full counts keep their differences and an opinion can still change") {
  LabelVotes votes = votes_of({5, 5});
  for (int i = 0; i < 1000; ++i) votes.observe(8);
  CHECK(votes.count(8) == 255);
  CHECK(votes.count(5) == 0);
  for (int i = 0; i < 256; ++i) votes.observe(5);
  CHECK(votes.likeliest() == 5);  // 255 each, 8 has just lost one to the 256th
}
