"""Workers as child processes of the service: started with it, started again when one dies, ended with it."""

import logging
import os
import subprocess
import sys
import threading
from functools import partial
from types import TracebackType

from solver.threads import threads
from worker.lifetime import die_with_parent
from worker.settings import Settings

logger = logging.getLogger(__name__)

RESTART_AFTER_S = 1.0
STOP_TIMEOUT_S = 5.0


class WorkerSupervisor:
    """A number of worker processes, as a context manager.

    Together they use as many threads as one would. On leaving they get a moment to finish; a job that is cut off is taken up
    again by the next worker.
    """

    def __init__(self, settings: Settings, count: int) -> None:
        self.environment = os.environ | {"ASPERITY_STATE_DIR": str(settings.state_path)}
        if settings.redis_url:
            self.environment["REDIS_URL"] = settings.redis_url
        self.environment.setdefault("OMP_NUM_THREADS", str(max(1, threads() // max(1, count))))
        self.count = count
        self.processes: list[subprocess.Popen[bytes]] = []
        self._stopping = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="worker-supervisor", daemon=True)

    def __enter__(self) -> "WorkerSupervisor":
        self._keeper.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._stopping.set()
        self._keeper.join()

    def _keep(self) -> None:
        """Start, watch and end the workers, all from one thread, because they die with the thread that started them."""
        while True:
            self.processes = [process for process in self.processes if process.poll() is None]
            try:
                while len(self.processes) < self.count:
                    self.processes.append(self._start())
            except (OSError, subprocess.SubprocessError):  # no memory or no process to be had now
                logger.exception("A worker could not be started; it is tried again.")
            if self._stopping.wait(RESTART_AFTER_S):
                break
        for process in self.processes:
            process.terminate()
        for process in self.processes:
            try:
                process.wait(STOP_TIMEOUT_S)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _start(self) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "worker"],
            env=self.environment,
            preexec_fn=partial(die_with_parent, os.getpid()),
            start_new_session=True,  # so that Ctrl-C does not cut their jobs off
        )
