// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/vocabulary_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <covey/band_t.hpp>
#include <covey/stereo_t.hpp>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>

#include "core/base/bands.h"
#include "core/base/error.h"
#include "core/place/dbow2_vocabulary.h"
#include "core/place/orb.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"
#include "procs/lcd/images.h"

namespace covey {
namespace {

using Images = std::vector<std::vector<place::Descriptor>>;
using TakeImage = std::function<void(const cv::Mat& grey)>;

std::vector<std::filesystem::path> image_files(const std::filesystem::path& source) {
  static const std::set<std::string> kKinds{".png", ".jpg", ".jpeg", ".webp", ".pgm"};
  static const std::set<std::string> kNoPictures{".depth", ".segm", ".label"};  // x.depth.png
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_regular_file(source)) return {source};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(source)) {
    const std::filesystem::path& file = entry.path();
    if (kKinds.contains(file.extension()) && !kNoPictures.contains(file.stem().extension()))
      files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  return files;
}

void read_log(const std::filesystem::path& file, const TakeImage& take) {
  BandAssembler assembler;
  LogReader reader(file.string(), [&](const std::string& channel, const Bytes& bytes) {
    band_t band{};
    if (channel != kStereo.name || !decode(bytes, band)) return;
    const auto whole = assembler.add(std::move(band)).message;
    stereo_t stereo{};
    if (!whole || !decode(*whole, stereo)) return;
    const auto pair = images_of(stereo);
    if (!pair) return;
    take(pair->left);
    if (!pair->right.empty()) take(pair->right);
  });
  while (reader.next_time()) reader.deliver();
}

void read_images(const std::filesystem::path& source, const TakeImage& take) {
  if (!std::filesystem::exists(source))
    throw_input_error("{}: there is no such file or folder", source.string());
  if (source.extension() == ".lcm") return read_log(source, take);
  for (const auto& file : image_files(source)) {
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    if (image.empty()) throw_input_error("{}: this is no image that can be read", file.string());
    take(image);
  }
}

}  // namespace

int VocabularyTool::run() const {
  const place::Vocabulary vocabulary = dbow2.empty() ? train() : place::read_dbow2(dbow2);
  vocabulary.save(out);
  fmt::print("{}: {} words, {} bytes, hash {:016x}\n", out.string(), vocabulary.words(),
             std::filesystem::file_size(out), vocabulary.hash());
  return 0;
}

place::Vocabulary VocabularyTool::train() const {
  cv::setNumThreads(1);
  Images images;
  std::size_t descriptors = 0;
  for (const auto& source : sources) {
    const std::size_t before = images.size();
    int seen = 0;
    read_images(source, [&](const cv::Mat& grey) {
      if (seen++ % every != 0) return;
      images.push_back(place::detect_orb(grey).descriptors);
      descriptors += images.back().size();
    });
    fmt::print("{}: {} of {} images\n", source.string(), images.size() - before, seen);
  }
  if (descriptors == 0) throw_input_error("no image has a feature: there is nothing to train from");
  fmt::print("{} descriptors of {} images\n", descriptors, images.size());
  return place::train_vocabulary(images, training);
}

}  // namespace covey
