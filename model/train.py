"""Training of the network on data sets, which stops and resumes at any checkpoint.

Read top to bottom: prepare the features, then steps over batches of one grid each, with a checkpoint and a validation every
so often, at a learning rate that rises at first and then falls to nothing.
"""

import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.optim.lr_scheduler import OneCycleLR
from torch.optim.swa_utils import AveragedModel
from tqdm import tqdm

from model.dataset import described
from model.domain import domain_of, statistics
from model.errors import DatasetError, DivergedError
from model.features import Features, network_input
from model.loss import contact_loss
from model.mask import decide
from model.metrics import compare
from model.network import ContactNet
from model.prepared import Prepared, prepare
from model.team import join
from model.weights import load_network, read_manifest, save_weights, version
from solver.resistance import boyer_resistance

BATCH_PIXELS = 32 * 128**2
"""Pixels a step and process; batches of small maps have more of them."""

FROZEN_FROM = 0.3
"""Share of the steps after which batch norms keep their statistics. Batches hold one size of map, and what is normal differs
between sizes, so the network has to learn with the statistics that it will be used with. Given weights keep theirs."""

LOOKED_AT = 5

VALIDATED = 200
"""Held-out maps of each grid that a validation looks at."""


@dataclass(frozen=True)
class TrainConfig:
    """Configuration of a training run, stored in its checkpoint.

    Attributes:
        data: directories of the data sets.
        epochs: times that every map is seen.
        learning_rate: of AdamW at its highest.
        averaging: decay of the running mean of the weights, which is what is validated and shipped.
        checkpoint_every: steps.
        seed: of the initial weights, the order of the maps and their rotations.
        start: directory of weights to start from; none to start anew.
    """

    data: tuple[str, ...]
    epochs: int = 8
    learning_rate: float = 2e-3
    averaging: float = 0.999
    checkpoint_every: int = 500
    seed: int = 0
    start: str | None = None


@dataclass(frozen=True)
class Batch:
    """Some samples of one grid."""

    grid: Prepared
    samples: Tensor


def train(directory: Path, config: TrainConfig, processes: int = 1) -> None:
    """Train, or go on with a run that was stopped.

    Args:
        directory: of the run: ``checkpoint.pt``, ``history.jsonl`` and ``weights/``.
        config: the same as before if the directory holds a checkpoint.
        processes: how many compute features, where they are missing; torch trains on all cores, on the GPU, or, under
            torchrun, on many.

    Raises:
        DatasetError: no data set, or a checkpoint of another configuration.
        DivergedError: the loss is not finite; the last checkpoint stays.
    """
    team = join()
    device = team.device
    directory.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(config.seed)
    network = (load_network(Path(config.start)) if config.start else ContactNet()).to(device)
    averaged = AveragedModel(network, avg_fn=_running_mean(config.averaging), use_buffers=True)
    mean: ContactNet = averaged.module  # type: ignore[assignment]
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.learning_rate)

    if not team.leads:
        team.wait()
    grids = prepare(map(Path, config.data), processes)
    if team.leads:
        team.wait()
    a_epoch = sum(1 for _ in _epoch(grids, team.size, config.seed, 0))
    steps = config.epochs * a_epoch
    scheduler = OneCycleLR(optimizer, config.learning_rate, total_steps=steps, pct_start=0.1)
    step = 0
    checkpoint = directory / "checkpoint.pt"
    if checkpoint.exists():
        state = torch.load(checkpoint, map_location=device, weights_only=True)
        if state["config"] != json.loads(json.dumps(asdict(config))):
            raise DatasetError(f"{checkpoint} is of another configuration, {state['config']}; choose another directory.")
        network.load_state_dict(state["network"])
        averaged.load_state_dict(state["averaged"])
        optimizer.load_state_dict(state["optimizer"])
        scheduler.load_state_dict(state["scheduler"])
        step = state["step"]

    domain = trained_domain(grids)
    together = team.together(network)
    losses: list[float] = []
    bar = tqdm(total=steps, initial=step, unit="step", disable=not team.leads)
    while step < steps:
        batches = list(_epoch(grids, team.size, config.seed, step // a_epoch))[step % a_epoch :]
        for batch in batches:
            generator = torch.Generator().manual_seed(config.seed * steps + step)
            network.train()
            if config.start or step >= FROZEN_FROM * steps:
                freeze_norms(network)
            losses.append(_step(together, optimizer, Batch(batch.grid, team.share(batch.samples)), generator, device))
            if not np.isfinite(losses[-1]):
                raise DivergedError(
                    f"The loss of step {step + 1} is not finite; train in another directory with a learning rate below "
                    f"{config.learning_rate:g}."
                )
            scheduler.step()
            averaged.update_parameters(network)
            step += 1
            bar.update()
            bar.set_postfix(loss=f"{np.mean(losses[-100:]):.4f}")
            if team.leads and (step % config.checkpoint_every == 0 or step == steps):
                found = validate(mean, grids, device)
                record = {"step": step, "loss": float(np.mean(losses)), "validation": found}
                losses = []
                tqdm.write(json.dumps(record), file=sys.stderr)
                with (directory / "history.jsonl").open("a", encoding="utf-8") as lines:
                    lines.write(json.dumps(record) + "\n")
                description = _description(config, record) | {"domain": domain}
                save_weights(directory / "weights", mean, description)
                _save(
                    checkpoint,
                    config=json.loads(json.dumps(asdict(config))),
                    network=network.state_dict(),
                    averaged=averaged.state_dict(),
                    optimizer=optimizer.state_dict(),
                    scheduler=scheduler.state_dict(),
                    step=step,
                )


def _running_mean(decay: float) -> Callable[[Tensor, Tensor, Tensor | int], Tensor]:
    """A running mean that forgets faster at the start, when the weights are still random."""

    def update(mean: Tensor, current: Tensor, count: Tensor | int) -> Tensor:
        return mean + (1 - min(decay, (int(count) + 1) / (int(count) + 10))) * (current - mean)

    return update


def _epoch(grids: list[Prepared], team_size: int, seed: int, epoch: int) -> Iterator[Batch]:
    """All training maps once, in batches of one grid each, in an order of the epoch's own."""
    generator = torch.Generator().manual_seed(seed + 7919 * epoch)
    batches = []
    for grid in grids:
        members = grid.members("training")
        order = members[torch.randperm(len(members), generator=generator)]
        size = team_size * max(1, BATCH_PIXELS // grid.codes[0].numel())
        batches += [Batch(grid, samples) for samples in order.split(size) if len(samples) >= max(2, team_size)]
    yield from (batches[i] for i in torch.randperm(len(batches), generator=generator).tolist())


def _step(
    network: torch.nn.Module,
    optimizer: torch.optim.Optimizer,
    batch: Batch,
    generator: torch.Generator,
    device: torch.device,
) -> float:
    given = batch.grid.features(batch.samples)
    pressure = batch.grid.pressure[batch.samples].float()
    given, pressure = turned(given, pressure, int(torch.randint(8, (1,), generator=generator)))
    fields = network_input(given).to(device)
    with torch.autocast(device.type, dtype=torch.bfloat16):
        said = network(fields, given.conditions.to(device))
    logits, relative = said.unbind(1)
    loss = contact_loss(logits, relative, pressure.to(device), batch.grid.known[batch.samples].to(device))
    optimizer.zero_grad()
    loss.backward()
    torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
    optimizer.step()
    return float(loss.item())


def freeze_norms(network: torch.nn.Module) -> None:
    """Have batch norms keep their statistics."""
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.eval()


def turned(given: Features, pressure: Tensor, way: int) -> tuple[Features, Tensor]:
    """Flipped and rotated in one of the eight ways that leave a square a square."""

    def turn(fields: Tensor) -> Tensor:
        return (fields.flip(-1) if way >= 4 else fields).rot90(way % 4, (-2, -1))

    sign = torch.tensor([1.0, -1.0 if way % 2 else 1.0])
    return Features(turn(given.heights), turn(given.coarse), given.conditions * sign), turn(pressure)


@torch.no_grad()
def validate(network: ContactNet, grids: list[Prepared], device: torch.device) -> dict[str, dict[str, float]]:
    """Errors on held-out maps, by grid."""
    network.eval()
    found: dict[str, dict[str, float]] = {}
    for grid in grids:
        lost, areas, resistances = [], [], []
        for samples in grid.members("validation")[:VALIDATED].split(max(1, BATCH_PIXELS // grid.codes[0].numel())):
            given = grid.features(samples)
            with torch.autocast(device.type, dtype=torch.bfloat16):
                logits = network(network_input(given).to(device), given.conditions.to(device))[:, 0]
            probabilities, references = torch.sigmoid(logits).cpu().numpy(), (grid.pressure[samples] > 0).numpy()
            for probability, reference in zip(probabilities, references, strict=True):
                mask = decide(probability)
                comparison = compare(reference, mask)
                ratio = boyer_resistance(mask, (1.0, 1.0), 1.0) / boyer_resistance(reference, (1.0, 1.0), 1.0)
                lost.append(1 - comparison.dice)
                areas.append(comparison.area_error)
                resistances.append(abs(ratio - 1))
        if areas:
            found[f"{grid.codes.shape[1]} x {grid.codes.shape[2]}"] = {
                "dice": 1 - float(np.mean(lost)),
                "dice_5th_percentile": 1 - float(np.percentile(lost, 95)),
                "area_error": float(np.mean(np.abs(areas))),
                "area_bias": float(np.mean(areas)),
                "resistance_error": float(np.mean(resistances)),
            }
    return found


def trained_domain(grids: list[Prepared]) -> dict[str, list[float]]:
    """What the statistics of the training maps range over, by every LOOKED_AT-th of them."""
    parts = []
    for grid in grids:
        members = grid.members("training")[::LOOKED_AT]
        parts += [statistics(grid.features(some)) for some in members.split(max(1, BATCH_PIXELS // grid.codes[0].numel()))]
    return domain_of(torch.cat(parts))


def _description(config: TrainConfig, record: dict[str, Any]) -> dict[str, Any]:
    """What the weights' manifest says of their training, and of that of the weights that it started from."""
    before = read_manifest(Path(config.start)) if config.start else {"training": [], "datasets": {}}
    start = version(before) if config.start else None
    return {
        "training": [*before["training"], asdict(config) | {"step": record["step"], "start": start}],
        "datasets": before["datasets"] | {directory: described(Path(directory)) for directory in config.data},
        "validation": record["validation"],
    }


def _save(path: Path, **state: Any) -> None:
    """Write a checkpoint so that a stop in the middle leaves the last one whole."""
    temporary = path.with_suffix(".tmp")
    torch.save(state, temporary)
    temporary.replace(path)
