# SPDX-License-Identifier: BSD-3-Clause
"""Where closures get lost between two robots: the counters of their loop finders (core/place/funnel.h), summed for each pair.

Of two robots one looks for their common places, so both together have all of the pair; "received" is what either heard of the other, "told"
what the finder told the other of what it accepted.
"""

# On the way from words to closures, in their order.
STEPS = ("received", "candidate", "asked", "answered", "verified", "matched", "five_point", "three_point", "refined", "accepted", "told")
_PREFIX, _REFUSED = "funnel/", "refused/"


def of_pairs(said):
    """said: {robot: Said of its lcd}. For every pair a <= b: "a", "b", each of STEPS, and "refused": {reason: count}, the commonest first."""
    pairs = {(a, b): {**dict.fromkeys(STEPS, 0), "refused": {}} for a in said for b in said if a <= b}
    for robot, words in said.items():
        for name in words.names():
            other, step = _read(name)
            found = pairs.get((min(robot, other), max(robot, other))) if step else None
            if found is None:
                continue
            counts, step = (found["refused"], step.removeprefix(_REFUSED)) if step.startswith(_REFUSED) else (found, step)
            counts[step] = counts.get(step, 0) + words.total(name)
    for found in pairs.values():
        found["refused"] = dict(sorted(((reason, n) for reason, n in found["refused"].items() if n), key=lambda each: (-each[1], each[0])))
    return [{"a": a, "b": b, **found} for (a, b), found in sorted(pairs.items())]


def _read(counter):
    """(other robot, step) of funnel/ROBOT/STEP, else (-1, "")"""
    robot, _, step = counter.removeprefix(_PREFIX).partition("/")
    return (int(robot), step) if counter.startswith(_PREFIX) and robot.isdigit() else (-1, "")


def in_words(pair):
    """"48 overlap, 7 spread": why candidates ended."""
    return ", ".join(f"{n} {reason}" for reason, n in pair["refused"].items()) or "-"
