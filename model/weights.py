"""Weights on disk: a safetensors file and the manifest that names its hash, its network and how it was made."""

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import torch
from safetensors.torch import load, save

from model.errors import WeightsError
from model.features import CHANNELS
from model.unet import UNet

SHIPPED = Path(__file__).parent / "weights"


@dataclass(frozen=True)
class Weights:
    """A network ready to predict.

    Attributes:
        network: the U-Net in evaluation mode.
        version: its name and the start of its hash.
        manifest: everything said of it: training, data, validation, calibration.
    """

    network: UNet
    version: str
    manifest: dict[str, Any]


def save_weights(directory: Path, network: torch.nn.Module, description: dict[str, Any]) -> None:
    """Write the weights and their manifest.

    Args:
        directory: gets ``unet.safetensors`` and ``manifest.json``.
        network: a U-Net.
        description: what the manifest says besides hash and architecture.
    """
    directory.mkdir(parents=True, exist_ok=True)
    data = save({name: tensor.contiguous().cpu() for name, tensor in network.state_dict().items()})
    (directory / "unet.safetensors").write_bytes(data)
    width = network.head.in_channels  # type: ignore[union-attr]
    manifest = {"architecture": "unet", "width": width, "sha256": sha256(data).hexdigest()} | description
    write_manifest(directory, manifest)


def write_manifest(directory: Path, manifest: dict[str, Any]) -> None:
    """Write ``manifest.json``."""
    (directory / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")


def load_weights(directory: Path = SHIPPED) -> Weights:
    """Load weights by the hash that their manifest promises.

    Raises:
        WeightsError: a file is missing or its hash differs.
    """
    try:
        manifest = json.loads((directory / "manifest.json").read_text(encoding="utf-8"))
        data = (directory / "unet.safetensors").read_bytes()
    except FileNotFoundError as error:
        raise WeightsError(f"{error.filename} is missing; train weights with `asperity train`.") from error
    found = sha256(data).hexdigest()
    if found != manifest["sha256"]:
        raise WeightsError(
            f"The weights in {directory} have the hash {found[:12]}, not {manifest['sha256'][:12]} as their manifest says; "
            "restore the file."
        )
    network = UNet(CHANNELS, manifest["width"])
    network.load_state_dict(load(data))
    network.eval()
    version = f"{manifest['architecture']}{manifest['width']}-{found[:8]}"
    return Weights(network, version, manifest)
