"""The surrogate that predicts."""

from fastapi import APIRouter

from app.documentation import problems
from app.routes.dependencies import ServiceDependency
from app.schemas import ModelAnswer
from model.errors import WeightsError

router = APIRouter(prefix="/v1/models", tags=["models"])


@router.get("", responses=problems(WeightsError))
def list_models(service: ServiceDependency) -> list[ModelAnswer]:
    """Name, version, hash, training domain and measured error of what predicts."""
    return [service.model()]
