"""Threads: independent parts of one sum or transform, side by side.

As many threads as ``OMP_NUM_THREADS`` says, which torch also follows, or as there are cores for this process. With
one there is no pool; a process that was forked starts its own.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from threadpoolctl import threadpool_limits

Part = TypeVar("Part")


@cache
def threads() -> int:
    """Threads that a solve uses."""
    try:
        return max(1, int(os.environ["OMP_NUM_THREADS"]))
    except (KeyError, ValueError):
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@cache
def _pool() -> ThreadPoolExecutor:
    """The threads beside the one that calls; BLAS keeps to one in each, for its own would get in the way."""
    threadpool_limits(1, user_api="blas")
    return ThreadPoolExecutor(threads() - 1, "asperity-solver")


os.register_at_fork(after_in_child=_pool.cache_clear)


def side_by_side(work: Callable[[Part], None], parts: Sequence[Part]) -> None:
    """Do the work for every part; the parts must not touch each other's results."""
    count = min(threads(), len(parts))
    if count <= 1:
        _each(work, parts)
        return
    others = [_pool().submit(_each, work, parts[first::count]) for first in range(1, count)]
    _each(work, parts[::count])
    for other in others:
        other.result()


def _each(work: Callable[[Part], None], parts: Sequence[Part]) -> None:
    for part in parts:
        work(part)
