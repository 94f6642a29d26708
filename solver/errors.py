"""The root of the one tree of typed errors.

Every error that a person can cause or must know of descends from :class:`AsperityError`. Its message says what is wrong
and what to change; ``code`` is its stable name and ``http_status`` the status a service answers with.
"""

from typing import ClassVar


class AsperityError(Exception):
    """Base of all typed errors of Asperity."""

    code: ClassVar[str] = "internal-error"
    title: ClassVar[str] = "Internal error"
    http_status: ClassVar[int] = 500


class InvalidProblemError(AsperityError):
    """A contact problem that has no meaning: the message names the offending value and what is allowed."""

    code = "invalid-problem"
    title = "The contact problem is not valid"
    http_status = 422


class InvalidHeightsError(InvalidProblemError):
    """Heights of the wrong shape or with values that are not finite."""

    code = "invalid-heights"
    title = "The height map is not valid"


class InvalidLoadError(InvalidProblemError):
    """A load that is not a positive finite number of newtons."""

    code = "invalid-load"
    title = "The load is not valid"


class InvalidPixelSizeError(InvalidProblemError):
    """A pixel size that is not positive and finite."""

    code = "invalid-pixel-size"
    title = "The pixel size is not valid"


class InvalidMaterialError(InvalidProblemError):
    """Elastic or electric constants outside their physical range."""

    code = "invalid-material"
    title = "The material is not valid"


class NotConvergedError(AsperityError):
    """An answer was asked for where the solver could not reach its tolerance."""

    code = "not-converged"
    title = "The contact solve did not converge"
    http_status = 422
