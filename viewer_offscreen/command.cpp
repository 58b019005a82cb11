// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/command.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/geometry/trajectory.h"
#include "procs/common/bus.h"
#include "viewer_offscreen/loops.h"
#include "viewer_offscreen/ply.h"
#include "viewer_offscreen/png.h"

namespace covey::viewer {
namespace {

// The command line as it was typed.
struct Arguments {
  std::vector<std::string> trajectories;
  std::vector<std::string> references;
  std::vector<std::string> meshes;
  std::string loops;
  std::string title;
  std::string size = "1600x1200";
  std::string view = "both";
  std::string colour_by = "auto";
  std::string mesh_colour;
  std::string labels;
  std::string out;
  ObliqueOptions oblique;
  bool solid = false;
  std::vector<int> robots;
  std::vector<std::string> urls;
  std::optional<double> every_s;
};

constexpr double kDefaultEveryS = 5.0;

Arguments parse_arguments(int argc, const char* const* argv) {
  Arguments arguments;
  CLI::App app(
      "Trajectories, loop closures and meshes as PNG pictures, drawn without a screen.\n"
      "From files: draws what --trajectory, --loops, --reference and --mesh name, once.\n"
      "From a bus: draws what dpgo says there, with --robot or --url, until it is ended by a signal;\n"
      "from a log (--url file://F.lcm), what had been said by its end. --reference and --mesh are drawn too.",
      "viewer_offscreen");
  auto* trajectory =
      app.add_option("--trajectory", arguments.trajectories, "a robot's TUM file; may be given again")
          ->type_name("NAME=FILE.tum[,#rrggbb]");
  app.add_option("--reference", arguments.references, "a TUM file drawn thin and grey; may be given again")
      ->type_name("[NAME=]FILE.tum");
  auto* loops = app.add_option("--loops", arguments.loops,
                               "text, one loop a line: x0 y0 z0 x1 y1 z1 accepted|rejected|true|false")
                    ->type_name("FILE");
  app.add_option("--mesh", arguments.meshes, "a mesh; may be given again")->type_name("FILE.ply");
  app.add_option("--view", arguments.view, "both writes OUT_top.png and OUT_oblique.png")
      ->check(CLI::IsMember({"top", "oblique", "both"}))
      ->capture_default_str();
  app.add_option("--colour-by", arguments.colour_by, "auto: meshes by their colours, else by their labels")
      ->check(CLI::IsMember({"auto", "robot", "label", "height"}))
      ->capture_default_str();
  app.add_option("--mesh-colour", arguments.mesh_colour,
                 "of the meshes alone, over trajectories that are coloured by robot")
      ->check(CLI::IsMember({"rgb", "label", "height", "robot"}));
  app.add_option("--labels", arguments.labels,
                 "names of the labels, for the legend: {\"0\": \"ground\", ...}")
      ->type_name("FILE.json");
  app.add_option("--size", arguments.size, "pixels")->type_name("WIDTHxHEIGHT")->capture_default_str();
  app.add_option("--title", arguments.title, "a line above the picture");
  app.add_option("--azimuth", arguments.oblique.azimuth_deg,
                 "oblique view: where the viewer stands, from x to y, degrees")
      ->check(CLI::Range(-360.0, 360.0))
      ->capture_default_str();
  app.add_option("--elevation", arguments.oblique.elevation_deg, "oblique view: above the ground, degrees")
      ->check(CLI::Range(5.0, 85.0))
      ->capture_default_str();
  app.add_flag("--solid", arguments.solid,
               "show meshes from behind too; by default one looks through walls from outside");
  auto* robot = app.add_option("--robot", arguments.robots,
                               "draw what is said on this robot's private bus; may be given again")
                    ->check(CLI::Range(0, kLastRobot))
                    ->excludes(trajectory)
                    ->excludes(loops);
  app.add_option("--url", arguments.urls, "the same of an LCM bus or a log, file://F.lcm; may be given again")
      ->excludes(trajectory)
      ->excludes(loops)
      ->excludes(robot);
  app.add_option(
         "--every", arguments.every_s,
         fmt::format("on a bus: seconds from one picture to the next, if anything changed (default: {})",
                     kDefaultEveryS))
      ->check(CLI::Range(0.1, 3600.0));
  app.add_option("--out", arguments.out, "the picture")->type_name("FILE.png")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw CommandDone{app.exit(error) == 0 ? 0 : 2};
  }
  return arguments;
}

PictureSize parse_size(const std::string& text) {
  PictureSize size;
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  const bool crossed = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
  if (!crossed || std::from_chars(width.ptr + 1, end, size.height).ptr != end) {
    throw_input_error("--size '{}' is not of the form 1600x1200", text);
  }
  constexpr int kSmallest = 320;
  if (std::min(size.width, size.height) < kSmallest ||
      std::max(size.width, size.height) > Renderer::kLargestSide) {
    throw_input_error("--size '{}': both sides must be in [{}, {}]", text, kSmallest, Renderer::kLargestSide);
  }
  return size;
}

Curve read_curve(const std::string& name, const std::string& file) {
  Curve curve;
  curve.name = name;
  for (const StampedPose& stamped : read_tum(file)) curve.points_W.push_back(stamped.pose.translation);
  if (curve.points_W.empty()) throw_input_error("{}: has no poses", file);
  return curve;
}

Curve read_trajectory(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw_input_error("--trajectory '{}' is not of the form NAME=FILE.tum or NAME=FILE.tum,#rrggbb",
                      argument);
  }
  std::string file = argument.substr(equals + 1);
  std::optional<Rgb> colour;
  const std::size_t comma = file.rfind(",#");
  if (comma != std::string::npos) {
    colour = parse_colour(file.substr(comma + 1));
    file.resize(comma);
  }
  Curve curve = read_curve(argument.substr(0, equals), file);
  curve.colour = colour;
  return curve;
}

Curve read_reference(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos) return read_curve("reference", argument);
  return read_curve(argument.substr(0, equals), argument.substr(equals + 1));
}

FigureContent read_content(const Arguments& arguments) {
  const std::map<std::string, ColourBy> colourings = {{"auto", ColourBy::kAuto},
                                                      {"robot", ColourBy::kRobot},
                                                      {"rgb", ColourBy::kAuto},
                                                      {"label", ColourBy::kLabel},
                                                      {"height", ColourBy::kHeight}};
  FigureContent content;
  content.title = arguments.title;
  content.colour_by = colourings.at(arguments.colour_by);
  if (!arguments.mesh_colour.empty()) content.mesh_colour = colourings.at(arguments.mesh_colour);
  if (!arguments.labels.empty()) content.classes = read_label_classes(arguments.labels);
  for (const std::string& argument : arguments.trajectories)
    content.trajectories.push_back(read_trajectory(argument));
  for (const std::string& argument : arguments.references)
    content.references.push_back(read_reference(argument));
  for (const std::string& file : arguments.meshes) content.meshes.push_back(read_ply(file));
  if (!arguments.loops.empty()) content.loops = read_loops(arguments.loops);
  return content;
}

std::optional<Watch> plan_watch(const Arguments& arguments) {
  if (arguments.robots.empty() && arguments.urls.empty()) {
    if (arguments.every_s) throw_input_error("--every is for a bus; give --robot or --url too");
    return std::nullopt;
  }
  Watch watch;
  watch.urls = arguments.urls;
  for (const int robot : arguments.robots) watch.urls.push_back(robot_bus_url(robot));
  if (!arguments.robots.empty()) watch.robot = arguments.robots.front();
  watch.every_us = from_seconds(arguments.every_s.value_or(kDefaultEveryS));
  return watch;
}

std::vector<Picture> plan_pictures(const Arguments& arguments) {
  const std::filesystem::path out = arguments.out;
  if (out.extension() != ".png") throw_input_error("--out '{}' does not end in .png", arguments.out);
  if (arguments.view == "top") return {{out, View::kTop}};
  if (arguments.view == "oblique") return {{out, View::kOblique}};
  const auto beside = [&](const char* view) { return out.parent_path() / (out.stem().string() + view); };
  return {{beside("_top.png"), View::kTop}, {beside("_oblique.png"), View::kOblique}};
}

}  // namespace

Command parse_command(int argc, const char* const* argv) {
  const Arguments arguments = parse_arguments(argc, argv);
  Command command;
  command.pictures = plan_pictures(arguments);
  command.options.size = parse_size(arguments.size);
  command.options.oblique = arguments.oblique;
  command.options.see_through = !arguments.solid;
  command.watch = plan_watch(arguments);
  command.content = read_content(arguments);
  if (!command.watch && !has_content(command.content)) {
    throw_input_error(
        "nothing to draw; give at least one --trajectory, --reference, --loops or --mesh with content, or "
        "--robot or --url");
  }
  return command;
}

void write_pictures(Renderer& renderer, const Command& command, const FigureContent& content) {
  for (const Picture& picture : command.pictures) {
    write_png(picture.file, draw_figure(renderer, content, picture.view, command.options));
  }
}

}  // namespace covey::viewer
