"""What each idea of the recipe brings: networks trained on the same maps for the same time, one idea changed in each.

    asperity benchmark ablation [SECONDS]

Random midpoint surfaces of 64 x 64 and 128 x 128 pixels under 0.5 to 50 N, free boundary; all cores, one seed. Dice is the
mean over held-out maps, those with less than 1 % in contact apart, as is the bias of the area. `paper` is the U-Net of its
Fig. 2 on heights and load, BCE + Dice loss and Adam at 0.001; width 64 is its own, 16 sees more maps in the time.
"""

import math
import sys
import time
from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from tqdm import tqdm

from benchmarks.recipes import (
    GuessingNet,
    PaperNet,
    heights_alone,
    heights_and_load,
    mask_alone,
    ours,
    paper_loss,
    standardized,
    unweighted,
    with_residual,
)
from model.dataset import DatasetConfig, build
from model.features import Features, network_input
from model.metrics import compare
from model.network import WIDTHS, ContactNet
from model.prepared import Prepared, prepare
from model.train import FROZEN_FROM, Batch, freeze_norms, turned

DATA = Path("runs/ablation")
SEED = 50_000_000
COUNTS = {64: 8000, 128: 8000}
LOADS_N = (0.5, 50.0)
BATCH_PIXELS = 16 * 128**2
SECONDS = 120.0
RATE, DECAY = 2e-3, 0.999
LITTLE = 0.01


@dataclass(frozen=True)
class Variant:
    """A recipe: a network, what it sees, its loss, and whether the optimizer is ours or the paper's."""

    name: str
    network: Callable[[], nn.Module] = ContactNet
    see: Callable[[Features], Tensor] = network_input
    loss: Callable[[Tensor, Tensor, Features, Tensor], Tensor] = ours
    papers: bool = False
    times: float = 1.0
    small_first: bool = False


VARIANTS = (
    Variant("paper, width 64", lambda: PaperNet(64), heights_and_load, paper_loss, papers=True),
    Variant("paper, width 16", lambda: PaperNet(16), heights_and_load, paper_loss, papers=True),
    Variant("ours"),
    Variant("no coarse solution: heights alone", see=heights_alone),
    Variant("loss: mask alone, no pressure", loss=mask_alone),
    Variant("loss: BCE + Dice", loss=paper_loss),
    Variant("loss: maps with little contact weigh little", loss=unweighted),
    Variant("loss: contact conditions too", loss=with_residual),
    Variant("64 x 64 first, then 128 x 128", small_first=True),
    Variant("places of 4 x 4 pixels", lambda: ContactNet((64, 96, 128, 192), 4)),
    Variant("half as wide", lambda: ContactNet(tuple(width // 2 for width in WIDTHS))),
    Variant("half as wide again", lambda: ContactNet(tuple(width * 3 // 2 for width in WIDTHS))),
    Variant("a guess for each pixel to start from", GuessingNet),
    Variant("the same, standardized convolutions, no batch norms", lambda: standardized(GuessingNet())),
    Variant("four times as long", times=4.0),
)


def main() -> None:
    """Print a table, one variant a row."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS
    for size, number in COUNTS.items():
        build(DATA / str(size), DatasetConfig(size=size, count=number, seed=SEED, load_range_n=LOADS_N), processes=2)
    grids = prepare([DATA / str(size) for size in COUNTS], processes=2)
    print(f"| {seconds:g} s each | parameters, M | maps seen | 64 x 64 | 128 x 128 | less than 1 % | area bias |")
    print("|---|---|---|---|---|---|---|")
    for variant in VARIANTS:
        network, seen = train(variant, grids, seconds * variant.times)
        parameters = sum(parameter.numel() for parameter in network.parameters()) / 1e6
        cells = " | ".join(_judged(variant, network, grids))
        print(f"| {variant.name} | {parameters:.2f} | {seen} | {cells} |", flush=True)


def train(variant: Variant, grids: list[Prepared], seconds: float) -> tuple[nn.Module, int]:
    """The network after so many seconds, and the maps it saw."""
    torch.manual_seed(0)
    network = variant.network().to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    mean = deepcopy(network)
    adam = torch.optim.Adam if variant.papers else torch.optim.AdamW
    optimizer = adam(network.parameters(), lr=1e-3 if variant.papers else RATE)
    share, seen, started = 0.0, 0, time.perf_counter()
    batches = _batches(grids)
    bar = tqdm(total=100, desc=variant.name, leave=False)
    for step in count():
        share = (time.perf_counter() - started) / seconds
        if share >= 1:
            return mean.eval(), seen
        batch = next(batches)
        while variant.small_first and (share < 0.5) != (batch.grid.codes.shape[1] == min(COUNTS)):
            batch = next(batches)
        network.train()
        if not variant.papers:
            if share > FROZEN_FROM:
                freeze_norms(network)
            optimizer.param_groups[0]["lr"] = RATE * min(share / 0.1, (1 + math.cos(math.pi * share)) / 2)
        given, pressure = turned(batch.grid.features(batch.samples), batch.grid.pressure[batch.samples].float(), step % 8)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            logits, relative = network(variant.see(given), given.conditions).unbind(1)
        loss = variant.loss(logits, relative, given, pressure)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        _average(mean, network, 0.0 if variant.papers else min(DECAY, (step + 1) / (step + 10)))
        seen += len(pressure)
        bar.update(int(100 * share) - bar.n)
    raise AssertionError


@torch.no_grad()
def _average(mean: nn.Module, network: nn.Module, decay: float) -> None:
    for ours_, theirs in zip(mean.state_dict().values(), network.state_dict().values(), strict=True):
        if ours_.dtype.is_floating_point:
            ours_.lerp_(theirs, 1 - decay)


def _batches(grids: list[Prepared]) -> Iterator[Batch]:
    """Batches of one grid each, for ever."""
    for epoch in count():
        generator = torch.Generator().manual_seed(epoch)
        batches = []
        for grid in grids:
            members = grid.members("training")
            order = members[torch.randperm(len(members), generator=generator)]
            batches += [Batch(grid, samples) for samples in order.split(BATCH_PIXELS // grid.codes[0].numel())]
        yield from (batches[i] for i in torch.randperm(len(batches), generator=generator).tolist())


@torch.no_grad()
def _judged(variant: Variant, network: nn.Module, grids: list[Prepared]) -> list[str]:
    """Mean Dice on held-out maps of each size, on those with little contact, and the bias of the area on the others."""
    dice: dict[str, list[float]] = {str(size): [] for size in COUNTS} | {"little": []}
    areas = []
    for grid in grids:
        for samples in grid.members("validation").split(BATCH_PIXELS // grid.codes[0].numel()):
            given, references = grid.features(samples), (grid.pressure[samples] > 0).numpy()
            with torch.autocast("cpu", dtype=torch.bfloat16):
                masks = (network(variant.see(given), given.conditions)[:, 0] > 0).numpy()
            for mask, reference in zip(masks, references, strict=True):
                found = compare(reference, mask)
                little = reference.mean() < LITTLE
                dice["little" if little else str(len(mask))].append(found.dice)
                if not little:
                    areas.append(found.area_error)
    return [f"{np.mean(values):.4f}" for values in dice.values()] + [f"{np.mean(areas):+.2%}"]


if __name__ == "__main__":
    main()
