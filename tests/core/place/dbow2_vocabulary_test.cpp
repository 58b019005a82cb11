// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/dbow2_vocabulary.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <opencv2/core/persistence.hpp>

#include "core/base/error.h"
#include "tests/core/pgo/scratch.h"
#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using testing::RandomGeometry;

std::filesystem::path scratch_file(const std::string& name) {
  static const ScratchFolder kFolder;
  return kFolder.path / name;
}

std::filesystem::path written(const std::string& name, const std::string& text) {
  const auto file = scratch_file(name);
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

// Three levels of 1 to 4 children, some branches ending early.
std::vector<Vocabulary::Node> make_tree(std::uint64_t seed) {
  RandomGeometry random(seed);
  std::vector<Vocabulary::Node> nodes(1);
  std::vector<int> levels{0};
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const bool ends = levels[k] == 3 || (levels[k] > 0 && random.index(4) == 0);
    const int children = ends ? 0 : 1 + random.index(4);
    nodes[k].children = static_cast<std::uint8_t>(children);
    if (children == 0) nodes[k].weight = static_cast<float>(1 + random.index(64)) / 8.0F;
    for (int child = 0; child < children; ++child) {
      nodes.push_back({testing::random_descriptor(random), 0, 0.0F});
      levels.push_back(levels[k] + 1);
    }
  }
  return nodes;
}

struct Entry {
  int parent = 0;
  bool is_word = false;
  std::string descriptor;
  double weight = 0.0;
};

// DBoW2 numbers the children of a node, then those of its first child with all below, and so on.
void number_below(const std::vector<Vocabulary::Node>& nodes, const std::vector<int>& first, int node, int id,
                  std::vector<Entry>& entries) {
  const Vocabulary::Node& own = nodes[static_cast<std::size_t>(node)];
  const int begin = static_cast<int>(entries.size());
  for (int k = 0; k < own.children; ++k) {
    const auto child = static_cast<std::size_t>(first[static_cast<std::size_t>(node)] + k);
    std::string descriptor;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(nodes[child].centre.data());
    for (std::size_t byte = 0; byte < kDescriptorBytes; ++byte) descriptor += fmt::format("{} ", bytes[byte]);
    entries.push_back({id, nodes[child].children == 0, descriptor, nodes[child].weight});
  }
  for (int k = 0; k < own.children; ++k)
    number_below(nodes, first, first[static_cast<std::size_t>(node)] + k, begin + k + 1, entries);
}

std::vector<Entry> entries_of(const std::vector<Vocabulary::Node>& nodes) {
  std::vector<int> first;
  int next = 1;
  for (const auto& node : nodes) {
    first.push_back(next);
    next += node.children;
  }
  std::vector<Entry> entries;
  number_below(nodes, first, 0, 0, entries);
  return entries;
}

std::string text_of(const std::vector<Entry>& entries) {
  std::string text = "4 3  0 0\n";
  for (const Entry& entry : entries)
    text += fmt::format("{} {} {}{}\n", entry.parent, entry.is_word ? 1 : 0, entry.descriptor, entry.weight);
  return text;
}

// By OpenCV's own writer, as DBoW2 does.
void write_yaml(const std::filesystem::path& file, const std::vector<Entry>& entries) {
  cv::FileStorage storage(file.string(), cv::FileStorage::WRITE);
  storage << "vocabulary"
          << "{";
  storage << "k" << 4 << "L" << 3 << "scoringType" << 0 << "weightingType" << 0;
  storage << "nodes"
          << "[";
  for (std::size_t k = 0; k < entries.size(); ++k) {
    storage << "{:"
            << "nodeId" << static_cast<int>(k) + 1 << "parentId" << entries[k].parent;
    storage << "weight" << entries[k].weight << "descriptor" << entries[k].descriptor << "}";
  }
  storage << "]"
          << "words"
          << "[";
  int word = 0;
  for (std::size_t k = 0; k < entries.size(); ++k) {
    if (entries[k].is_word)
      storage << "{:"
              << "wordId" << word++ << "nodeId" << static_cast<int>(k) + 1 << "}";
  }
  storage << "]"
          << "}";
}

std::string refused_file(const std::filesystem::path& file) {
  try {
    read_dbow2(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string refused(const std::string& text) { return refused_file(written("refused.txt", text)); }

TEST_CASE("a vocabulary comes back from DBoW2's text and OpenCV's YAML, gzipped or not") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto nodes = make_tree(seed);
    const Vocabulary vocabulary(nodes);
    const auto entries = entries_of(nodes);
    REQUIRE(read_dbow2(written("v.txt", text_of(entries))).hash() == vocabulary.hash());
    for (const char* name : {"v.yml", "v.yml.gz"}) {
      write_yaml(scratch_file(name), entries);
      REQUIRE(read_dbow2(scratch_file(name)).hash() == vocabulary.hash());
    }
    read_dbow2(scratch_file("v.yml.gz")).save(scratch_file("v.bin"));
    REQUIRE(Vocabulary::load(scratch_file("v.bin")).hash() == vocabulary.hash());
  }
}

TEST_CASE("a bad file is refused with its line and the reason") {
  const std::string bytes =
      " 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 255 ";
  const std::string word = "0 1" + bytes + "1.5\n";
  REQUIRE(refused("2 1 0 0\n" + word + word) == "");
  REQUIRE(refused("2 1 0 0\r\n" + word + "\n\n") == "");
  REQUIRE_THAT(refused_file(scratch_file("none.txt")), Contains("none.txt"));
  REQUIRE_THAT(refused(""), EndsWith("refused.txt: the file is empty"));
  REQUIRE_THAT(refused("COVEYVOC"), Contains("refused.txt:1: neither"));
  REQUIRE_THAT(refused("1 1 0 0\n"), Contains(":1: k"));
  REQUIRE_THAT(refused("2 11 0 0\n"), Contains(":1: L"));
  REQUIRE_THAT(refused("2 1 6 0\n"), Contains(":1: the scoring"));
  REQUIRE_THAT(refused("2 1 0 0\n"), Contains("without nodes"));
  REQUIRE_THAT(refused("2 1 0 0\n" + word + "0 1 3\n"), Contains(":3: a node has 35"));
  REQUIRE_THAT(refused("2 1 0 0\n0 1" + bytes + "x\n"), Contains(":2: the weight is 'x'"));
  REQUIRE_THAT(refused("2 1 0 0\n0 1" + bytes + "nan\n"), Contains(":2: the weight"));
  REQUIRE_THAT(refused("2 1 0 0\n0 2" + bytes + "1\n"), Contains(":2: whether"));
  REQUIRE_THAT(refused("2 1 0 0\n0 1 256" + bytes.substr(2) + "1\n"), Contains(":2: a descriptor's byte"));
  REQUIRE_THAT(refused("2 1 0 0\n" + word + "7 1" + bytes + "1\n"), Contains(":3: node 2 has no parent 7"));
  REQUIRE_THAT(refused("2 1 0 0\n" + word + "1 1" + bytes + "1\n"), Contains(":2: node 1 is a word and has"));
  REQUIRE_THAT(refused("2 1 0 0\n0 0" + bytes + "0\n"), Contains(":2: node 1 is no word"));
  REQUIRE_THAT(refused("2 1 0 0\n" + word + "2 0" + bytes + "0\n"), Contains(":3: node 2 does not hang"));
  REQUIRE_THAT(refused("2 1 0 0\n0 1" + bytes + "0\n"), Contains("no word of this vocabulary has a weight"));

  const std::string head = "%YAML:1.0\n---\nvocabulary:\n   k: 2\n   L: 1\n   nodes:\n";
  const std::string node =
      "      - { nodeId:1, parentId:0, weight:1.,\n          descriptor:\"" + bytes + "\" }\n";
  const std::string words = "   words:\n      - { wordId:0, nodeId:1 }\n";
  REQUIRE(refused(head + node + words) == "");
  REQUIRE_THAT(refused("%YAML:1.0\nother: 3\n"), Contains(":2: 'vocabulary:'"));
  REQUIRE_THAT(refused("%YAML:1.0\n"), Contains("'vocabulary:'"));
  REQUIRE_THAT(refused(head + node), Contains("ends before its words"));
  REQUIRE_THAT(refused(head + "  - { nodeId:1, parentId:0"), Contains(":7: the file ends within an entry"));
  REQUIRE_THAT(refused(head + "  - { nodeId:1, weight:0. }\n"),
               Contains(":7: an entry should go on with 'par"));
  REQUIRE_THAT(refused(head + "  - 3 }\n"), Contains(":7: an entry should begin"));
  REQUIRE_THAT(refused(head + "  - { nodeId:1, parentId:0, weight:1., descriptor:\"1 2\" }\n"),
               Contains("2 bytes instead of 32"));
  REQUIRE_THAT(refused(head + "  - { nodeId:1, parentId:0, weight:1., descriptor:\"dbw3 0 32 1\" }\n"),
               Contains("byte is 'dbw3'"));
  REQUIRE_THAT(refused(head + node + node + words), Contains(":10: a second node 1"));
  REQUIRE_THAT(refused(head + node + "   words:\n - { wordId:0, nodeId:2 }\n"),
               Contains(":10: a word of node 2"));
  REQUIRE_THAT(refused(head + node + words + " - { wordId:1, nodeId:1 }\n"), Contains(":11: a second word"));
  REQUIRE_THAT(refused(head + node + words + "   more: 3\n"), Contains(":11: 'more:' is not expected"));
}

// Letters changed, lines left out, doubled and cut: refused or taken, never more.
TEST_CASE("no damage to a DBoW2 file makes the reader fail") {
  const auto entries = entries_of(make_tree(4));
  write_yaml(scratch_file("whole.yml"), entries);
  std::ifstream stream(scratch_file("whole.yml"));
  const std::string yaml((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  RandomGeometry random(1);
  int taken = 0;
  for (int k = 0; k < 1500; ++k) {
    std::string text = k % 2 == 0 ? text_of(entries) : yaml;
    for (int change = 1 + random.index(3); change > 0 && !text.empty(); --change) {
      const auto at = static_cast<std::size_t>(random.index(static_cast<int>(text.size())));
      const auto length = static_cast<std::size_t>(random.index(40));
      const int kind = random.index(4);
      if (kind == 0) text[at] = " 019-:,{}\"\nnx.%"[random.index(15)];
      if (kind == 1) text[at] = static_cast<char>(random.index(256));
      if (kind == 2) text.erase(at, length);
      if (kind == 3) text.insert(at, text.substr(static_cast<std::size_t>(at / 2), length));
    }
    taken += refused(text).empty() ? 1 : 0;
  }
  REQUIRE(taken > 10);
  REQUIRE(taken < 1000);
}

}  // namespace
}  // namespace covey::place
