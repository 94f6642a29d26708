"""The HTTP application."""

import asyncio
import gc
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version

from fastapi import Depends, FastAPI
from fastapi.staticfiles import StaticFiles
from fastapi_swagger import patch_fastapi

from app.intake import Intake
from app.keys import Gate, bearer
from app.observation import Observation
from app.problem import MEDIA_TYPE, Problem
from app.problems import add_problem_handlers
from app.routes import batches, health, jobs, models, pages, predictions, problems, solves, sweeps
from app.service import Service
from app.settings import Settings

SWITCH_INTERVAL_S = 0.0005
"""After which a thread lets the event loop on, ten times sooner than usual."""


def create_app(settings: Settings) -> FastAPI:
    """The application; the queue must be reachable with these settings for verifications, not for predictions."""

    service = Service(settings)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await service.start()
        gc.collect()
        gc.freeze()  # else each full collection visits all modules, and the event loop waits for it
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        watch = asyncio.create_task(service.metrics.watch_loop())
        yield
        watch.cancel()
        await asyncio.to_thread(service.stop)

    app = FastAPI(
        title="Asperity",
        summary="Contact of rough surfaces: mask, area and resistance, checked by a reference solve.",
        version=version("asperity"),
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        swagger_ui_oauth2_redirect_url=None,
        responses={"default": {"model": Problem, "description": "A problem document", "content": {MEDIA_TYPE: {}}}},
    )
    app.state.service = service
    app.add_middleware(Intake, limit_mib=settings.upload_limit_mib)
    app.add_middleware(Gate, settings=settings)
    app.add_middleware(Observation, metrics=service.metrics)
    add_problem_handlers(app)
    for routes in (predictions, sweeps, solves, batches, jobs, models):
        app.include_router(routes.router, dependencies=[Depends(bearer)])
    for routes in (health, problems, pages):
        app.include_router(routes.router)
    patch_fastapi(app, redirect_from_root_to_docs=False)
    app.mount("/web", StaticFiles(directory=pages.WEB))
    return app
