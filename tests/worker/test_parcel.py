import numpy as np
import pytest
from redis import Redis

from solver import ContactProblem
from worker.errors import JobNotFoundError
from worker.parcel import JobKeys, Parcel


@pytest.mark.parametrize("resistivity", [None, 1.7e-8])
@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_problem_arrives_bit_for_bit(connection: Redis, resistivity: float | None, boundary: str) -> None:
    generator = np.random.default_rng(0)
    heights = generator.standard_normal((7, 12)) * 1e-6
    problem = ContactProblem(heights, (1e-6 / 3, 2e-6 / 3), 0.1, 1e9 / 3, boundary)  # type: ignore[arg-type]
    mask = generator.random((7, 12)) > 0.5
    keys = JobKeys(connection, "some-job")
    keys.send_parcel(Parcel(problem, mask, resistivity), keep_s=60)
    arrived = keys.receive_parcel()
    assert arrived.problem.heights.tobytes() == problem.heights.tobytes()
    assert arrived.problem.pixel_size == problem.pixel_size
    assert (arrived.problem.load, arrived.problem.effective_modulus) == (problem.load, problem.effective_modulus)
    assert arrived.problem.boundary == boundary
    assert arrived.resistivity == resistivity
    np.testing.assert_array_equal(arrived.predicted_mask, mask)
    keys.drop_parcel()
    with pytest.raises(JobNotFoundError, match="expired"):
        keys.receive_parcel()
