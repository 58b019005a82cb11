// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/vocabulary_training.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <random>
#include <set>
#include <utility>

#include "core/base/error.h"

namespace covey::place {
namespace {

using Members = std::vector<const Descriptor*>;

// [0, 1), the same on every standard library.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

std::vector<Descriptor> choose_centres(const Members& members, int k, std::mt19937_64& random) {
  std::vector<Descriptor> centres{
      *members[static_cast<std::size_t>(uniform(random) * static_cast<double>(members.size()))]};
  std::vector<double> squared(members.size(), 1e9);
  while (static_cast<int>(centres.size()) < k) {
    double sum = 0.0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      const double distance = hamming(*members[m], centres.back());
      squared[m] = std::min(squared[m], distance * distance);
      sum += squared[m];
    }
    if (sum == 0.0) break;  // every member is a centre
    double left = uniform(random) * sum;
    std::size_t chosen = 0;
    while (chosen + 1 < members.size() && (left -= squared[chosen]) >= 0.0) ++chosen;
    if (squared[chosen] == 0.0) continue;
    centres.push_back(*members[chosen]);
  }
  return centres;
}

Descriptor median(const Members& members) {
  std::array<int, kDescriptorBits> ones{};
  for (const Descriptor* member : members) {
    for (std::size_t bit = 0; bit < ones.size(); ++bit) {
      ones[bit] += static_cast<int>((*member)[bit / 64] >> (bit % 64) & 1);
    }
  }
  Descriptor centre{};
  for (std::size_t bit = 0; bit < ones.size(); ++bit) {
    if (2 * static_cast<std::size_t>(ones[bit]) > members.size())
      centre[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  return centre;
}

std::vector<Members> assign(const Members& members, const std::vector<Descriptor>& centres) {
  std::vector<Members> parts(centres.size());
  for (const Descriptor* member : members) {
    const auto nearest =
        std::min_element(centres.begin(), centres.end(), [member](const Descriptor& a, const Descriptor& b) {
          return hamming(*member, a) < hamming(*member, b);
        });
    parts[static_cast<std::size_t>(nearest - centres.begin())].push_back(member);
  }
  return parts;
}

struct Part {
  Descriptor centre;
  Members members;
};

// Into at most k parts, none empty; the centres are what a descriptor will be compared with.
std::vector<Part> split(const Members& members, const TrainingOptions& options, std::mt19937_64& random) {
  std::vector<Descriptor> centres = choose_centres(members, options.branching, random);
  std::vector<Members> parts = assign(members, centres);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    std::vector<Descriptor> moved;
    for (const Members& part : parts) {
      if (!part.empty()) moved.push_back(median(part));
    }
    if (moved == centres) break;
    centres = std::move(moved);
    parts = assign(members, centres);
  }
  std::vector<Part> result;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (!parts[k].empty()) result.push_back({centres[k], std::move(parts[k])});
  }
  return result;
}

void set_weights(std::vector<Vocabulary::Node>& nodes, const std::vector<std::vector<Descriptor>>& images) {
  const Vocabulary vocabulary(nodes);
  std::vector<int> images_with(static_cast<std::size_t>(vocabulary.words()), 0);
  for (const auto& image : images) {
    std::set<int> words;
    for (const Descriptor& descriptor : image) words.insert(vocabulary.word(descriptor));
    for (const int word : words) ++images_with[static_cast<std::size_t>(word)];
  }
  std::size_t word = 0;
  for (Vocabulary::Node& node : nodes) {
    if (node.children > 0) continue;
    const int seen = std::max(1, images_with[word++]);
    node.weight = static_cast<float>(std::log(static_cast<double>(images.size()) / seen));
  }
}

}  // namespace

Vocabulary train_vocabulary(const std::vector<std::vector<Descriptor>>& images,
                            const TrainingOptions& options) {
  struct Open {
    std::size_t node;
    int level;
    Members members;
  };
  std::mt19937_64 random(options.seed);
  std::vector<Vocabulary::Node> nodes(1);
  std::deque<Open> open(1);
  open.front() = {0, 0, {}};
  for (const auto& image : images) {
    for (const Descriptor& descriptor : image) open.front().members.push_back(&descriptor);
  }
  COVEY_CHECK(!open.front().members.empty());
  while (!open.empty()) {
    const Open next = std::move(open.front());
    open.pop_front();
    const bool small = static_cast<int>(next.members.size()) < options.least_to_split;
    if (next.level == options.depth || (next.level > 0 && small)) continue;
    std::vector<Part> parts = split(next.members, options, random);
    if (next.level > 0 && parts.size() < 2) continue;
    nodes[next.node].children = static_cast<std::uint8_t>(parts.size());
    for (Part& part : parts) {
      open.push_back({nodes.size(), next.level + 1, std::move(part.members)});
      nodes.push_back({part.centre, 0, 0.0F});
    }
  }
  set_weights(nodes, images);
  return Vocabulary(std::move(nodes));
}

}  // namespace covey::place
