// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The last few seconds of stereo pairs, to find those of a keyframe's stamp: vio names a keyframe some time after its images.

#include <covey/stereo_t.hpp>
#include <deque>

#include "core/base/time.h"

namespace covey {

class ImageBuffer {
 public:
  explicit ImageBuffer(Utime span_us) : span_us_(span_us) {}

  // What is older than the span, or from a future that a clock set back has taken away, goes.
  void add(const stereo_t& images) {
    std::erase_if(images_, [&](const stereo_t& other) {
      return other.utime < images.utime - span_us_ || other.utime >= images.utime;
    });
    images_.push_back(images);
  }

  // Null where they are not there.
  const stereo_t* find(Utime utime) const {
    for (const stereo_t& images : images_) {
      if (images.utime == utime) return &images;
    }
    return nullptr;
  }

 private:
  Utime span_us_;
  std::deque<stereo_t> images_;
};

}  // namespace covey
