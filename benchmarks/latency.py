"""Time from upload to answer at 512 x 512, warm, against the reference solve of the same map in the same run.

asperity benchmark latency
"""

import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.service import post, service, wait_for_job
from model.dataset import DatasetConfig, build, read_samples

REPEATS = 20


def main() -> None:
    """Print the medians and their ratio."""
    with tempfile.TemporaryDirectory() as directory, service() as (client, _):
        build(Path(directory), DatasetConfig(size=512, count=1, seed=30_000_000, load_range_n=(30.0, 30.0)))
        (sample,) = read_samples(Path(directory))
        png = (Path(directory) / sample.heights).read_bytes()
        fields = {
            "load_n": sample.load_n,
            "pixel_size_um": sample.pixel_size_x_um,
            "height_range_um": sample.height_range_um,
            "effective_modulus_gpa": sample.effective_modulus_gpa,
            "resistivity_ohm_m": 1.7e-8,
        }
        for _ in range(3):
            post(client, png, **fields, verify=False)
        answers, seconds, solves = [], [], []
        for _ in range(REPEATS):
            started = time.perf_counter()
            answers.append(post(client, png, **fields, verify=False))
            seconds.append(time.perf_counter() - started)
        for _ in range(5):
            verification = post(client, png, **fields)["verification"]
            solves.append(wait_for_job(client, verification["job_id"])["result"]["solve_seconds"])
    stages = {stage: float(np.median([a["timings_ms"][stage] for a in answers])) for stage in answers[0]["timings_ms"]}
    print(f"upload to answer, median of {REPEATS}: {np.median(seconds) * 1e3:.0f} ms; by stage, ms:")
    print("  " + ", ".join(f"{stage} {milliseconds:.1f}" for stage, milliseconds in stages.items()))
    print(f"reference solve in the worker, median of 5: {np.median(solves) * 1e3:.0f} ms")
    print(f"ratio {np.median(solves) / np.median(seconds):.2f}")


if __name__ == "__main__":
    main()
