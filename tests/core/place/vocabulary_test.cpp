// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/vocabulary.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <numeric>

#include "core/base/error.h"
#include "core/place/database.h"
#include "core/place/vocabulary_training.h"
#include "tests/core/pgo/scratch.h"
#include "tests/core/place/places.h"

namespace covey::place {
namespace {

using testing::RandomGeometry;

// Images that show 12 of 40 things each, a thing a cloud of descriptors.
std::vector<std::vector<Descriptor>> make_images(int images, std::uint64_t seed) {
  RandomGeometry things_random(1);
  std::vector<Descriptor> things;
  for (int k = 0; k < 40; ++k) things.push_back(testing::random_descriptor(things_random));
  RandomGeometry random(seed);
  std::vector<std::vector<Descriptor>> result(static_cast<std::size_t>(images));
  for (auto& image : result) {
    for (int k = 0; k < 120; ++k) {
      const auto thing = static_cast<std::size_t>((random.index(3) + k / 10 * 3) % 40);
      image.push_back(testing::disturbed(things[thing], 15, random));
    }
  }
  return result;
}

const Vocabulary& vocabulary() {
  static const Vocabulary kVocabulary =
      train_vocabulary(make_images(60, 2), {.branching = 5, .depth = 3, .least_to_split = 10});
  return kVocabulary;
}

std::filesystem::path scratch(const std::string& name) {
  static const ScratchFolder kFolder;
  return kFolder.path / name;
}

std::string refusal(const std::filesystem::path& file) {
  try {
    Vocabulary::load(file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("training gives the asked shape, the same twice, and another with another seed") {
  REQUIRE(vocabulary().words() >= 35);
  REQUIRE(vocabulary().words() <= 125);
  const TrainingOptions options{.branching = 5, .depth = 3, .least_to_split = 10};
  REQUIRE(train_vocabulary(make_images(60, 2), options).hash() == vocabulary().hash());
  TrainingOptions other = options;
  other.seed = 2;
  REQUIRE(train_vocabulary(make_images(60, 2), other).hash() != vocabulary().hash());
}

TEST_CASE("a thing's descriptors share words, other things have others") {
  RandomGeometry random(5);
  int same = 0;
  int mixed = 0;
  const auto images = make_images(60, 2);
  for (int k = 0; k < 200; ++k) {
    const Descriptor& thing = images[0][static_cast<std::size_t>(random.index(120))];
    const Descriptor& other = images[0][static_cast<std::size_t>(random.index(120))];
    same += vocabulary().word(thing) == vocabulary().word(testing::disturbed(thing, 4, random)) ? 1 : 0;
    mixed += hamming(thing, other) > 60 && vocabulary().word(thing) == vocabulary().word(other) ? 1 : 0;
  }
  REQUIRE(same > 120);
  REQUIRE(mixed < 10);
}

TEST_CASE("a bag is normalised, ascending, and most similar to itself") {
  const auto images = make_images(10, 7);
  for (const auto& image : images) {
    const BagOfWords bag = vocabulary().bag(image);
    REQUIRE(std::accumulate(bag.weights.begin(), bag.weights.end(), 0.0) == Approx(1.0).epsilon(1e-5));
    REQUIRE(std::adjacent_find(bag.words.begin(), bag.words.end(), std::greater_equal<>()) ==
            bag.words.end());
    REQUIRE(similarity(bag, bag) == Approx(1.0).epsilon(1e-5));
    for (const auto& other : images) {
      const BagOfWords another = vocabulary().bag(other);
      REQUIRE(similarity(bag, another) == similarity(another, bag));
      REQUIRE(similarity(bag, another) <= 1.0 + 1e-6);
      // The definition: 1 - |v - w|_1 / 2.
      std::map<int, double> difference;
      for (std::size_t k = 0; k < bag.words.size(); ++k) difference[bag.words[k]] += bag.weights[k];
      for (std::size_t k = 0; k < another.words.size(); ++k)
        difference[another.words[k]] -= another.weights[k];
      double l1 = 0.0;
      for (const auto& [word, value] : difference) l1 += std::abs(value);
      REQUIRE(similarity(bag, another) == Approx(1.0 - 0.5 * l1).margin(1e-5));
    }
  }
  REQUIRE(vocabulary().bag(std::vector<Descriptor>{}).words.empty());
  REQUIRE(similarity({}, vocabulary().bag(images[0])) == 0.0);
}

TEST_CASE("words that few images have weigh more") {
  const auto images = make_images(60, 2);
  std::vector<int> seen(static_cast<std::size_t>(vocabulary().words()), 0);
  for (const auto& image : images) {
    for (const int word : vocabulary().bag(image).words) ++seen[static_cast<std::size_t>(word)];
  }
  for (int word = 0; word < vocabulary().words(); ++word) {
    const int n = seen[static_cast<std::size_t>(word)];
    if (n > 0) REQUIRE(vocabulary().weight(word) == Approx(std::log(60.0 / n)).margin(1e-6));
  }
}

TEST_CASE("the inverted index finds what looking at all finds") {
  const auto images = make_images(80, 9);
  PlaceDatabase database;
  for (const auto& image : images) database.add(vocabulary().bag(image));
  REQUIRE(database.size() == 80);
  for (const double least : {0.0, 0.2, 0.6}) {
    for (int query = 0; query < 10; ++query) {
      const BagOfWords bag = vocabulary().bag(make_images(10, 11)[static_cast<std::size_t>(query)]);
      std::map<int, double> expected;
      for (int entry = 0; entry < database.size(); ++entry) {
        const double s = similarity(bag, database.bag(entry));
        if (s > 0.0 && s >= least) expected[entry] = s;
      }
      const auto hits = database.query(bag, least);
      REQUIRE(hits.size() == expected.size());
      double last = 2.0;
      for (const auto& hit : hits) {
        REQUIRE(hit.similarity == Approx(expected.at(hit.entry)).margin(1e-6));
        REQUIRE(hit.similarity <= last);
        last = hit.similarity;
      }
    }
  }
}

TEST_CASE("a vocabulary comes back from its file as it was") {
  const auto file = scratch("good.bin");
  vocabulary().save(file);
  const Vocabulary loaded = Vocabulary::load(file);
  REQUIRE(loaded.hash() == vocabulary().hash());
  REQUIRE(loaded.words() == vocabulary().words());
  const auto images = make_images(3, 13);
  for (const auto& image : images) {
    REQUIRE(loaded.bag(image).words == vocabulary().bag(image).words);
    REQUIRE(loaded.bag(image).weights == vocabulary().bag(image).weights);
  }
}

TEST_CASE("files that are no vocabulary are refused in words") {
  const auto good = scratch("good.bin");
  vocabulary().save(good);
  std::ifstream stream(good, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const auto refused = [&](const std::string& content) {
    const auto file = scratch("bad.bin");
    std::ofstream(file, std::ios::binary) << content;
    const std::string why = refusal(file);
    REQUIRE_THAT(why, Catch::Matchers::Contains("bad.bin"));
    return why;
  };
  REQUIRE_THAT(refusal(scratch("none.bin")), Catch::Matchers::Contains("cannot be read"));
  REQUIRE_THAT(refused(""), Catch::Matchers::Contains("too short"));
  REQUIRE_THAT(refused("x" + bytes), Catch::Matchers::Contains("begins with something else"));
  REQUIRE_THAT(refused(bytes.substr(0, bytes.size() - 1)), Catch::Matchers::Contains("length"));
  REQUIRE_THAT(refused(bytes + "x"), Catch::Matchers::Contains("length"));
  RandomGeometry random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::string damaged = bytes;
    const auto at = static_cast<std::size_t>(random.index(static_cast<int>(bytes.size())));
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random.index(8)));
    REQUIRE_FALSE(refused(damaged).empty());
  }
}

TEST_CASE("the vocabulary of the repository is good") {
  const Vocabulary shipped =
      Vocabulary::load(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/place/vocabulary.bin");
  REQUIRE(shipped.words() > 5000);
  REQUIRE(std::filesystem::file_size(std::filesystem::path(COVEY_SOURCE_DIR) /
                                     "configs/place/vocabulary.bin") <= 1000000);
}

}  // namespace
}  // namespace covey::place
