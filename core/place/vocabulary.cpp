// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/vocabulary.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"

namespace covey::place {
namespace {

constexpr char kMagic[] = "COVEYVOC";
constexpr std::size_t kMagicBytes = 8;
constexpr std::uint32_t kFormat = 1;
constexpr std::size_t kHeadBytes = kMagicBytes + 2 * sizeof(std::uint32_t);
constexpr std::size_t kNodeBytes = 1 + kDescriptorBytes + sizeof(float);
constexpr std::size_t kHashBytes = sizeof(std::uint64_t);
static_assert(std::endian::native == std::endian::little, "vocabulary files are little-endian");

using FileBytes = std::vector<char>;

// FNV-1a.
std::uint64_t hash_of(std::span<const char> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char byte : bytes) hash = (hash ^ static_cast<std::uint8_t>(byte)) * 0x100000001b3ULL;
  return hash;
}

template <typename T>
void put(FileBytes& bytes, const T& value) {
  const char* raw = reinterpret_cast<const char*>(&value);
  bytes.insert(bytes.end(), raw, raw + sizeof(T));
}

template <typename T>
T get(const FileBytes& bytes, std::size_t& at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  at += sizeof(T);
  return value;
}

FileBytes bytes_of(const std::vector<Vocabulary::Node>& nodes) {
  FileBytes bytes(kMagic, kMagic + kMagicBytes);
  put(bytes, kFormat);
  put(bytes, static_cast<std::uint32_t>(nodes.size()));
  for (const Vocabulary::Node& node : nodes) {
    put(bytes, node.children);
    put(bytes, node.centre);
    put(bytes, node.weight);
  }
  return bytes;
}

// Every node but the root is the child of exactly one before it, and weights are what weights can be.
bool is_tree(const std::vector<Vocabulary::Node>& nodes) {
  std::size_t next = 1;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (k >= next) return false;
    next += nodes[k].children;
    if (!(nodes[k].weight >= 0.0F && nodes[k].weight < 1e6F)) return false;
  }
  return next == nodes.size() && nodes.size() > 1;
}

}  // namespace

Vocabulary::Vocabulary(std::vector<Node> nodes) : nodes_(std::move(nodes)) {
  COVEY_CHECK(is_tree(nodes_));
  hash_ = hash_of(bytes_of(nodes_));
  int next = 1;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    first_child_.push_back(next);
    word_of_.push_back(nodes_[k].children == 0 ? words_ : -1);
    if (nodes_[k].children == 0) {
      leaves_.push_back(static_cast<int>(k));
      ++words_;
    }
    next += nodes_[k].children;
  }
}

Vocabulary Vocabulary::load(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw_input_error("{}: this vocabulary cannot be read; key 'vocabulary' of section 'lcd' names the file",
                      file.string());
  }
  const FileBytes bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const auto refuse = [&](const char* why) {
    throw_input_error(
        "{}: not a vocabulary of Covey: {}; take the repository's configs/place/vocabulary.bin, or train one",
        file.string(), why);
  };
  if (bytes.size() < kHeadBytes + kHashBytes) refuse("it is too short");
  if (!std::equal(kMagic, kMagic + kMagicBytes, bytes.begin())) refuse("it begins with something else");
  std::size_t at = kMagicBytes;
  if (get<std::uint32_t>(bytes, at) != kFormat) refuse("its format is another");
  const std::size_t count = get<std::uint32_t>(bytes, at);
  if (bytes.size() != kHeadBytes + count * kNodeBytes + kHashBytes)
    refuse("its length is not what its head says");
  std::size_t end = bytes.size() - kHashBytes;
  if (hash_of(std::span(bytes).first(end)) != get<std::uint64_t>(bytes, end)) {
    refuse("it is damaged, its checksum differs");
  }
  std::vector<Node> nodes(count);
  for (Node& node : nodes) {
    node.children = get<std::uint8_t>(bytes, at);
    node.centre = get<Descriptor>(bytes, at);
    node.weight = get<float>(bytes, at);
  }
  if (!is_tree(nodes)) refuse("its nodes are not a tree");
  return Vocabulary(std::move(nodes));
}

void Vocabulary::save(const std::filesystem::path& file) const {
  FileBytes bytes = bytes_of(nodes_);
  put(bytes, hash_);
  std::ofstream stream(file, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!stream.flush()) throw_input_error("{}: cannot be written", file.string());
}

COVEY_COUNTS_BITS int Vocabulary::word(const Descriptor& descriptor) const {
  std::size_t node = 0;
  while (nodes_[node].children > 0) {
    const auto first = static_cast<std::size_t>(first_child_[node]);
    std::size_t nearest = first;
    int least = kDescriptorBits + 1;
    for (std::size_t child = first; child < first + nodes_[node].children; ++child) {
      const int distance = hamming(descriptor, nodes_[child].centre);
      if (distance < least) {
        least = distance;
        nearest = child;
      }
    }
    node = nearest;
  }
  return word_of_[node];
}

WordCounts Vocabulary::counts(std::span<const Descriptor> descriptors) const {
  std::map<int, int> found;
  for (const Descriptor& descriptor : descriptors) ++found[word(descriptor)];
  WordCounts counts;
  for (const auto& [word, count] : found) {
    if (!(weight(word) > 0.0)) continue;
    counts.words.push_back(word);
    counts.counts.push_back(count);
  }
  return counts;
}

BagOfWords Vocabulary::bag(const WordCounts& counts) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < counts.words.size(); ++k) sum += counts.counts[k] * weight(counts.words[k]);
  BagOfWords bag;
  for (std::size_t k = 0; k < counts.words.size(); ++k) {
    const double share = counts.counts[k] * weight(counts.words[k]) / sum;
    if (!(share > 0.0)) continue;
    bag.words.push_back(counts.words[k]);
    bag.weights.push_back(static_cast<float>(share));
  }
  return bag;
}

}  // namespace covey::place
