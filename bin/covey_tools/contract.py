# SPDX-License-Identifier: BSD-3-Clause
"""The keys of report.json that scripts may count on. Others come beside them and may change."""

_TEAM = ("ate_m", "ate_vio_m", "ate_online_m", "ate_centralized_m", "time_to_common_frame_s", "loops", "dgnc_seconds",
         "dgnc_iterations")
_ROBOT = ("id", "length_m", "keyframes", "ate_vio_m", "ate_team_m", "frames", "frames_dropped", "vio_ms_mean",
          "vio_ms_p99")
_LOOPS = ("a", "b", "met", "total", "accepted", "true")
_MESH = ("robot", "error_before_m", "error_after_m", "completeness_after_m", "labels_before", "labels_after")
_BYTES = ("place_recognition", "geometric_verification", "dpgo", "control", "total", "centralized_keypoints",
          "centralized_images")
_TOP = ("world", "seconds", "robots", "team", "communication_bytes", "mesh", "realtime_factor")

# What a pose graph cannot have: it has no images, and truth only where it is simulated. It has these instead.
_NOT_OF_GRAPHS = {"frames", "frames_dropped", "vio_ms_mean", "vio_ms_p99", "mesh", "ate_m", "ate_vio_m", "ate_team_m",
                  "ate_online_m", "ate_centralized_m", "true"}
_OF_GRAPHS = ("cost", "cost_centralized")


def lacks(report, has_sensors):
    """Sentences: what of the contract the report has not. A value may be null where it could not be measured, not gone."""
    places = [("", report, _TOP), ("team.", report["team"], _TEAM if has_sensors else (*_TEAM, *_OF_GRAPHS)),
              ("communication_bytes.", report["communication_bytes"], _BYTES)]
    places += [(f"robots[{k}].", each, _ROBOT) for k, each in enumerate(report["robots"])]
    places += [(f"team.loops[{k}].", each, _LOOPS) for k, each in enumerate(report["team"].get("loops", []))]
    places += [(f"mesh[{k}].", each, _MESH) for k, each in enumerate(report.get("mesh", []))]
    gone = [f"{place}{key}" for place, values, keys in places for key in keys
            if key not in values and (has_sensors or key not in _NOT_OF_GRAPHS)]
    sentences = [f"the report has no {', '.join(gone)}"] if gone else []
    robots = [robot["id"] for robot in report["robots"]]
    pairs = [(each["a"], each["b"]) for each in report["team"].get("loops", [])]
    if pairs and pairs != [(a, b) for a in robots for b in robots if a <= b]:
        sentences.append("the report's loops are not of every pair of robots once")
    meshes = [each["robot"] for each in report.get("mesh", [])]
    if meshes and meshes != [*robots, "merged"]:
        sentences.append("the report's meshes are not of every robot, and merged")
    return sentences
