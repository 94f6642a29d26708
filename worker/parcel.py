"""What travels to and from the worker through Redis besides small JSON: the problem, and the fields of its solution.

A worker needs nothing but the Redis, so it can run on a machine that shares no files with the service.
"""

from dataclasses import dataclass
from io import BytesIO
from typing import Literal

import numpy as np
from redis import Redis

from solver.problem import BoolArray, ContactProblem
from worker.errors import JobNotFoundError

PARCEL_GRACE_S = 600

FieldName = Literal["pressure", "gap"]
Output = Literal["pressure", "gap", "statistics", "resistances"]
"""What a reference solve can be asked for besides its mask and areas."""


@dataclass(frozen=True, eq=False)
class Parcel:
    """A problem to solve, and what is wanted of the solution.

    Attributes:
        problem: handed on unchanged, bit for bit.
        predicted_mask: to compare the solution with, shape (rows, columns); None if nothing was predicted.
        resistivity: in ohm m; None if no resistance is asked for.
        outputs: what else.
        model: version of what predicted; empty if nothing was.
    """

    problem: ContactProblem
    predicted_mask: BoolArray | None = None
    resistivity: float | None = None
    outputs: tuple[Output, ...] = ()
    model: str = ""

    def pack(self) -> bytes:
        """As an NPZ file, not compressed: heights of 16 bits shrink by a fifth only, at 50 ms for 512 x 512."""
        file = BytesIO()
        np.savez(
            file,
            heights=self.problem.heights,
            pixel_size=np.array(self.problem.pixel_size),
            load=np.array(self.problem.load),
            effective_modulus=np.array(self.problem.effective_modulus),
            boundary=np.array(self.problem.boundary),
            hardness=np.array([] if self.problem.hardness is None else [self.problem.hardness]),
            predicted_mask=np.array([]) if self.predicted_mask is None else self.predicted_mask,
            outputs=np.array(self.outputs, dtype=np.str_),
            model=np.array(self.model, dtype=np.str_),
            resistivity=np.array([] if self.resistivity is None else [self.resistivity]),
        )
        return file.getvalue()

    @classmethod
    def unpack(cls, data: bytes) -> "Parcel":
        """From an NPZ file; nothing in it is ever unpickled."""
        with np.load(BytesIO(data), allow_pickle=False) as arrays:
            dy, dx = arrays["pixel_size"].tolist()
            problem = ContactProblem(
                heights=arrays["heights"],
                pixel_size=(dy, dx),
                load=arrays["load"].item(),
                effective_modulus=arrays["effective_modulus"].item(),
                boundary=arrays["boundary"].item(),
                hardness=next(iter(arrays["hardness"].tolist()), None),
            )
            resistivity = arrays["resistivity"].tolist()
            predicted = arrays["predicted_mask"]
            return cls(
                problem,
                predicted if predicted.size else None,
                resistivity[0] if resistivity else None,
                tuple(arrays["outputs"].tolist()),
                arrays["model"].item(),
            )


class JobKeys:
    """The keys of one job that are ours and not RQ's."""

    def __init__(self, connection: Redis, job_id: str) -> None:
        self.connection = connection
        self.parcel = f"asperity:parcel:{job_id}"
        self.reference_mask = f"asperity:reference-mask:{job_id}"
        self.fields: dict[FieldName, str] = {name: f"asperity:{name}:{job_id}" for name in ("pressure", "gap")}
        self.cancel_request = f"asperity:cancel:{job_id}"

    def send_parcel(self, parcel: Parcel, keep_s: int) -> None:
        """Leave a parcel for the worker."""
        self.connection.set(self.parcel, parcel.pack(), ex=keep_s)

    def receive_parcel(self) -> Parcel:
        """The parcel, which stays where it is.

        Raises:
            JobNotFoundError: it has expired.
        """
        data = self.connection.get(self.parcel)
        if not isinstance(data, bytes):
            raise JobNotFoundError("The problem to verify has expired; send it again.")
        return Parcel.unpack(data)

    def expire_parcel(self) -> None:
        """Forget the parcel soon: a worker lost between this and its last word to RQ leaves the job to another."""
        self.connection.expire(self.parcel, PARCEL_GRACE_S)

    def drop_parcel(self) -> None:
        """Forget the parcel now."""
        self.connection.delete(self.parcel)

    def request_cancel(self, keep_s: int) -> None:
        """Ask whoever runs the job, now or later, to stop."""
        self.connection.set(self.cancel_request, b"1", ex=keep_s)

    def cancel_requested(self) -> bool:
        """Whether the job is to stop."""
        return bool(self.connection.exists(self.cancel_request))
