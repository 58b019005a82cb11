// SPDX-License-Identifier: BSD-3-Clause
// The process: what it writes, and the sentence and exit code for what it refuses.

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/child_process.h"
#include "viewer_offscreen/ply.h"

namespace covey::viewer {
namespace {

struct Outcome {
  int exit_code = -1;
  std::string text;
};

// A folder of its own, with a trajectory, a mesh and loops in it.
class Bench {
 public:
  Bench() {
    std::string pattern = (std::filesystem::temp_directory_path() / "covey_viewer_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    write("a.tum", "# t x y z q\n1.0 0 0 0 0 0 0 1\n2.0 3 1 0 0 0 0 1\n");
    write("loops.csv", "x0,y0,z0,x1,y1,z1,status\n0,0,0,3,1,0,accepted\n# a comment\n0 0 0 1 1 0 rejected\n");
    write_ply(path("m.ply"), {{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {}, {1, 1, 1}, {{0, 1, 2}}});
  }
  ~Bench() { std::filesystem::remove_all(folder_); }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  Outcome run(std::vector<std::string> arguments) const {
    ChildProcess process("viewer_offscreen", std::move(arguments), path("log"));
    const std::optional<int> exit_code = process.wait(60.0);
    return {exit_code.value_or(-1), read_text(path("log"))};
  }
  // With the least that makes a picture.
  Outcome run_with(std::vector<std::string> more) const {
    more.insert(more.end(), {"--size", "320x320", "--trajectory", "a=" + path("a.tum")});
    return run(std::move(more));
  }

 private:
  std::filesystem::path folder_;
};

bool is_png(const std::string& file) { return read_text(file).starts_with("\x89PNG\r\n\x1a\n"); }

TEST_CASE("both views are written beside each other, one view under its own name") {
  const Bench bench;
  const Outcome both = bench.run_with({"--mesh", bench.path("m.ply"), "--loops", bench.path("loops.csv"),
                                       "--reference", bench.path("a.tum"), "--out", bench.path("p.png")});
  CHECK(both.text.empty());
  CHECK(both.exit_code == 0);
  CHECK(is_png(bench.path("p_top.png")));
  CHECK(is_png(bench.path("p_oblique.png")));
  CHECK(bench.run_with({"--view", "top", "--colour-by", "height", "--out", bench.path("q.png")}).exit_code ==
        0);
  CHECK(is_png(bench.path("q.png")));
}

TEST_CASE("what is refused ends with exit code 2 and one sentence that names it") {
  const Bench bench;
  const auto refuses = [&](const std::vector<std::string>& arguments, const std::string& sentence) {
    std::vector<std::string> all = arguments;
    if (std::find(all.begin(), all.end(), "--out") == all.end())
      all.insert(all.end(), {"--out", bench.path("p.png")});
    const Outcome outcome = bench.run_with(all);
    CHECK(outcome.exit_code == 2);
    CHECK(outcome.text == "viewer_offscreen: " + sentence + "\n");
  };
  bench.write("bad.csv", "0 0 0 1 1 1 accepted\n0 0 0 1 1 1 maybe\n");
  bench.write("short.csv", "0 0 0 1 1 accepted\n");
  bench.write("empty.tum", "# nothing\n");
  refuses({"--loops", bench.path("bad.csv")},
          bench.path("bad.csv") + ":2: status 'maybe' is not accepted, rejected, true or false");
  refuses({"--loops", bench.path("short.csv")},
          bench.path("short.csv") + ":1: 6 values where 'x0 y0 z0 x1 y1 z1 status' has 7");
  refuses({"--mesh", bench.path("none.ply")}, bench.path("none.ply") + ": cannot be opened");
  refuses({"--mesh", bench.path("a.tum")},
          bench.path("a.tum") + ":1: not a PLY file (its first line is not 'ply')");
  refuses({"--reference", bench.path("empty.tum")}, bench.path("empty.tum") + ": has no poses");
  refuses(
      {"--trajectory", bench.path("a.tum")},
      "--trajectory '" + bench.path("a.tum") + "' is not of the form NAME=FILE.tum or NAME=FILE.tum,#rrggbb");
  refuses({"--trajectory", "b=" + bench.path("a.tum") + ",#12345g"},
          "colour '#12345g' is not of the form #rrggbb");
  refuses({"--out", bench.path("p.jpg")}, "--out '" + bench.path("p.jpg") + "' does not end in .png");
  const Outcome nothing = bench.run({"--out", bench.path("p.png")});
  CHECK(nothing.exit_code == 2);
  CHECK_THAT(nothing.text, Catch::Matchers::StartsWith("viewer_offscreen: nothing to draw"));
  const Outcome size =
      bench.run({"--size", "10x10", "--trajectory", "a=" + bench.path("a.tum"), "--out", "p.png"});
  CHECK(size.exit_code == 2);
  CHECK(size.text == "viewer_offscreen: --size '10x10': both sides must be in [320, 8192]\n");
  CHECK(bench.run({"--view", "side", "--out", "p.png"}).exit_code == 2);
  CHECK(bench.run({}).exit_code == 2);
  CHECK(bench.run({"--help"}).exit_code == 0);
}

TEST_CASE("without an EGL driver the process says what to install") {
  const Bench bench;
  setenv("__EGL_VENDOR_LIBRARY_DIRS", bench.path("no_drivers").c_str(), 1);
  const Outcome outcome = bench.run_with({"--out", bench.path("p.png")});
  unsetenv("__EGL_VENDOR_LIBRARY_DIRS");
  CHECK(outcome.exit_code == 1);
  CHECK_THAT(outcome.text, Catch::Matchers::Contains("no off-screen OpenGL ES here; install the packages") &&
                               Catch::Matchers::Contains("libegl-mesa0"));
}

}  // namespace
}  // namespace covey::viewer
