"""One surface under many loads: what changes with the load, point by point."""

from collections.abc import AsyncIterator
from dataclasses import replace

from app.compute import Computer
from app.reading import Files, read_problem
from app.requests import SweepForm
from app.schemas import SweepAnswer, SweepPoint
from app.service import Service
from model.methods import Accuracy
from model.prediction import Prediction
from solver import ContactProblem, boyer_resistance
from solver.contact_statistics import contact_spots
from solver.errors import AsperityError
from solver.stiffness import contact_stiffness
from worker.statistics import solution_of

LOADS_AT_ONCE = 8


async def sweep(service: Service, files: Files, form: SweepForm) -> tuple[SweepAnswer, AsyncIterator[SweepPoint]]:
    """Predict for many loads.

    Returns:
        The answer without its points, and the points as they are computed.

    Raises:
        AsperityError: bad input.
    """
    reading = await service.in_thread(read_problem, files, form, form.loads[0], service.sandbox.decode)
    answer = SweepAnswer(model=service.version, surface=reading.surface, warnings=reading.warnings, points=[])
    return answer, _points(service, reading.problem, form)


async def _points(service: Service, problem: ContactProblem, form: SweepForm) -> AsyncIterator[SweepPoint]:
    """A few loads at a time, so that the first come soon and other requests come in between."""
    for first in range(0, len(form.loads), LOADS_AT_ONCE):
        loads = form.loads[first : first + LOADS_AT_ONCE]
        for point in await service.compute.run(computed_points, problem, loads, form.accuracy, form.resistivity_ohm_m):
            yield point


def computed_points(
    computer: Computer, problem: ContactProblem, loads: list[float], accuracy: Accuracy, resistivity: float | None
) -> list[SweepPoint]:
    """Predict under each load; one that fails says why, and the others go on."""
    points: list[SweepPoint] = []
    while len(points) < len(loads):
        left = loads[len(points) :]
        try:
            for load, prediction in zip(left, computer.surrogate.predict_sweep(problem, left, accuracy), strict=True):
                points.append(_point(replace(problem, load=load), prediction, resistivity))
        except AsperityError as error:
            points.append(SweepPoint(load_n=loads[len(points)], error=str(error)))
    return points


def _point(problem: ContactProblem, prediction: Prediction, resistivity: float | None) -> SweepPoint:
    mask, expected = prediction.contact_mask, prediction.expected_error
    free = problem.boundary == "free"
    return SweepPoint(
        load_n=problem.load,
        contact_area_mm2=float(mask.sum()) * problem.pixel_area * 1e6,
        contact_fraction=float(mask.mean()),
        contact_spots=int(contact_spots(mask, problem.boundary).max()),
        contact_resistance_ohm=resistivity and boyer_resistance(mask, problem.pixel_size, resistivity),
        contact_stiffness_n_per_m=contact_stiffness(problem, solution_of(problem, prediction.pressure)) if free else None,
        contact_area_error=expected.contact_area,
        contact_resistance_error=expected.contact_resistance,
        in_distribution=prediction.in_distribution,
        method=prediction.method,
    )
