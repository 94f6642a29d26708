import numpy as np
import pytest
from scipy.integrate import quad

from solver.closed_forms import HertzSphere, WestergaardSinusoid


def test_hertz_pressure_carries_the_load() -> None:
    sphere = HertzSphere(radius=0.01, load=5.0, effective_modulus=1e11)
    carried, _ = quad(lambda r: float(sphere.pressure(np.array(r))) * 2 * np.pi * r, 0, sphere.contact_radius)
    assert carried == pytest.approx(5.0, rel=1e-6)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.99, 1.0, 3.0])
def test_westergaard_pressure_has_the_mean_asked_for(share: float) -> None:
    wave = WestergaardSinusoid(amplitude=1e-6, wavelength=1e-4, effective_modulus=5e10)
    mean = share * wave.full_contact_pressure
    x = (np.arange(200_000) + 0.5) / 200_000 * wave.wavelength
    assert wave.pressure(x, mean).mean() == pytest.approx(mean, rel=1e-5)
