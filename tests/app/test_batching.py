"""Predictions that wait together are computed together, each as if alone."""

import asyncio
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from app.batching import MOST, Batching
from app.compute import Compute
from app.computing import Item
from app.errors import BusyError, ComputeError, TruncatedPngError
from app.reading import Maps
from app.requests import PredictionFields
from app.schemas import PredictionAnswer
from app.settings import Settings
from solver.errors import AsperityError
from tests.app.conftest import UNITS
from tests.app.files import surface_png
from tests.app.test_compute import started
from worker.store import new_id

SURFACE = surface_png(128)
"""The network answers for it where that is good enough, and not the solver."""


def item(load: float, surface: bytes = SURFACE, accuracy: str = "fast", **fields: str) -> Item:
    form = PredictionFields.parse(UNITS | {"load_n": load, "verify": "false", "accuracy": accuracy} | fields)
    return Item(new_id(), Maps(surface), form, None, {})


@pytest.mark.anyio
async def test_many_at_once_are_answered_as_one_by_one(tmp_path: Path) -> None:
    loads = [5.0 + step for step in range(3 * MOST)]
    async with started(tmp_path, compute_processes=2) as compute:
        batching = Batching(compute)
        together = await asyncio.gather(*(batching.predict(item(load)) for load in loads))
        alone = [await batching.predict(item(load)) for load in loads[::5]]
    assert [answer.contact_area_mm2 for answer in together] == sorted(answer.contact_area_mm2 for answer in together)
    assert "surrogate" in {answer.method for answer in together}
    for one, other in zip(alone, together[::5], strict=True):
        assert one.method == other.method
        assert one.contact_area_mm2 == pytest.approx(other.contact_area_mm2, rel=0.01)


@pytest.mark.anyio
async def test_one_that_is_wrong_harms_no_other(tmp_path: Path) -> None:
    absurd = item(1e30, height_range_um="1e-150", pixel_size_um="1e20")
    items = [item(10.0), item(11.0, SURFACE[:-200]), item(12.0), item(13.0, accuracy="exact"), absurd, item(14.0)]
    async with started(tmp_path, compute_processes=1) as compute:
        found = await asyncio.gather(*map(Batching(compute).predict, items), return_exceptions=True)
    kinds = [type(one) for one in found]
    assert kinds[:4] == [PredictionAnswer, TruncatedPngError, PredictionAnswer, PredictionAnswer]
    assert isinstance(found[4], PredictionAnswer | AsperityError)
    assert kinds[5] is PredictionAnswer


@pytest.mark.anyio
async def test_one_that_kills_its_process_harms_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[int] = []

    async def fragile(self: Compute, task: object, items: list[Item]) -> list[str]:
        computed.append(len(items))
        if any(one.prediction_id == poison.prediction_id for one in items):
            raise BrokenProcessPool
        return [one.prediction_id for one in items]

    monkeypatch.setattr(Compute, "once", fragile)
    items = [item(load) for load in (1.0, 2.0, 3.0)]
    poison = items[1]
    batching = Batching(Compute(Settings(state_dir=tmp_path, compute_processes=1)))
    found = await asyncio.gather(*map(batching.predict, items), return_exceptions=True)
    assert [type(one) for one in found] == [str, ComputeError, str]
    assert computed == [1, 2, 1, 1, 1]


@pytest.mark.anyio
async def test_more_than_may_wait_are_refused(tmp_path: Path) -> None:
    async with started(tmp_path, compute_processes=1, requests_waiting=2) as compute:
        batching = Batching(compute)
        found = await asyncio.gather(*(batching.predict(item(5.0 + step)) for step in range(4)), return_exceptions=True)
    assert [type(one) for one in found] == [PredictionAnswer, PredictionAnswer, BusyError, BusyError]
