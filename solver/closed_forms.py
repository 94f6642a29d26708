"""Closed-form reference solutions, for tests and accuracy reports. SI units."""

from dataclasses import dataclass

import numpy as np

from solver.problem import FloatArray

SQUARE_PUNCH_STIFFNESS = 1.152
"""F / (E* L delta) of a rigid flat square punch of side L; by Barber's analogy the inverse of 0.868 rho / L, the resistance
of an isothermal square (Barber 2003, doi:10.1098/rspa.2002.1038)."""


@dataclass(frozen=True)
class HertzSphere:
    """Elastic contact of a sphere with a flat.

    Attributes:
        radius: of the sphere, m.
        load: N.
        effective_modulus: E*, Pa.

    Source: Johnson 1985, Contact Mechanics, Eqs. 4.22-4.24.
    """

    radius: float
    load: float
    effective_modulus: float

    @property
    def contact_radius(self) -> float:
        """a = (3 F R / 4 E*)^(1/3), m."""
        return float((3 * self.load * self.radius / (4 * self.effective_modulus)) ** (1 / 3))

    @property
    def peak_pressure(self) -> float:
        """p0 = 3 F / (2 pi a^2), Pa."""
        return float(3 * self.load / (2 * np.pi * self.contact_radius**2))

    @property
    def approach(self) -> float:
        """delta = a^2 / R, m."""
        return self.contact_radius**2 / self.radius

    def pressure(self, r: FloatArray) -> FloatArray:
        """p0 sqrt(1 - r^2 / a^2) within the contact radius, zero outside; Pa at the distances r, m."""
        pressure: FloatArray = self.peak_pressure * np.sqrt(np.maximum(1 - (r / self.contact_radius) ** 2, 0))
        return pressure


@dataclass(frozen=True)
class WestergaardSinusoid:
    """Periodic contact of a flat with a surface z = amplitude * cos(2 pi x / wavelength), the same along y.

    Attributes:
        amplitude: m.
        wavelength: m.
        effective_modulus: E*, Pa.

    Source: Westergaard 1939; Johnson 1985, Contact Mechanics, Eqs. 13.5-13.8.
    """

    amplitude: float
    wavelength: float
    effective_modulus: float

    @property
    def full_contact_pressure(self) -> float:
        """p* = pi E* amplitude / wavelength: the mean pressure that just closes the valleys, Pa."""
        return float(np.pi * self.effective_modulus * self.amplitude / self.wavelength)

    def contact_half_width(self, mean_pressure: float) -> float:
        """Half width a of one contact strip, m: mean pressure = p* sin^2(pi a / wavelength)."""
        ratio = min(mean_pressure / self.full_contact_pressure, 1.0)
        return float(self.wavelength / np.pi * np.arcsin(np.sqrt(ratio)))

    def pressure(self, x: FloatArray, mean_pressure: float) -> FloatArray:
        """Pressure at x, Pa; the crests are at multiples of the wavelength."""
        peak = self.full_contact_pressure
        if mean_pressure >= peak:
            full: FloatArray = mean_pressure + peak * np.cos(2 * np.pi * x / self.wavelength)
            return full
        edge = np.sin(np.pi * self.contact_half_width(mean_pressure) / self.wavelength) ** 2
        phase = np.pi * x / self.wavelength
        partial: FloatArray = 2 * peak * np.abs(np.cos(phase)) * np.sqrt(np.maximum(edge - np.sin(phase) ** 2, 0))
        return partial


def uniform_square_centre_displacement(side: float, pressure: float, effective_modulus: float) -> float:
    """Displacement, m, at the centre of a square under uniform pressure: 4 ln(1 + sqrt 2) / pi * p L / E*.

    Source: Love 1929; Johnson 1985, Contact Mechanics, Eq. 3.25.
    """
    return float(4 * np.log(1 + np.sqrt(2)) / np.pi * pressure * side / effective_modulus)


def annulus_resistance(inner_radius: float, outer_radius: float, resistivity: float) -> float:
    """Constriction resistance, ohm, of an annular spot at one potential, to 0.1 % where inner < 0.9 * outer radius.

    Source: Smythe 1951, The capacitance of a circular annulus, J. Appl. Phys. 22, 1499.
    """
    ratio = inner_radius / outer_radius
    main = np.arccos(ratio) + np.sqrt(1 - ratio**2) * np.arctanh(ratio)
    correction = 1 + 0.0143 / ratio * np.tan(1.28 * ratio) ** 3
    return float(np.pi * resistivity / (4 * outer_radius * main * correction))
