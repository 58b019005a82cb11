# SPDX-License-Identifier: BSD-3-Clause
"""The sensor logs and the truth of a simulated world, made once and kept.

    CACHE/<world>-<robots>x<seconds>s-seed<K>/<key>/robot<i>.lcm    IMU, STEREO and DEPTH of a robot
                                                    truth/          poses, the world's mesh, radio contacts
    CACHE/flight-<sequence>-<seconds>s-<configuration>-seed<K>/<key>/...   the same of one recorded flight, without DEPTH
    CACHE/<world>-<robots>x<seconds>s-seed<K>-keyframes/<key>/      pictures of keyframes alone, which bench_place makes

The key is a hash of all that decides their bytes: the simulator and what it reads. A file appears under its name when it
is whole, so what an interrupted run left is made again and the rest is kept. Folders of other keys, which no simulator
at hand would make any more, are removed unless a demo is using them.
"""

import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

from covey_tools import namespace, places, worlds
from covey_tools.errors import Failure, InputError
from covey_tools.process import last_log_line

DEFAULT_CACHE = os.path.join(places.ROOT, "out", "cache")
_DONE = re.compile(r"([\d.]+) of ([\d.]+) s")  # sim's word on how far it is
_AT_ONCE = 3  # on two cores, too: three robots after two would leave a core idle for a third of the time
_POLL_S = 0.1
_PLAIN_REFRESH_S = 10.0


@dataclass
class Recording:
    """Complete, and not removed by others while `lock` is open."""

    folder: str
    robots: int
    lock: object

    def log(self, robot):
        return os.path.join(self.folder, f"robot{robot}.lcm")

    def truth(self, *names):
        return os.path.join(self.folder, "truth", *names)


@dataclass
class _Job:
    """One run of the simulator, and the file or folder that it leaves."""

    name: str
    arguments: list
    option: str  # before the path to write
    path: str
    belongs_to: str = ""
    process: object = None

    @property
    def partial(self):
        return f"{self.path}.partial"

    @property
    def words(self):
        return f"{self.path}.txt"


def prepare(world, seed, data, cache, say=None):
    """The Recording of a world with sensors; what of it is not in `cache` is made, with progress on stdout, or told to say line by line."""
    simulator = _simulator()
    arguments, reads = _of_world(world, seed, data)
    recording = _open(_family(world, seed, cache), _key(simulator, arguments, world.file, reads), world.robots, cache)
    jobs = [_Job("truth", [simulator, *arguments], "--truth", recording.truth())]
    jobs += [_Job(f"robot {robot}", [simulator, *arguments, "--robot", str(robot)], "--log", recording.log(robot))
             for robot in range(world.robots)]
    try:
        if not _complete(jobs):
            _claim(recording)
            missing = [job for job in jobs if not os.path.exists(job.path)]
            if missing:  # else another demo has made them meanwhile
                progress = _Progress(missing)
                if say:
                    _make(missing, lambda running, done, last=False: say(progress.summary(running, done)))
                else:
                    print(f"demo: making sensor data of {world.seconds:g} s, kept for the next run in {recording.folder}", flush=True)
                    _make(missing, progress.show)
        fcntl.flock(recording.lock, fcntl.LOCK_SH)
    except BaseException:
        recording.lock.close()
        raise
    return recording


@contextlib.contextmanager
def keyframe_pictures(world, seed, data, cache):
    """The folder for the pictures of keyframes of such a world; whoever renders them keeps them there and takes those that are there."""
    arguments, reads = _of_world(world, seed, data)
    recording = _open(f"{_family(world, seed, cache)}-keyframes", _key(_simulator(), arguments, world.file, reads), world.robots, cache)
    with recording.lock:
        _claim(recording)
        yield recording.folder


def prepare_flights(folders, seconds, seed, config, cache, say):
    """({folder: Recording}, {folder: why there is none}) of one robot's IMU and STEREO on recorded flights.

    folders: each with imu0.csv.gz and groundtruth.csv.gz; seconds: of each at most, None: all; say takes a line of progress.
    """
    simulator = _simulator()
    recordings, jobs, complaints = {}, [], {}
    try:
        for folder in folders:
            arguments = ["--motion", folder, "--seed", str(seed), "--config", config, "--no-depth"]
            arguments += ["--seconds", f"{seconds:g}"] if seconds else []
            name = os.path.basename(folder)
            length = f"{seconds:g}s" if seconds else "all"
            key = _key(simulator, arguments, config, folder)
            family = f"flight-{name}-{length}-{os.path.splitext(os.path.basename(config))[0]}-seed{seed}"
            recording = recordings[folder] = _open(os.path.join(cache, family), key, 1, cache)
            own = [_Job(f"{name}'s truth", [simulator, *arguments], "--truth", recording.truth(), belongs_to=folder),
                   _Job(name, [simulator, *arguments], "--log", recording.log(0), belongs_to=folder)]
            if not _complete(own):
                _claim(recording)
                jobs += [job for job in own if not os.path.exists(job.path)]
        if jobs:
            progress = _Progress(jobs)
            _make(jobs, lambda running, done, last=False: say(progress.summary(running, done)), complaints)
        for folder, recording in recordings.items():
            fcntl.flock(recording.lock, fcntl.LOCK_SH)
    except BaseException:
        for recording in recordings.values():
            recording.lock.close()
        raise
    return {folder: each for folder, each in recordings.items() if folder not in complaints}, complaints


def _of_world(world, seed, data):
    """The simulator's arguments, and the folder that it reads ("": none)."""
    arguments = ["--world", world.name, "--robots", str(world.robots), "--seconds", f"{world.seconds:g}",
                 "--seed", str(seed), "--config", world.file]
    if not world.name.startswith("euroc"):
        return arguments, ""
    return [*arguments, "--data", os.path.abspath(data)], worlds.motion_folder(data)


def _family(world, seed, cache):
    return os.path.join(cache, f"{world.name}-{world.robots}x{world.seconds:g}s-seed{seed}")


def _simulator():
    return os.path.join(places.build_folder(), "bin", "sim")


def _open(family, key, robots, cache):
    """The Recording, whatever of it is there, with its lock not taken yet."""
    folder = os.path.join(os.path.abspath(family), key)
    try:
        os.makedirs(folder, exist_ok=True)
        lock = open(f"{folder}.lock", "ab")  # noqa: closed by whoever uses the recording
    except OSError as error:
        raise InputError(f"--cache {cache}: {error.strerror.lower()}; expected a folder to write in") from None
    return Recording(folder, robots, lock)


def _complete(jobs):
    return all(os.path.exists(job.path) for job in jobs)


def _claim(recording):
    """Makes it ours to write, and makes room."""
    fcntl.flock(recording.lock, fcntl.LOCK_EX)  # two that want the same make it once
    _remove_others(*os.path.split(recording.folder))


def _key(simulator, arguments, config, reads):
    """Of the program, its arguments and what it reads: its configuration and a folder ("": none); where these are does not matter."""
    words = [os.path.basename(word) if os.path.isabs(word) else word for word in arguments]
    digest = hashlib.sha256(repr((words, worlds.read_section(config, "sim"))).encode())
    files = [simulator] + sorted(_files(os.path.join(places.ROOT, "configs", "sensors")))
    for path in files:
        try:
            with open(path, "rb") as file:
                digest.update(hashlib.sha256(file.read()).digest())
        except OSError as error:
            raise Failure(f"{path}: {error.strerror.lower()}; bin/build makes it") from None
    for path in sorted(_files(reads)) if reads else ():
        digest.update(f"{os.path.relpath(path, reads)} {os.path.getsize(path)}".encode())
    return digest.hexdigest()[:16]


def _files(folder):
    return [os.path.join(at, name) for at, _, names in os.walk(folder) for name in names]


def _remove_others(family, key):
    for name in os.listdir(family):
        if name.startswith(key) or not name.endswith(".lock"):
            continue
        path = os.path.join(family, name)
        with open(path, "ab") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            shutil.rmtree(path.removesuffix(".lock"), ignore_errors=True)
            os.remove(path)


def _make(jobs, show, complaints=None):
    """Runs all, some at a time; Failure or InputError where one cannot, or a complaint for what it belongs to."""
    waiting, running, done = list(jobs), [], []
    try:
        while waiting or running:
            while waiting and len(running) < max(_AT_ONCE, os.cpu_count() or 1):
                running.append(_start(waiting.pop(0)))
            time.sleep(_POLL_S)
            for job in [job for job in running if job.process.poll() is not None]:
                running.remove(job)
                try:
                    _finish(job)
                except (Failure, InputError) as error:
                    if complaints is None:
                        raise
                    complaints[job.belongs_to] = str(error)
                done.append(job)
            show(running, done)
    finally:
        for job in running:
            job.process.kill()
            job.process.wait()
    show(running, done, last=True)


def _start(job):
    parent = os.getpid()
    _remove(job.partial)
    with open(job.words, "wb") as words:
        try:
            job.process = subprocess.Popen(
                [*job.arguments, job.option, job.partial], stdin=subprocess.DEVNULL, stdout=words, stderr=words,
                preexec_fn=lambda: namespace.die_with_parent(parent, signal.SIGTERM))
        except OSError as error:
            raise Failure(f"{job.arguments[0]}: {error.strerror.lower()}; bin/build makes it") from None
    return job


def _finish(job):
    code = job.process.returncode
    said = last_log_line(job.words).removeprefix("sim: ")
    if code == 2:
        raise InputError(said)
    if code or not os.path.exists(job.partial):
        raise Failure(f"sim ended with {code} on {job.name}: {said}; see {job.words}")
    os.rename(job.partial, job.path)


def _remove(path):
    if os.path.isdir(path):
        shutil.rmtree(path)
    with contextlib.suppress(FileNotFoundError):
        os.remove(path)


class _Progress:
    """One line, replaced on a terminal, repeated now and then elsewhere."""

    def __init__(self, jobs):
        self._jobs = jobs
        self._start_s = time.monotonic()
        self._shown_s = self._start_s
        self._live = sys.stdout.isatty()

    def show(self, running, done, last=False):
        now_s = time.monotonic()
        if not last and not self._live and now_s - self._shown_s < _PLAIN_REFRESH_S:
            return
        self._shown_s = now_s
        line = f"{now_s - self._start_s:6.1f} s  {self.words(running, done)}"
        sys.stdout.write(f"\r\033[K{line}" + ("\n" if last else "") if self._live else f"{line}\n")
        sys.stdout.flush()

    def summary(self, running, done):
        """Of many jobs."""
        words = ", ".join(f"{job.name} {self._state(job, running, done)}" for job in running)
        return f"sensor data: {len(done)} of {len(self._jobs)} made{f'; {words}' if words else ''}"

    def words(self, running, done):
        return ", ".join(f"{job.name} {self._state(job, running, done)}" for job in self._jobs)

    @staticmethod
    def _state(job, running, done):
        if job in done:
            return "done"
        if job not in running:
            return "waiting"
        done = _DONE.search(last_log_line(job.words))
        return f"{100 * float(done[1]) / float(done[2]):.0f} %" if done else "begun"
