"""Time from upload to answer at 512 x 512, warm, against the reference solve of the same map in the same run.

asperity benchmark latency
"""

import time

import numpy as np

from benchmarks.service import midpoint_upload, post, service, wait_for_job

REPEATS = 20


def main() -> None:
    """Print the medians and their ratio."""
    png, fields = midpoint_upload(512, 30.0)
    fields |= {"resistivity_ohm_m": 1.7e-8}
    with service() as (client, _):
        for _ in range(3):
            post(client, png, **fields, verify=False)
        answers, seconds, solves = [], [], []
        for _ in range(REPEATS):
            started = time.perf_counter()
            fields["load_n"] *= 1.001  # a request of its own: what was computed before is only read again
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
