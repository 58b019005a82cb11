# SPDX-License-Identifier: BSD-3-Clause
"""Where things are: the source tree that this package stands in, and what was built from it."""

import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def build_folder():
    """build/<preset> to use: $COVEY_BUILD where it is set, else release, else the preset that was built last."""
    if os.environ.get("COVEY_BUILD"):
        return os.path.abspath(os.environ["COVEY_BUILD"])
    release = os.path.join(ROOT, "build", "release")
    others = [os.path.join(ROOT, "build", preset) for preset in ("debug", "asan", "tsan")]
    built = [folder for folder in others if os.path.isdir(os.path.join(folder, "bin"))]
    if os.path.isdir(os.path.join(release, "bin")) or not built:
        return release
    return max(built, key=os.path.getmtime)
