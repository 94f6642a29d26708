"""Restarts a benchmark with a given number of threads, for libraries read it when they are loaded."""

import os
import sys


def one_thread() -> None:
    """Run this command again with one thread, unless it does so already."""
    if os.environ.get("OMP_NUM_THREADS") != "1":
        os.execve(sys.executable, sys.orig_argv, os.environ | {"OMP_NUM_THREADS": "1"})  # noqa: S606
