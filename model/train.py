"""Training of the U-Net on a data set: the paper's recipe (section 2.6), which stops and resumes at any epoch.

Read top to bottom: load the features, then epochs of training, validation and a checkpoint, until the validation loss no
longer falls.
"""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.optim.lr_scheduler import ReduceLROnPlateau
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn
from tqdm import tqdm

from model.dataset import read_pairs, read_samples
from model.errors import DatasetError
from model.features import CHANNELS, LOAD_CHANNEL, features
from model.loss import combined_loss
from model.mask import decide, doubt
from model.metrics import compare
from model.unet import UNet
from model.weights import save_weights
from solver.resistance import boyer_resistance

VALIDATION_EVERY = 10
"""Every tenth sample, hence surface seed, is held out for validation."""

LOWEST_LEARNING_RATE = 1e-4
PATIENCE_OF_RATE = 10
PATIENCE_OF_TRAINING = 20


@dataclass(frozen=True)
class TrainConfig:
    """Configuration of a training run, stored in its checkpoint.

    Attributes:
        data: directories of the data sets; all maps of one size.
        width: feature maps of the first stage; the paper's is 64.
        alpha: weight of the BCE against the Dice loss, Eq. 16.
        batch: maps a step.
        learning_rate: of Adam at the start; times 0.8 after 10 epochs without improvement.
        epochs: at most; training ends after 20 without improvement, or below a learning rate of 1e-4.
        averaging: decay of the running mean of the weights, which is what is validated and shipped.
        seed: of the initial weights, the order of the maps and their rotations.
        threads: of torch on the CPU.
    """

    data: tuple[str, ...]
    width: int = 16
    alpha: float = 0.5
    batch: int = 32
    learning_rate: float = 1e-3
    epochs: int = 100
    averaging: float = 0.998
    seed: int = 0
    threads: int = 2


@dataclass
class Progress:
    """Where a run stands; saved with every epoch."""

    epoch: int = 0
    lowest_loss: float = float("inf")
    lowest_epoch: int = 0
    history: list[dict[str, float]] = field(default_factory=list)
    stages: list[dict[str, Any]] = field(default_factory=list)

    def begin(self, data: tuple[str, ...]) -> bool:
        """Note which data the next epochs see; whether they are others than before, so that losses compare no longer."""
        if self.stages and self.stages[-1]["data"] == list(data):
            return False
        self.stages.append({"first_epoch": self.epoch + 1, "data": list(data)})
        self.lowest_loss = float("inf")
        return True


def train(directory: Path, config: TrainConfig) -> None:
    """Train, or go on with a run that was stopped.

    Args:
        directory: of the run: ``checkpoint.pt`` (everything, each epoch), ``history.jsonl`` and ``weights/`` (the best).
        config: ``epochs``, ``threads`` and ``data`` may change when the directory holds a checkpoint; other data begin a
            new stage.

    Raises:
        DatasetError: no data set, or maps of several sizes.
    """
    directory.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(config.threads)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    torch.manual_seed(config.seed)
    network = UNet(CHANNELS, config.width).to(device, memory_format=torch.channels_last)  # type: ignore[call-overload]
    averaged = AveragedModel(network, multi_avg_fn=get_ema_multi_avg_fn(config.averaging), use_buffers=True)
    optimizer = torch.optim.Adam(network.parameters(), lr=config.learning_rate)
    scheduler = ReduceLROnPlateau(optimizer, factor=0.8, patience=PATIENCE_OF_RATE)
    progress = Progress()

    checkpoint = directory / "checkpoint.pt"
    if checkpoint.exists():
        state = torch.load(checkpoint, map_location=device, weights_only=True)
        network.load_state_dict(state["network"])
        averaged.load_state_dict(state["averaged"])
        optimizer.load_state_dict(state["optimizer"])
        progress = Progress(**state["progress"])
        if not progress.begin(config.data):
            scheduler.load_state_dict(state["scheduler"])
    else:
        progress.begin(config.data)

    inputs, masks = _load(config.data)
    validation = torch.arange(len(inputs)) % VALIDATION_EVERY == 0
    training_order = torch.nonzero(~validation)[:, 0]

    while progress.epoch < config.epochs:
        progress.epoch += 1
        generator = torch.Generator().manual_seed(config.seed + progress.epoch)
        order = training_order[torch.randperm(len(training_order), generator=generator)]
        network.train()
        losses = []
        bar = tqdm(order.split(config.batch), desc=f"epoch {progress.epoch}", unit="batch")
        for batch in bar:
            x, y = turned(inputs[batch], masks[batch], generator)
            x = x.to(device, torch.float32).contiguous(memory_format=torch.channels_last)
            with torch.autocast(device.type, dtype=torch.bfloat16):
                logits = network(x)
            loss = combined_loss(logits.float(), y.to(device, torch.float32), config.alpha)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            averaged.update_parameters(network)
            losses.append(loss.item())
            bar.set_postfix(loss=f"{np.mean(losses[-100:]):.4f}")

        record, calibration = _validate(averaged.module, inputs[validation], masks[validation], config, device)
        scheduler.step(record["loss"])
        rate = optimizer.param_groups[0]["lr"]
        record |= {"epoch": progress.epoch, "training_loss": float(np.mean(losses)), "learning_rate": rate}
        progress.history.append(record)
        tqdm.write(json.dumps(record))
        with (directory / "history.jsonl").open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(record) + "\n")
        if record["loss"] < progress.lowest_loss:
            progress.lowest_loss, progress.lowest_epoch = record["loss"], progress.epoch
            description = _description(config, progress, inputs[:, LOAD_CHANNEL, 0, 0])
            save_weights(directory / "weights", averaged.module, description | {"calibration": calibration})
        _save(
            checkpoint,
            config=asdict(config),
            network=network.state_dict(),
            averaged=averaged.state_dict(),
            optimizer=optimizer.state_dict(),
            scheduler=scheduler.state_dict(),
            progress=asdict(progress),
        )
        if progress.epoch - progress.lowest_epoch >= PATIENCE_OF_TRAINING or rate < LOWEST_LEARNING_RATE:
            break


def _load(directories: tuple[str, ...]) -> tuple[Tensor, Tensor]:
    """Features (samples, CHANNELS, rows, columns) in float16 and masks (samples, rows, columns) of all data sets."""
    inputs, masks = [], []
    for directory in map(Path, directories):
        for problem, mask in tqdm(
            read_pairs(directory), total=len(read_samples(directory)), desc=f"features of {directory}"
        ):
            inputs.append(features(problem).half())
            masks.append(torch.from_numpy(mask))
    if len({mask.shape for mask in masks}) > 1:
        raise DatasetError(f"{', '.join(directories)} hold maps of several sizes; training takes one.")
    return torch.stack(inputs), torch.stack(masks)


def turned(inputs: Tensor, masks: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Each map of the batch flipped and rotated at random in one of the eight ways that leave a square a square."""
    turned_inputs, turned_masks = [], []
    for x, y, way in zip(inputs, masks, torch.randint(8, (len(inputs),), generator=generator).tolist(), strict=True):
        if way >= 4:
            x, y = x.flip(-1), y.flip(-1)
        turned_inputs.append(x.rot90(way % 4, (-2, -1)))
        turned_masks.append(y.rot90(way % 4, (-2, -1)))
    return torch.stack(turned_inputs), torch.stack(turned_masks)


@torch.no_grad()
def _validate(
    network: torch.nn.Module, inputs: Tensor, masks: Tensor, config: TrainConfig, device: torch.device
) -> tuple[dict[str, float], dict[str, float]]:
    """Mean loss and metrics on the held-out maps, and the calibration of the expected error on them."""
    network.eval()
    losses, comparisons, doubts, resistance_errors = [], [], [], []
    for x, y in zip(inputs.split(config.batch), masks.split(config.batch), strict=True):
        x = x.to(device, torch.float32).contiguous(memory_format=torch.channels_last)
        with torch.autocast(device.type, dtype=torch.bfloat16):
            logits = network(x)
        losses.append(combined_loss(logits.float(), y.to(device, torch.float32), config.alpha).item() * len(x))
        for probability, reference in zip(torch.sigmoid(logits.float()).cpu().numpy(), y.numpy(), strict=True):
            predicted = decide(probability)
            comparisons.append(compare(reference, predicted))
            doubts.append(doubt(probability, predicted))
            ratio = boyer_resistance(predicted, (1.0, 1.0), 1.0) / boyer_resistance(reference, (1.0, 1.0), 1.0)
            resistance_errors.append(abs(ratio - 1))
    record = {
        "loss": sum(losses) / len(inputs),
        "dice": float(np.mean([c.dice for c in comparisons])),
        "jaccard": float(np.mean([c.jaccard for c in comparisons])),
        "bf_score": float(np.mean([c.bf_score for c in comparisons])),
        "pixel_accuracy": float(np.mean([c.pixel_accuracy for c in comparisons])),
        "area_error": float(np.mean([abs(c.area_error) for c in comparisons])),
        "resistance_error": float(np.mean(resistance_errors)),
    }
    mean_doubt = float(np.mean(doubts))
    calibration = {
        "dice": (1 - record["dice"]) / mean_doubt,
        "contact_area": record["area_error"] / mean_doubt,
        "contact_resistance": record["resistance_error"] / mean_doubt,
    }
    return record, calibration


def _description(config: TrainConfig, progress: Progress, log_loads: Tensor) -> dict[str, Any]:
    """What the weights' manifest says of their training."""
    return {
        "training": asdict(config),
        "stages": progress.stages,
        "datasets": {
            directory: json.loads((Path(directory) / "dataset.json").read_text(encoding="utf-8"))
            for stage in progress.stages
            for directory in stage["data"]
        },
        "epochs": progress.epoch,
        "validation": progress.history[-1],
        "log_load_range": [log_loads.min().item(), log_loads.max().item()],
    }


def _save(path: Path, **state: Any) -> None:
    """Write a checkpoint so that a stop in the middle leaves the last one whole."""
    temporary = path.with_suffix(".tmp")
    torch.save(state, temporary)
    temporary.replace(path)
