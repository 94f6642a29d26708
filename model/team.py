"""Training by several processes, one for each GPU, on one machine or many, as torchrun starts them."""

import os
from dataclasses import dataclass

import torch
from torch import Tensor, distributed, nn
from torch.nn.parallel import DistributedDataParallel


@dataclass(frozen=True)
class Team:
    """The processes that train together.

    Attributes:
        rank: of this process.
        size: number of processes.
        device: that this process computes on.
    """

    rank: int
    size: int
    device: torch.device

    @property
    def leads(self) -> bool:
        """Whether this process writes the files."""
        return self.rank == 0

    def share(self, samples: Tensor) -> Tensor:
        """What this process computes of a batch."""
        return samples[self.rank :: self.size]

    def together(self, network: nn.Module) -> nn.Module:
        """The network with gradients that are means over all processes."""
        return network if self.size == 1 else DistributedDataParallel(network)

    def wait(self) -> None:
        """Until all processes are here."""
        if self.size > 1:
            distributed.barrier()


def join() -> Team:
    """The team that torchrun started this process in; a team of one without it."""
    size, rank = int(os.environ.get("WORLD_SIZE", "1")), int(os.environ.get("RANK", "0"))
    device = torch.device("cpu")
    if torch.cuda.is_available():
        device = torch.device("cuda", int(os.environ.get("LOCAL_RANK", "0")))
        torch.cuda.set_device(device)
    if size > 1 and not distributed.is_initialized():
        distributed.init_process_group("gloo" if device.type == "cpu" else "nccl")
    return Team(rank, size, device)
