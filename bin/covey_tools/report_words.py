# SPDX-License-Identifier: BSD-3-Clause
"""The figures of a report in words, for the terminal and for the page."""


def metres(value):
    return "-" if value is None else f"{value:.3f} m"


def milliseconds(value):
    return "-" if value is None else f"{value:.1f} ms"


def share(value):
    return "-" if value is None else f"{100 * value:.1f} %"


def against_central(team):
    """"+0.49 % against central, 250,038.6", or "" where there is nothing to compare with."""
    central = team.get("cost_centralized")
    return f"{100 * (team['cost'] / central - 1):+.2f} % against central, {central:,.1f}" if central else ""


def other_ates(facts):
    """"odometry alone 1.5 m, central 0.2 m, at the time 0.7 m for 81 of 360 keyframes": beside the team's ATE."""
    team = facts["team"]
    words = f"odometry alone {metres(team.get('ate_vio_m'))}, central {metres(team.get('ate_centralized_m'))}"
    if "ate_online_m" in team:
        keyframes = sum(robot["keyframes"] for robot in facts["robots"])
        words += f", at the time {metres(team['ate_online_m'])} for {team['keyframes_online']} of {keyframes} keyframes"
    return words


def truth_of_loops(team):
    """"precision 1.000, recall 0.995", or "" where truth is not known."""
    if "precision" not in team:
        return ""
    return f"precision {team['precision']:.3f}, recall {team.get('recall', 0.0):.3f}"


def table(facts):
    """The headline figures as a few lines of text."""
    sensors = "frames" in facts["robots"][0]
    head = f"{'robot':>5}  {'keyframes':>9}  {'length':>8}  {'ATE odometry':>12}  {'ATE team':>8}"
    head += f"  {'frames':>6}  {'dropped':>7}  {'vio mean':>8}  {'vio p99':>8}" if sensors else ""
    lines = ["", head]
    for robot in facts["robots"]:
        ates = f"{metres(robot.get('ate_vio_m')):>12}  {metres(robot.get('ate_team_m')):>8}"
        line = f"{robot['id']:5}  {robot['keyframes']:9}  {robot.get('length_m', 0.0):6.0f} m  {ates}"
        if sensors:
            line += (f"  {robot['frames']:6}  {robot['frames_dropped']:7}  {milliseconds(robot['vio_ms_mean']):>8}  "
                     f"{milliseconds(robot['vio_ms_p99']):>8}")
        lines.append(line)
    if facts.get("mesh"):
        lines += ["", f"{'mesh':>6}  {'error before':>12}  {'after':>8}  {'completeness':>12}  {'labels before':>13}  "
                      f"{'after':>8}"]
        lines += [f"{each['robot']:>6}  {metres(each['error_before_m']):>12}  {metres(each['error_after_m']):>8}  "
                  f"{metres(each['completeness_after_m']):>12}  {share(each['labels_before']):>13}  "
                  f"{share(each['labels_after']):>8}" for each in facts["mesh"]]
    lines += ["", *(f"{name:17} {text}" for name, text in _headlines(facts))]
    lines += [f"remark: {remark}" for remark in facts.get("remarks", [])]
    return "\n".join(lines + [f"note: {note}" for note in facts["notes"]])


def _headlines(facts):
    team, sent = facts["team"], facts["communication_bytes"]
    if "ate_m" in team:
        yield "team ATE", f"{metres(team['ate_m'])} ({other_ates(facts)})"
    if "cost" in team:
        yield "robust cost", f"{team['cost']:,.1f} ({against_central(team) or 'nothing to compare with'})"
        central = team.get("loops_accepted_centralized")
        asides = [f"central {central}" if central is not None else "", truth_of_loops(team)]
        aside = ", ".join(each for each in asides if each)
        yield "closures kept", f"{team['loops_accepted']} of {team['loops_total']}" + (f" ({aside})" if aside else "")
    yield "radio", (f"{sent['total'] / 1e3:,.0f} kB sent by all robots, {sent['dpgo'] / 1e3:,.0f} kB of it for dpgo; "
                    f"a server would need {sent['centralized_keypoints'] / 1e3:,.0f} kB of keypoints")
    common = team.get("time_to_common_frame_s")
    frame = f"one frame after {common:.1f} s" if common is not None else "never in one frame"
    yield "time", f"{facts['wall_seconds']:.1f} s for {facts['seconds']:.0f} s of data; {frame}"
    if facts["restarts"]:
        yield "restarted", ", ".join(f"{name} {count} x" for name, count in facts["restarts"].items())
