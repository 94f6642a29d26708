"""`python -m worker`: one worker with the settings of the environment."""

from worker.process import run_worker
from worker.settings import Settings

run_worker(Settings())
