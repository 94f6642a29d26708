"""Pictures of an evaluation, after Figs. 4 to 9 of the paper: predicted beside reference."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.held_out import HeldOutSet
from model.outcome import Outcome
from model.worst_cases import worst_cases
from solver.problem import BoolArray, FloatArray

Found = Sequence[tuple[HeldOutSet, Sequence[Outcome]]]

REFERENCE, PREDICTED = {"color": "tab:blue"}, {"color": "tab:red", "linestyle": "--"}
BOTH, MISSED, INVENTED = (255, 255, 255), (60, 120, 255), (255, 60, 40)


def draw_figures(directory: Path, found: Found) -> dict[str, str]:
    """Draw all pictures.

    Args:
        directory: gets them, as PNG.
        found: outcomes by held-out set.

    Returns:
        Captions by file, relative to the parent of the directory.
    """
    directory.mkdir(parents=True, exist_ok=True)
    by_scale = [pair for pair in found if pair[0].group.startswith("by scale")]
    by_load = [pair for pair in found if pair[0].group.startswith("by load")]
    outcomes = [(held_out, outcome) for held_out, several in found for outcome in several]
    key = "White touches in both, blue in the reference alone, red in the prediction alone; right, radial spectra."
    figures = {
        "scales": (_examples([(one, several[0]) for one, several in by_scale]), f"Masks by scale (Fig. 4). {key}"),
        "loads": (_examples([(one, several[0]) for one, several in by_load]), f"Masks by load (Fig. 5). {key}"),
        "areas": (_areas(outcomes), "Predicted and reference contact fraction of every map (Fig. 6)."),
        "by_scale": (_trends(by_scale), "Contact fraction and resistance by scale (Fig. 7)."),
        "by_load": (_trends(by_load), "Contact fraction and resistance by load (Fig. 8)."),
        "worst": (_examples(worst_cases(found)), f"The maps with the lowest Dice of all (Fig. 9). {key}"),
    }
    for name, (figure, _) in figures.items():
        figure.savefig(directory / f"{name}.png", dpi=80)
    return {f"{directory.name}/{name}.png": caption for name, (_, caption) in figures.items()}


def radial_spectrum(mask: BoolArray) -> FloatArray:
    """Mean power of a mask at each whole radial frequency, from 0 up to half the shorter side (paper Eqs. 22-25)."""
    power = np.abs(np.fft.fftshift(np.fft.fft2(mask))) ** 2
    rows, columns = mask.shape
    v, u = np.meshgrid(np.arange(rows) - rows // 2, np.arange(columns) - columns // 2, indexing="ij")
    radius = np.rint(np.hypot(u, v)).astype(np.intp)
    total, count = (np.bincount(radius.ravel(), weights) for weights in (power.ravel(), None))
    spectrum: FloatArray = (total / np.maximum(count, 1))[: min(rows, columns) // 2]
    return spectrum


def _figure(rows: int, columns: int, width: float, height: float) -> tuple[Figure, list[list[Axes]]]:
    mpl.rcParams["font.size"] = 8
    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    return figure, [list(row) for row in grid]


def _examples(pairs: Sequence[tuple[HeldOutSet, Outcome]]) -> Figure:
    """Heights, masks and spectra, one map a row."""
    figure, axes = _figure(max(len(pairs), 1), 3, 3.2, 2.8)
    for (held_out, outcome), (heights, masks, spectra) in zip(pairs, axes, strict=False):
        heights.imshow(outcome.problem.heights, cmap="gray")
        heights.set_title(held_out.name)
        reference, predicted = outcome.reference, outcome.prediction.contact_mask
        picture = np.zeros((*reference.shape, 3), np.uint8)
        picture[reference & predicted], picture[reference & ~predicted] = BOTH, MISSED
        picture[predicted & ~reference] = INVENTED
        masks.imshow(picture)
        masks.set_title(f"Dice {outcome.comparison.dice:.3f}, contact {reference.mean():.2%}")
        for mask, style, label in ((reference, REFERENCE, "reference"), (predicted, PREDICTED, "predicted")):
            spectra.loglog(np.maximum(radial_spectrum(mask)[1:], 1e-3), label=label, **style)
        spectra.set_xlabel("radial frequency")
        spectra.legend()
        for picture_axes in (heights, masks):
            picture_axes.set_axis_off()
    return figure


def _areas(outcomes: Sequence[tuple[HeldOutSet, Outcome]]) -> Figure:
    figure, ((axes,),) = _figure(1, 1, 5, 5)
    for group in dict.fromkeys(held_out.group for held_out, _ in outcomes):
        mine = [outcome for held_out, outcome in outcomes if held_out.group == group]
        axes.loglog(
            [outcome.reference.mean() for outcome in mine],
            [outcome.prediction.contact_mask.mean() for outcome in mine],
            ".",
            markersize=3,
            label=group,
        )
    axes.plot([1e-4, 1], [1e-4, 1], color="black", linestyle="--", linewidth=0.8)
    axes.set(xlabel="contact fraction, reference", ylabel="contact fraction, predicted")
    axes.legend()
    return figure


def _trends(found: Found) -> Figure:
    """Means over each set, reference as circles, predicted as squares."""
    figure, ((areas, resistances),) = _figure(1, 2, 4, 3.4)
    names = [held_out.name for held_out, _ in found]
    for which, (marker, label) in enumerate((("s", "predicted"), ("o", "reference"))):
        masks = [
            [(outcome.prediction.contact_mask, outcome.reference)[which].mean() for outcome in several]
            for _, several in found
        ]
        areas.plot(names, [np.mean(values) for values in masks], marker, label=label, fillstyle="none")
        values = [[outcome.resistances[which] for outcome in several] for _, several in found]
        resistances.plot(names, [np.mean(several) for several in values], marker, label=label, fillstyle="none")
    areas.set(ylabel="contact fraction")
    resistances.set(ylabel="resistance / resistivity, 1/m")
    areas.legend()
    return figure
