// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/png.h"

#include <png.h>

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

Image gradient(int width, int height) {
  Image image = {width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i) image.rgb.push_back(static_cast<std::uint8_t>(i * 7));
  return image;
}

TEST_CASE("an encoded picture has PNG's signature and decodes to the same bytes") {
  const Image image = gradient(13, 5);
  const std::vector<std::uint8_t> bytes = encode_png(image);
  CHECK(std::string(bytes.begin(), bytes.begin() + 8) == "\x89PNG\r\n\x1a\n");
  CHECK(bytes == encode_png(image));

  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()) != 0);
  CHECK(header.width == 13);
  CHECK(header.height == 5);
  header.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> decoded(PNG_IMAGE_SIZE(header));
  REQUIRE(png_image_finish_read(&header, nullptr, decoded.data(), 0, nullptr) != 0);
  CHECK(decoded == image.rgb);
}

TEST_CASE("a picture that cannot be written is named") {
  CHECK_THROWS_WITH(write_png("/nonexistent/a.png", gradient(2, 2)),
                    "/nonexistent/a.png: cannot be written; is its folder there and writable?");
}

}  // namespace
}  // namespace covey::viewer
