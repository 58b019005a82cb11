# SPDX-License-Identifier: BSD-3-Clause
"""What a robot saw: an image set of each of its cameras out of the log of its sensors."""

import json
import os

import numpy

from covey_tools import figures, lcm_log, messages

_TYPES = {"STEREO": "stereo_t", "DEPTH": "depth_t"}
UNKNOWN_LABEL = 255


def draw(path, log, after_s, labels_file):
    """One picture: left image, depth and labels, the first after so many seconds of the log."""
    stereo, depth = _first_sets(log, after_s)
    left = numpy.frombuffer(bytes(stereo.left), numpy.uint8).reshape(stereo.height, stereo.width)
    shape = depth.height, depth.width
    metres = numpy.array(depth.depth_mm, "<i2").astype("<u2").reshape(shape) / 1000.0
    metres[metres == 0.0] = numpy.nan
    labels = numpy.frombuffer(bytes(depth.labels), numpy.uint8).reshape(shape) if depth.n_labels else None
    names = {}
    if os.path.exists(labels_file):
        with open(labels_file, encoding="utf-8") as file:
            names = {int(number): name for number, name in json.load(file).items()}
    figures.camera_views(path, left, metres, labels, names)


def _first_sets(log, after_s):
    """The first whole stereo_t and depth_t."""
    wanted, found, start = {}, {}, None
    for event in lcm_log.Log(log):
        start = event.utime if start is None else start
        if event.channel not in _TYPES or event.channel in found or event.utime < start + after_s * 1e6:
            continue
        band = messages.decode("band_t", event.data)
        parts = wanted.setdefault((event.channel, band.number), {})
        parts[band.band] = bytes(band.data)
        if len(parts) == band.bands:
            found[event.channel] = messages.decode(_TYPES[event.channel], b"".join(parts[k] for k in range(band.bands)))
            if len(found) == len(_TYPES):
                break
    return found["STEREO"], found["DEPTH"]
