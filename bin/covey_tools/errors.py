# SPDX-License-Identifier: BSD-3-Clause
"""What goes wrong at start-up, and what it becomes: one sentence on stderr and an exit code."""

import sys


class InputError(Exception):
    """A user's mistake: the sentence names file, line, option or channel and says what to do. Exit 2."""


class Failure(Exception):
    """The input was right and the machine could not do it. Exit 1."""


def run_main(name, main):
    """Run main() -> exit code, and turn the two errors above into a sentence and their codes."""
    try:
        code = main()
        sys.stdout.flush()
    except InputError as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = 2
    except Failure as error:
        print(f"{name}: {error}", file=sys.stderr)
        code = 1
    except KeyboardInterrupt:
        code = 1
    except BrokenPipeError:  # the reader (head, less) has seen enough
        sys.stderr.close()
        code = 0
    sys.exit(code)
