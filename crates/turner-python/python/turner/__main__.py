"""`python -m turner`: the command line."""

from __future__ import annotations

import sys

from . import _turner


def main():
    """Runs the command line `turner` with the arguments of the process."""
    return _turner.run_command(["turner", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
