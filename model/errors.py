"""Typed errors of the offline part: data sets, training and weights."""

from solver.errors import AsperityError


class DatasetError(AsperityError):
    """A data set that does not match what was asked of it."""

    code = "invalid-dataset"
    title = "The data set cannot be used"
    http_status = 422


class DivergedError(AsperityError):
    """A training that went astray."""

    code = "training-diverged"
    title = "The training diverged"


class WeightsError(AsperityError):
    """Weights that are missing or whose hash is not the one promised."""

    code = "weights-unavailable"
    title = "The surrogate's weights cannot be loaded"
    http_status = 503


class AccuracyError(AsperityError):
    """An accuracy that cannot be asked for."""

    code = "invalid-accuracy"
    title = "The accuracy is not one that can be asked for"
    http_status = 422


class AttributionError(AsperityError):
    """An attribution without the package that it needs."""

    code = "attribution-unavailable"
    title = "Attributions are not available"
    http_status = 501
