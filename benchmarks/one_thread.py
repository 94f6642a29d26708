"""One thread for a benchmark and the processes that it starts."""

import os

from threadpoolctl import threadpool_limits

from solver.threads import threads


def one_thread() -> None:
    """Keep the solver, BLAS and whatever is started from here to one thread; call it before the first solve."""
    os.environ["OMP_NUM_THREADS"] = "1"
    threadpool_limits(1)
    threads.cache_clear()
