"""What the HTTP interface answers."""

from datetime import datetime
from typing import Generic, Literal, TypeVar

from pydantic import BaseModel, Field

from app.fields import FieldName
from app.problem import Problem
from app.surface import Surface
from worker.statistics import Resistances, RoughnessParameters, Statistics

Item = TypeVar("Item")


class ExpectedError(BaseModel):
    """Errors to be expected of a prediction, all relative: their means, and bounds that nine in ten stay below."""

    dice: float = Field(description="1 - Dice of the mask")
    contact_area: float
    contact_resistance: float
    dice_bound: float
    contact_area_bound: float
    contact_resistance_bound: float


class Numbers(BaseModel):
    """What is predicted of a contact, but for the mask."""

    method: str = Field(description="'surrogate', 'surrogate and solver', or 'solver': the cheapest that is accurate")
    model: str = Field(description="version of the surrogate")
    contact_area_mm2: float = Field(description="real area of contact")
    contact_fraction: float = Field(description="real area of contact / nominal area")
    contact_resistance_ohm: float | None = Field(description="null without a resistivity")
    expected_error: ExpectedError
    in_distribution: bool = Field(description="whether the surrogate was trained on such problems; the warnings say why not")
    statistics: Statistics | None = Field(description="null unless asked for by outputs, as the two below")
    resistances: Resistances | None
    roughness: RoughnessParameters | None
    surface: Surface
    warnings: list[str]
    timings_ms: dict[str, float] = Field(description="by stage, and their total")


class Progress(BaseModel):
    """How far the reference solve is."""

    iteration: int
    residual: float
    seconds_left: float | None = Field(description="if it goes on as before; null where that cannot be said")


class ReferenceAnswer(BaseModel):
    """The reference solution; its fields are files of their own."""

    contact_area_mm2: float
    contact_fraction: float
    contact_resistance_ohm: float | None
    status: str = Field(description="how the solve ended, for people")
    converged: bool
    residual: float
    iterations: int
    solve_seconds: float
    statistics: Statistics | None = Field(description="null unless asked for by outputs, as the next")
    resistances: Resistances | None
    mask_url: str = Field(description="1-bit PNG of the reference mask")


class ComparisonAnswer(BaseModel):
    """Agreement of a prediction with its reference."""

    dice: float
    jaccard: float
    bf_score: float = Field(description="boundary F1 score, tolerance 2 pixels")
    pixel_accuracy: float
    area_error: float = Field(description="predicted / reference - 1")
    resistance_error: float | None = Field(description="predicted / reference - 1; null without a resistivity")


class JobAnswer(BaseModel):
    """A reference solve in the queue."""

    id: str
    kind: Literal["verification", "solve"] = Field(description="whether it checks a prediction")
    status: Literal["queued", "started", "finished", "failed", "canceled"]
    queue_position: int | None = Field(description="jobs before it; null once it has started")
    progress: Progress | None
    result: ReferenceAnswer | None
    comparison: ComparisonAnswer | None = Field(description="of a verification that has finished")
    error: str | None = Field(description="why a failed job failed")
    created_at: datetime | None
    started_at: datetime | None
    ended_at: datetime | None


class JobLink(BaseModel):
    """Where a job can be followed."""

    job_id: str
    url: str
    events_url: str = Field(description="the same as server-sent events")
    state: JobAnswer | None = Field(default=None, description="where it stood when `Prefer: wait=N` ended")


class FieldLink(BaseModel):
    """A field asked for by outputs, as files; in the PNG black is `lowest` and white `highest`."""

    unit: str
    lowest: float
    highest: float
    npy_url: str
    png_url: str


class PredictionAnswer(Numbers):
    """A stored prediction."""

    id: str
    mask_url: str = Field(description="1-bit PNG, white in contact, rows and columns as uploaded")
    mask: str | None = Field(description="the same PNG in base64, if asked for by inline_mask")
    fields: dict[FieldName, FieldLink] = Field(description="by name")
    bundle_url: str = Field(description="netCDF file with the mask and the fields, a unit on each")
    verification: JobLink | None


class Pending(BaseModel):
    """A prediction that is computed after the request has been answered."""

    id: str
    url: str = Field(description="where it will be")


class SolveAnswer(BaseModel):
    """A reference solve that was queued."""

    job: JobLink
    surface: Surface
    warnings: list[str]


class ModelAnswer(BaseModel):
    """The surrogate that predicts."""

    name: str
    version: str = Field(description="name and start of the hash of the weights")
    sha256: str
    domain: dict[str, tuple[float, float]] = Field(
        description="lowest and highest in training: load, log10 F / (E* A0 rms slope); aspect, ln dy / dx; detail, log10 "
        "of the rms roughness within 4 x 4 pixels over rms slope and pixel side; skewness; kurtosis, its log10"
    )
    measured_error: dict[str, dict[str, float]] = Field(description="of the network alone on held-out maps, by grid")


class Page(BaseModel, Generic[Item]):
    """Some items, newest first."""

    items: list[Item]
    next: str | None = Field(description="URL of the next page; null on the last")


class BatchItem(BaseModel):
    """One height map of an archive: its prediction, or why there is none."""

    file: str
    prediction: PredictionAnswer | None
    problem: Problem | None


class SweepPoint(BaseModel):
    """One load of a sweep; null what is not defined, or what failed."""

    load_n: float
    contact_area_mm2: float | None = None
    contact_fraction: float | None = None
    contact_spots: int | None = None
    contact_resistance_ohm: float | None = Field(default=None, description="null without a resistivity")
    contact_stiffness_n_per_m: float | None = Field(default=None, description="null on a periodic boundary")
    contact_area_error: float | None = Field(default=None, description="to be expected, relative")
    contact_resistance_error: float | None = Field(default=None, description="to be expected, relative")
    in_distribution: bool | None = None
    method: str | None = None
    error: str | None = Field(default=None, description="why there is no answer for this load")


class SweepAnswer(BaseModel):
    """One surface under many loads."""

    model: str
    surface: Surface
    warnings: list[str]
    points: list[SweepPoint]
