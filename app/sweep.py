"""One surface under many loads: what changes with the load, point by point."""

from collections.abc import AsyncIterator, Iterator
from dataclasses import replace

from app.reading import Files, read_problem
from app.requests import SweepForm
from app.schemas import SweepAnswer, SweepPoint
from app.service import Service
from model import Surrogate
from model.prediction import Prediction
from solver import ContactProblem, boyer_resistance
from solver.contact_statistics import contact_spots
from solver.errors import AsperityError
from solver.stiffness import contact_stiffness
from worker.statistics import solution_of


async def sweep(service: Service, files: Files, form: SweepForm) -> tuple[SweepAnswer, AsyncIterator[SweepPoint]]:
    """Predict for many loads.

    Returns:
        The answer without its points, and the points as they are computed.

    Raises:
        AsperityError: bad input.
    """
    load = form.loads[0]
    reading = await service.in_thread(read_problem, files, form, load, service.sandbox.decode)
    surrogate = service.surrogate
    points = sweep_points(surrogate, reading.problem, form)
    answer = SweepAnswer(model=surrogate.version, surface=reading.surface, warnings=reading.warnings, points=[])
    return answer, service.one_by_one(points)


def sweep_points(surrogate: Surrogate, problem: ContactProblem, form: SweepForm) -> Iterator[SweepPoint]:
    """Predict under each load of a form, in its order; a load that fails says why, and the others go on."""
    problems = [replace(problem, load=load) for load in form.loads]
    answers = surrogate.predict_sweep(problem, form.loads, form.accuracy)
    for one in problems:
        try:
            yield _point(one, next(answers), form.resistivity_ohm_m)
        except AsperityError as error:
            yield SweepPoint(load_n=one.load, error=str(error))


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
