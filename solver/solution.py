"""The solution of a contact problem, and the status that says how far it can be trusted."""

from dataclasses import dataclass
from enum import Enum

from solver.errors import NotConvergedError
from solver.problem import BoolArray, FloatArray


class Status(Enum):
    """How a solve ended; the value is the message for people."""

    CONVERGED = "Converged: a fresh check of the contact conditions is within the tolerance."
    ITERATION_LIMIT = "Stopped at the iteration limit: the pressure is the last one, not within the tolerance."
    STAGNATED = "Stagnated: rounding, or the error of the displacement, keeps the contact conditions from the tolerance."


@dataclass(frozen=True, eq=False)
class Solution:
    """Pressure and gap of a solved contact problem.

    Attributes:
        pressure: contact pressure in Pa, shape (rows, columns), non-negative; its sum balances the load.
        gap: deformed gap in m, shape (rows, columns); negative by at most ``residual`` times the height scale.
        approach: rigid displacement delta of the flat from its first touch of the undeformed surface, in m.
        iterations: number of iterations taken.
        status: whether the residual is within the tolerance; its value is the message for people.
        residual: the certificate (complementarity, penetration, load balance), dimensionless, evaluated afresh, with what
            the error of the displacement may add.
    """

    pressure: FloatArray
    gap: FloatArray
    approach: float
    iterations: int
    status: Status
    residual: float

    @property
    def converged(self) -> bool:
        """Whether the fresh certificate is within the tolerance."""
        return self.status is Status.CONVERGED

    def checked(self) -> "Solution":
        """Itself, if it converged.

        Raises:
            NotConvergedError: it did not.
        """
        if not self.converged:
            raise NotConvergedError(f"{self.status.value} The residual is {self.residual:.1e}.")
        return self

    @property
    def contact_mask(self) -> BoolArray:
        """Where the bodies touch (p > 0), shape (rows, columns)."""
        mask: BoolArray = self.pressure > 0
        return mask

    @property
    def contact_fraction(self) -> float:
        """Real area of contact / nominal area."""
        return float(self.contact_mask.mean())
