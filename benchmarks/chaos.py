"""Jobs whose workers are killed at random: all must finish, once each.

    asperity benchmark chaos [JOBS] [SECONDS]

Solves of 128 x 128 pixels, three workers on an embedded Redis; for so many seconds one of them, and with it what it runs, is
killed by SIGKILL every second or so.
"""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from tqdm import tqdm

from benchmarks.cases import midpoint_problem
from worker.connection import connect
from worker.embedded_redis import EmbeddedRedis
from worker.jobs import VerificationQueue
from worker.outcomes import Outcomes
from worker.parcel import Parcel
from worker.settings import Settings

WORKERS = 3
PATIENCE_S = 900.0


def main() -> None:
    """Print how the jobs ended."""
    jobs = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 600.0
    generator = random.Random(1)  # noqa: S311 (chaos, not secrets)
    with TemporaryDirectory(prefix="asperity-") as state:
        settings = Settings(state_dir=Path(state), queue_length=2 * jobs)
        with EmbeddedRedis(settings.state_path):
            queue = VerificationQueue(connect(settings), settings)
            problem = midpoint_problem(128, 30.0)
            ids = [queue.enqueue(Parcel(problem)) for _ in range(jobs)]
            workers = [_worker(state) for _ in range(WORKERS)]
            started, kills, finished = time.monotonic(), 0, 0
            with tqdm(total=jobs) as bar:
                while finished < jobs and time.monotonic() - started < seconds + PATIENCE_S:
                    time.sleep(generator.uniform(0.5, 1.5))
                    if time.monotonic() - started < seconds:
                        victim = generator.randrange(WORKERS)
                        workers[victim].send_signal(signal.SIGKILL)
                        workers[victim].wait()
                        workers[victim], kills = _worker(state), kills + 1
                    finished = sum(Outcomes(queue.connection).read().ended.values())
                    bar.update(finished - bar.n)
            minutes = (time.monotonic() - started) / 60
            states = [queue.state(job_id).status for job_id in ids]
            counted = Outcomes(queue.connection).read().ended
            for one in workers:
                one.kill()
    ends = {status: states.count(status) for status in sorted(set(states))}
    print(f"{jobs} jobs, {kills} workers killed, {minutes:.1f} minutes; jobs are {ends}; ends counted: {counted}")


def _worker(state: str) -> "subprocess.Popen[bytes]":
    environment = os.environ | {"ASPERITY_STATE_DIR": state, "OMP_NUM_THREADS": "1"}
    return subprocess.Popen([sys.executable, "-m", "worker"], env=environment, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
