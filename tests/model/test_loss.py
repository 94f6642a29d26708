import math

import pytest
import torch

from model.loss import combined_loss

MASKS = torch.tensor([[[1.0, 0.0], [0.0, 0.0]]])


def test_undecided_logits() -> None:
    """Every probability 1/2: BCE = ln 2, Dice = 2 (1/2) / (2 + 1) = 1/3."""
    logits = torch.zeros(1, 2, 2)
    assert combined_loss(logits, MASKS, alpha=1.0).item() == pytest.approx(math.log(2))
    assert combined_loss(logits, MASKS, alpha=0.0).item() == pytest.approx(2 / 3)
    assert combined_loss(logits, MASKS, alpha=0.25).item() == pytest.approx(0.25 * math.log(2) + 0.75 * 2 / 3)


def test_a_sure_and_right_answer_costs_nothing() -> None:
    assert combined_loss((MASKS - 0.5) * 80, MASKS, alpha=0.5).item() == pytest.approx(0, abs=1e-6)


def test_a_map_with_little_contact_weighs_as_much_as_one_with_much() -> None:
    masks = torch.zeros(2, 16, 16)
    masks[0, 0, 0] = 1
    masks[1, :, :12] = 1
    sure = (masks - 0.5) * 40
    miss_small, miss_large = sure.clone(), sure.clone()
    miss_small[0], miss_large[1] = -20, -20
    small, large = (combined_loss(logits, masks, alpha=0.0).item() for logits in (miss_small, miss_large))
    assert small == pytest.approx(large, rel=1e-3)
