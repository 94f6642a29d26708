"""The paper's U-Net (section 2.3, Fig. 2) and its loss: what ours is measured against."""

import torch
from torch import Tensor, nn
from torch.nn import functional

LEVELS = 4
MULTIPLE = 2**LEVELS
"""Rows and columns are padded to a multiple of this."""


def _double_convolution(inputs: int, outputs: int) -> nn.Sequential:
    """Two 3x3 convolutions, each with batch norm and ReLU (Eqs. 11, 12)."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, padding=1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
        nn.Conv2d(outputs, outputs, 3, padding=1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class UNet(nn.Module):
    """Contact logits from features.

    Args:
        channels: input channels.
        width: feature maps of the first stage, doubled at each of four poolings; the paper's is 64.
    """

    def __init__(self, channels: int, width: int) -> None:
        super().__init__()
        widths = [width * 2**level for level in range(LEVELS + 1)]
        self.contracting = nn.ModuleList(
            _double_convolution(inputs, outputs) for inputs, outputs in zip([channels, *widths], widths, strict=False)
        )
        self.upsampling = nn.ModuleList(
            nn.ConvTranspose2d(2 * outputs, outputs, 2, stride=2) for outputs in reversed(widths[:-1])
        )
        self.expanding = nn.ModuleList(_double_convolution(2 * outputs, outputs) for outputs in reversed(widths[:-1]))
        self.head = nn.Conv2d(width, 1, 1)

    def forward(self, features: Tensor) -> Tensor:
        """Features (batch, channels, rows, columns) to logits of contact (batch, rows, columns), any rows and columns."""
        rows, columns = features.shape[-2:]
        x = functional.pad(features, (0, -columns % MULTIPLE, 0, -rows % MULTIPLE), mode="replicate")
        skips: list[Tensor] = []
        for level, block in enumerate(self.contracting):
            x = block(functional.max_pool2d(x, 2) if level else x)
            skips.append(x)
        for upsample, block, skip in zip(self.upsampling, self.expanding, reversed(skips[:-1]), strict=True):
            x = block(torch.cat([upsample(x), skip], dim=1))
        logits: Tensor = self.head(x)[:, 0, :rows, :columns]
        return logits


def combined_loss(logits: Tensor, masks: Tensor, alpha: float = 0.5) -> Tensor:
    """alpha * BCE + (1 - alpha) * Dice loss (Eqs. 13-16), on logits and masks of shape (batch, rows, columns)."""
    cross_entropy = functional.binary_cross_entropy_with_logits(logits, masks)
    probability = torch.sigmoid(logits)
    overlap = (probability * masks).sum(dim=(1, 2))
    total = probability.sum(dim=(1, 2)) + masks.sum(dim=(1, 2))
    return alpha * cross_entropy + (1 - alpha) * (1 - (2 * overlap / total).mean())
