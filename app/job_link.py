"""Where a job can be followed."""

from app.schemas import JobLink


def job_link(job_id: str) -> JobLink:
    """The links of a job."""
    url = f"/v1/jobs/{job_id}"
    return JobLink(job_id=job_id, url=url, events_url=f"{url}/events")
