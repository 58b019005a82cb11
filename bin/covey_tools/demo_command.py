# SPDX-License-Identifier: BSD-3-Clause
"""bin/demo's command line, and the demo from first to last."""

import argparse
import os
import shutil
import subprocess
import sys
import time
import webbrowser

from covey_tools import places, radio_plan, recordings, report, report_page, report_words, team_sheet, worlds
from covey_tools.errors import Failure, InputError
from covey_tools.sensor_team import SensorTeam
from covey_tools.team import Team
from covey_tools.team_run import TeamRun

DESCRIPTION = """Runs a team of robots, every process of theirs and the radio between them, and measures what came out.

Sets up and builds first. Sensor data is made once and kept. The robots' processes run from a process sheet in a private
network; the demo ends when all that the robots have is solved in one round that all of them took part in, and the mesh
of that round is there."""

EPILOG = """worlds (configs/worlds)
  town      ground robots with cameras, IMU and depth in simulated streets; needs no data
  rooms     the same robots in eight furnished rooms off a corridor, some of them alike; needs no data
  euroc-v1  real flights and their real IMU, from DATA/euroc/motion, through a furnished room that is drawn
  grid      a pose graph: robots in a town, noisy odometry, a third of all loop closures false; needs no data
  tunnels   the real pose graph of eight robots, from DATA/pose_graphs/tunnels

output, in --out
  report.html    to look at; report.json: the same figures and more
  traj/          robot<i>_vio.tum: odometry alone; robot<i>_team.tum: the team's solution (stamps in s, poses in W)
  mesh/          robot<i>_vio.ply: as measured; robot<i>_team.ply: deformed, in W; merged.ply: all of these
  snapshots/     pictures before and after
  logs/          every bus as an LCM log: robot<i>.lcm, air.lcm (the radio); processes/: what each process printed
  radio.yaml     --radio with the start of the contact plan, where it has one without epoch_utime
  demo.procman   the sheet that was run; graph/: the pose graph; state/: what processes read after a restart
  Sensor data stays in --cache (some 17 MB for each robot and second).

exit codes: 0 done; 1 not everything was solved in time, or a program failed (the report says what is missing);
2 wrong usage or input; 130 interrupted (the report is written)"""

# What a run leaves in --out, and the next one replaces.
OUTPUTS = ("report.json", "report.html", "demo.procman", "radio.yaml", "results.lcm", "graph", "traj", "snapshots",
           "logs", "state", "central", "mesh")


def main(arguments=None):
    options = _parse(arguments)
    world = _world(options)
    if not options.no_build:
        _set_up_and_build()
    out = _empty_output(options.out)
    recording, robots = _prepare(world, options, out)
    outcome = _run_team(world, robots, recording, options, out)
    print("\ndemo: measuring what came out", flush=True)
    facts = report.make(report.Run(out, world, robots, outcome, options.radio, options.seed, recording))
    report_page.write(out, facts)
    print(report_words.table(facts))
    page = os.path.join(out, "report.html")
    print(f"\n{page}")
    if options.view and not webbrowser.open(f"file://{page}"):
        print("demo: --view: no browser here; open the page above elsewhere", file=sys.stderr)
    return _conclude(outcome, facts)


def _conclude(outcome, facts):
    for sentence in outcome.missing:
        print(f"demo: missing: {sentence}", file=sys.stderr)
    if outcome.reason == "interrupted":
        return 130
    if outcome.reason != "done":
        print(f"demo: {'the time was up' if outcome.reason == 'time' else outcome.reason}", file=sys.stderr)
    return 0 if outcome.reason == "done" and not facts["notes"] else 1


def _parse(arguments):
    here = places.ROOT
    parser = argparse.ArgumentParser(prog="demo", description=DESCRIPTION, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("--world", default="town", metavar="W", help=f"{' | '.join(worlds.names())} (default town)")
    add("--robots", type=_count, metavar="N", help="how many (default: the world's)")
    add("--seconds", type=_positive, metavar="S", help="of data; pose-graph worlds have a keyframe a second")
    add("--radio", default=os.path.join(here, "configs", "radio", "ideal.yaml"), metavar="FILE",
        help="the radio's quality, such as configs/radio/lossy.yaml (default: ideal)")
    add("--data", default=os.environ.get("COVEY_DATA", os.path.join(here, "..", "shared", "data")), metavar="DIR",
        help="recorded data (default $COVEY_DATA, else ../shared/data)")
    add("--out", default=os.path.join("out", "demo"), metavar="DIR",
        help="default out/demo; what an earlier run left there is replaced")
    add("--cache", default=recordings.DEFAULT_CACHE, metavar="DIR", help="keeps sensor data (default out/cache)")
    add("--speed", type=_positive, metavar="X", help="seconds of data in a second (default: the world's)")
    add("--seed", type=int, default=1, help="of simulated worlds (default 1)")
    add("--patience", type=_positive, metavar="S", help="to wait for the end after the data (default: the world's)")
    add("--namespace", choices=["auto", "private", "in-place"], default="auto",
        help="private: fail where no private network can be had (default auto)")
    add("--view", action="store_true", help="open the report in a browser at the end")
    add("--no-build", action="store_true", help="take what bin/build made before")
    return parser.parse_args(arguments)


def _world(options):
    world = worlds.load(options.world)
    world.robots = options.robots or world.robots
    world.seconds = options.seconds or world.seconds
    world.speed = options.speed or world.speed
    world.patience_s = options.patience or world.patience_s
    if not os.path.exists(options.radio):
        raise InputError(f"--radio {options.radio}: no such file; expected one like those in configs/radio")
    worlds.check(world, options.data)
    return world


def _count(text):
    value = int(text)
    if not 1 <= value <= 20:
        raise argparse.ArgumentTypeError(f"{text} is not between 1 and 20")
    return value


def _positive(text):
    value = float(text)
    if not 0 < value < 1e6:
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value


def _set_up_and_build():
    for step in ("setup", "build"):
        code = subprocess.run([os.path.join(places.ROOT, "bin", step)]).returncode
        if code:
            raise Failure(f"bin/{step} ended with {code}")


def _empty_output(out):
    """The output folder, without what an earlier run left there."""
    out = os.path.abspath(out)
    try:
        os.makedirs(out, exist_ok=True)
        for name in OUTPUTS:
            path = os.path.join(out, name)
            if os.path.isdir(path) and not os.path.islink(path):
                shutil.rmtree(path)
            elif os.path.lexists(path):
                os.remove(path)
        for name in ("traj", "snapshots", "logs/processes", "state", "mesh"):
            os.makedirs(os.path.join(out, name))
    except OSError as error:
        raise InputError(f"--out {error.filename}: {error.strerror.lower()}; expected a folder to write in") from None
    return out


def _radio_file(radio, out):
    """What all bridges are given, --radio or a copy with one epoch for its contacts."""
    text = radio_plan.with_epoch(radio, int(time.time() * 1e6))
    if text is None:
        return os.path.abspath(radio)
    path = os.path.join(out, "radio.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def _prepare(world, options, out):
    """What the robots will be fed: (the Recording of a world with sensors, else None; the robots)."""
    if not world.has_sensors:
        return None, worlds.prepare_graph(world, options.seed, options.data, os.path.join(out, "graph"))
    recording = recordings.prepare(world, options.seed, options.data, options.cache)
    return recording, [worlds.Robot(robot, recording.log(robot), truth=recording.truth(f"robot{robot}.tum"))
                       for robot in range(world.robots)]


def _run_team(world, robots, recording, options, out):
    sheet = os.path.join(out, "demo.procman")
    values = {"OUT": out, "CONFIG": world.file, "RADIO": _radio_file(options.radio, out), "SPEED": f"{world.speed:g}"}
    if recording:
        kind, team, seconds = team_sheet.SENSORS, SensorTeam(robots, world.seconds, world.speed), world.seconds
        values["LOGS"] = recording.folder
        what = "images, IMU and depth"
    else:
        kind, team, seconds = team_sheet.GRAPH, Team(robots), max(robot.keyframes for robot in robots)
        values["GRAPH"] = os.path.join(out, "graph")
        keyframes = sum(robot.keyframes for robot in robots)
        loops = sum(robot.loops + robot.own_loops for robot in robots) // 2
        what = f"{keyframes} keyframes, {loops} loop closures"
    team_sheet.write(sheet, kind, world.robots, values)
    print(f"demo: world {world.name}: {world.robots} robots, {what}, {seconds:g} s of data at {world.speed:g} times its "
          f"speed, radio {os.path.basename(options.radio)}", flush=True)
    run = TeamRun(sheet, team, os.path.join(out, "logs", "processes"), os.path.join(out, "results.lcm"),
                  seconds / world.speed + world.patience_s, options.namespace, team_sheet.wait_for(kind, world.robots))
    return run.run()
