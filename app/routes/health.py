"""Liveness, readiness and metrics."""

from fastapi import APIRouter, Response
from prometheus_client import CONTENT_TYPE_LATEST
from pydantic import BaseModel

from app.documentation import file, problems
from app.errors import ComputeError
from app.routes.dependencies import ServiceDependency
from model.errors import WeightsError
from worker.errors import QueueUnavailableError

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """All is well; what is not is a problem document."""

    status: str
    model: str | None = None


@router.get("/healthz", response_model_exclude_none=True)
async def healthz() -> Health:
    """Whether the process lives."""
    return Health(status="ok")


@router.get("/readyz", responses=problems(WeightsError, ComputeError, QueueUnavailableError))
async def readyz(service: ServiceDependency) -> Health:
    """Whether predictions and verifications can be made: weights loaded, queue reachable; 503 with the cause if not."""
    return Health(status="ok", model=await service.check())


@router.get("/metrics", response_class=Response, responses=file("text/plain", "string"))
def metrics(service: ServiceDependency) -> Response:
    """Latency by stage, queue depth, outcomes of jobs, and Dice of finished verifications by model, for Prometheus."""
    return Response(service.metrics.text(), media_type=CONTENT_TYPE_LATEST)
