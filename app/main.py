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

from app.documentation import PROBLEM, Documented
from app.documentation import problems as problems_of
from app.intake import Intake
from app.keys import Gate, bearer
from app.observation import Observation
from app.problem import MEDIA_TYPE
from app.problems import add_problem_handlers
from app.routes import batches, health, jobs, models, pages, predictions, problems, solves, sweeps
from app.routes.problem_groups import GATE
from app.service import Service
from app.settings import Settings
from worker.connection import client

SWITCH_INTERVAL_S = 0.0005
"""After which a thread lets the event loop on, ten times sooner than usual."""


def create_app(settings: Settings) -> FastAPI:
    """The application; the queue must be reachable with these settings for verifications, not for predictions."""

    client(settings)  # one that cannot be made is refused before the start
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
        await service.stop()

    app = Documented(
        title="Asperity",
        summary="Contact of rough surfaces: mask, area and resistance, checked by a reference solve.",
        version=version("asperity"),
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        swagger_ui_oauth2_redirect_url=None,
        generate_unique_id_function=lambda route: route.name,
        responses={"default": {"description": "A problem document", "content": {MEDIA_TYPE: {"schema": PROBLEM}}}},
    )
    app.state.service = service
    app.add_middleware(Intake, limit_mib=settings.upload_limit_mib)
    app.add_middleware(Gate, settings=settings)
    app.add_middleware(Observation, metrics=service.metrics)
    add_problem_handlers(app)
    guarded = [Depends(bearer)] if settings.api_keys else []
    for routes in (predictions, sweeps, solves, batches, jobs, models):
        app.include_router(routes.router, dependencies=guarded, responses=problems_of(*GATE))
    for routes in (health, problems, pages):
        app.include_router(routes.router)
    patch_fastapi(app, redirect_from_root_to_docs=False)
    app.mount("/web", StaticFiles(directory=pages.WEB))
    return app
