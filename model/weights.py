"""Weights on disk: a safetensors file and the manifest that names its hash, its network and how it was made."""

import json
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from safetensors.torch import load, save

from model.errors import WeightsError
from model.methods import Ways, restored
from model.network import ContactNet

NAME = "contactnet"
MEASURED = "methods.json"
"""File beside the weights with what ``asperity evaluate`` measured."""

SHIPPED = Path(__file__).parent / "weights"


@dataclass(frozen=True)
class Weights:
    """A network ready to predict.

    Attributes:
        network: ready to evaluate.
        version: its name and the start of its hash.
        manifest: everything said of it: training, data, validation, domain.
        ways: to answer with it, as ``asperity evaluate`` measured them with these weights; None before that.
    """

    network: ContactNet
    version: str
    manifest: dict[str, Any]
    ways: Ways | None = None


def save_weights(directory: Path, network: ContactNet, description: dict[str, Any]) -> None:
    """Write the weights and their manifest.

    Args:
        directory: gets ``network.safetensors`` and ``manifest.json``.
        network: as it is trained.
        description: what the manifest says besides hash and architecture.
    """
    directory.mkdir(parents=True, exist_ok=True)
    data = save({name: tensor.contiguous().cpu() for name, tensor in network.state_dict().items()})
    (directory / "network.safetensors").write_bytes(data)
    manifest = {"sha256": sha256(data).hexdigest()} | description
    (directory / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")


def load_weights(directory: Path = SHIPPED) -> Weights:
    """Load weights by the hash that their manifest promises, ready to evaluate.

    Raises:
        WeightsError: a file is missing or its hash differs.
    """
    network = load_network(directory)
    manifest = read_manifest(directory)
    table = directory / MEASURED
    ways = restored(table.read_text(encoding="utf-8"), manifest["sha256"]) if table.exists() else None
    return Weights(network.fuse(), version(manifest), manifest, ways)


def load_network(directory: Path) -> ContactNet:
    """Load weights by their hash, to train on.

    Raises:
        WeightsError: a file is missing or its hash differs.
    """
    manifest = read_manifest(directory)
    try:
        data = (directory / "network.safetensors").read_bytes()
    except FileNotFoundError as error:
        raise WeightsError(f"{error.filename} is missing; train weights with `asperity train`.") from error
    found = sha256(data).hexdigest()
    if found != manifest["sha256"]:
        raise WeightsError(
            f"The weights in {directory} have the hash {found[:12]}, not {manifest['sha256'][:12]} as their manifest says; "
            "restore the file."
        )
    network = ContactNet()
    network.load_state_dict(load(data))
    return network


def version(manifest: dict[str, Any]) -> str:
    """Name and start of the hash of weights."""
    return f"{NAME}-{manifest['sha256'][:8]}"


def read_manifest(directory: Path) -> dict[str, Any]:
    """What is said of weights.

    Raises:
        WeightsError: there are none.
    """
    try:
        manifest: dict[str, Any] = json.loads((directory / "manifest.json").read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise WeightsError(f"{error.filename} is missing; train weights with `asperity train`.") from error
    return manifest
