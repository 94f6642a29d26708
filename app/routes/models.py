"""The surrogate that predicts."""

from fastapi import APIRouter

from app.routes.dependencies import ServiceDependency
from app.schemas import ModelAnswer

router = APIRouter(prefix="/v1/models", tags=["models"])


@router.get("")
def list_models(service: ServiceDependency) -> list[ModelAnswer]:
    """Name, version, hash, training domain and measured error of what predicts."""
    return [service.model()]
