"""The surrogate: features, U-Net, data, training, evaluation and the shipped weights.

Names are imported on first use: the worker compares masks without loading torch.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from model.metrics import Comparison, compare
    from model.prediction import ExpectedError, Prediction
    from model.surrogate import Surrogate

_HOMES = {
    "Comparison": "model.metrics",
    "compare": "model.metrics",
    "ExpectedError": "model.prediction",
    "Prediction": "model.prediction",
    "Surrogate": "model.surrogate",
}

__all__ = ["Comparison", "ExpectedError", "Prediction", "Surrogate", "compare"]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
