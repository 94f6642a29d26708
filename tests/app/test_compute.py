"""Processes that compute: what they answer, what they refuse, and what becomes of errors on the way."""

import asyncio
import os
import pickle
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from app.compute import Compute, Computer
from app.errors import BusyError, ComputeError, FieldError, InvalidFormError
from app.settings import Settings
from model import Surrogate
from solver.errors import InvalidLoadError
from worker.logs import request_id


def version(computer: Computer) -> tuple[str, int, str | None]:
    return computer.surrogate.version, os.getpid(), request_id.get()


def refuse(_: Computer, load: float) -> None:
    raise InvalidLoadError(f"The load is {load:g} N.")


def die(_: Computer) -> None:
    os._exit(1)


@asynccontextmanager
async def started(state: Path, **settings: object) -> AsyncIterator[Compute]:
    compute = Compute(Settings(state_dir=state, **settings))  # type: ignore[arg-type]
    await compute.start()
    try:
        yield compute
    finally:
        compute.stop()


@pytest.mark.anyio
async def test_tasks_run_elsewhere_under_the_id_of_their_request(tmp_path: Path) -> None:
    async with started(tmp_path, compute_processes=1) as compute:
        token = request_id.set("mine")
        found, process, request = await compute.run(version)
        request_id.reset(token)
        assert (found, request) == (Surrogate.load().version, "mine")
        assert process != os.getpid()
        assert compute.check() == found
        with pytest.raises(InvalidLoadError, match="-3 N"):
            await compute.run(refuse, -3.0)


@pytest.mark.anyio
async def test_a_task_that_kills_its_process_twice_is_given_up(tmp_path: Path) -> None:
    async with started(tmp_path, compute_processes=1) as compute:
        with pytest.raises(ComputeError, match="died twice"):
            await compute.run(die)
        assert (await compute.run(version))[0] == Surrogate.load().version


@pytest.mark.anyio
async def test_more_than_may_wait_are_refused(tmp_path: Path) -> None:
    async with started(tmp_path, compute_processes=1, requests_waiting=2) as compute:
        answers = await asyncio.gather(*(compute.run(version) for _ in range(5)), return_exceptions=True)
    assert [type(answer) for answer in answers] == [tuple, tuple, BusyError, BusyError, BusyError]


def test_nothing_is_computed_before_the_start(tmp_path: Path) -> None:
    with pytest.raises(ComputeError, match="not started"):
        Compute(Settings(state_dir=tmp_path)).check()


def test_errors_by_field_survive_the_way_from_process_to_process() -> None:
    error = InvalidFormError([FieldError("load_n", "missing", "load_n is missing."), FieldError("crop", "invalid", "Crop.")])
    again = pickle.loads(pickle.dumps(error))  # noqa: S301 (what multiprocessing does between processes of ours)
    assert again.errors == error.errors
    assert str(again) == str(error)
