"""What a job costs besides its solve, and how soon a running one is canceled.

    asperity benchmark jobs

`overhead` is the time from the end of the request to the end of the job, less the solve; `cancel` is the time from DELETE to
the worker's being free, for a solve of 1024 x 1024 pixels that runs.
"""

import time

import numpy as np

from benchmarks.service import midpoint_upload, service, wait_for_job

REPEATS = 30
CANCELED = 10


def main() -> None:
    """Print the medians."""
    with service() as (client, _):
        png, fields = midpoint_upload(64, 30.0)
        data = {name: str(value) for name, value in fields.items()}
        overheads = []
        for _ in range(REPEATS):
            job_id = client.post("/v1/solves", files={"surface": png}, data=data).json()["job"]["job_id"]
            started = time.perf_counter()
            job = wait_for_job(client, job_id, look_every_s=0.004)
            overheads.append((time.perf_counter() - started - job["result"]["solve_seconds"]) * 1e3)
        big, fields = midpoint_upload(1024, 30.0)
        data = {name: str(value) for name, value in fields.items()}
        cancels = []
        for _ in range(CANCELED):
            url = client.post("/v1/solves", files={"surface": big}, data=data).json()["job"]["url"]
            while not client.get(url).json()["progress"]:
                time.sleep(0.02)
            started = time.perf_counter()
            client.delete(url)
            # the next job starts when the worker is free
            small = client.post("/v1/solves", files={"surface": png}, data=data).json()["job"]["url"]
            while client.get(small).json()["status"] == "queued":
                time.sleep(0.005)
            cancels.append((time.perf_counter() - started) * 1e3)
            wait_for_job(client, small.rpartition("/")[2])
    print("| | median ms | highest ms |\n|---|---|---|")
    for name, found in (("overhead", overheads), ("cancel", cancels)):
        print(f"| {name} | {np.median(found):.0f} | {max(found):.0f} |")


if __name__ == "__main__":
    main()
