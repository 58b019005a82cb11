// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/label_classes.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey::viewer {
namespace {

TEST_CASE("label classes: names, customary colours, own colours, and none") {
  const ScratchFile file(R"({"0": "ground", "3": "kiosk", "7": {"name": "tree", "colour": "#010203"}})");
  const LabelClasses classes = read_label_classes(file.path);
  CHECK(classes.size() == 3);
  CHECK(label_class(classes, 0).name == "ground");
  CHECK(label_class(classes, 0).colour != label_colour(0));
  CHECK(label_class(classes, 3).colour == label_colour(3));
  CHECK(label_class(classes, 7).colour == Rgb{1, 2, 3});
  CHECK(label_class(classes, 9).name == "label 9");
  CHECK(label_class({}, 9).colour == label_colour(9));
}

TEST_CASE("label classes: what is refused names the file and the key") {
  const auto refusal = [](const std::string& text) {
    const ScratchFile file(text);
    const std::string said = input_error_of([&] { read_label_classes(file.path); });
    CHECK(said.find(file.path.string()) == 0);
    return said;
  };
  CHECK(refusal(R"({"road": 1})").find("'road'") != std::string::npos);
  CHECK(refusal("[1, 2]").find("number: name") != std::string::npos);
  CHECK_FALSE(refusal(R"({"1": )").empty());
  CHECK_FALSE(refusal(R"({"1": {"colour": "#000000"}})").empty());
  CHECK_FALSE(input_error_of([] { read_label_classes("/nowhere.json"); }).empty());
}

}  // namespace
}  // namespace covey::viewer
