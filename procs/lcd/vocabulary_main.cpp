// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/common/tool.h"
#include "procs/lcd/vocabulary_tool.h"

int main(int argc, char** argv) {
  covey::VocabularyTool tool;
  CLI::App app{
      "trains lcd's vocabulary (hierarchical k-medians over the ORB features of images), or takes one of "
      "DBoW2's",
      "lcd_vocabulary"};
  auto* from = app.add_option_group("from")->require_option(1);
  from->add_option("SOURCE", tool.sources, "image files, folders of them, sensor logs (*.lcm)");
  from->add_option("--dbow2", tool.dbow2,
                   "a vocabulary of DBoW2's: text (ORBvoc.txt) or OpenCV's YAML, gzipped or not");
  app.add_option("--out", tool.out, "the vocabulary file to write")->required();
  app.add_option("--every", tool.every, "takes every Nth image of each source")->check(CLI::Range(1, 100000));
  app.add_option("--branching", tool.training.branching, "children of a node")
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  app.add_option("--depth", tool.training.depth, "levels of the tree")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  app.add_option("--seed", tool.training.seed, "the same images and seed give the same file")
      ->capture_default_str();
  return covey::run_tool(argc, argv, app, [&tool] { return tool.run(); });
}
