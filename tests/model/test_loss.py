import math

import pytest
import torch

from model.loss import FEW_PIXELS, PRESSURE_WEIGHT, contact_loss

SURE = 40.0
KNOWN = torch.tensor([True, True])


def test_undecided_logits() -> None:
    """Every probability 1/2: the cross entropy is ln 2 a pixel; three quarters of the load are in the wrong place, twice."""
    pressure = torch.tensor([[[2.0, 0.0], [0.0, 0.0]]])
    expected = 4 * math.log(2) / (1 + FEW_PIXELS) + PRESSURE_WEIGHT * 2 * 0.75
    assert contact_loss(torch.zeros(1, 2, 2), torch.ones(1, 2, 2), pressure, KNOWN[:1]).item() == pytest.approx(expected)


def test_a_sure_and_right_answer_costs_nothing_in_any_unit() -> None:
    pressure = torch.rand(2, 8, 8) * (torch.rand(2, 8, 8) > 0.7)
    logits = torch.where(pressure > 0, SURE, -SURE)
    assert contact_loss(logits, 3 * pressure + 1e-9, 7 * pressure, KNOWN).item() == pytest.approx(0, abs=1e-5)


def test_a_map_with_little_contact_weighs_nearly_as_much_as_one_with_much() -> None:
    pressure = torch.zeros(2, 64, 64)
    pressure[0, :8, :8] = 1
    pressure[1, :, :48] = 1
    sure = torch.where(pressure > 0, SURE, -SURE)
    losses = []
    for missed in (0, 1):
        logits = sure.clone()
        logits[missed][pressure[missed] > 0] = -1.0
        losses.append(contact_loss(logits, pressure + 1e-9, pressure, KNOWN).item())
    assert 0.7 < losses[0] / losses[1] < 1.4


def test_load_in_the_wrong_place_costs() -> None:
    pressure = torch.zeros(1, 8, 8)
    pressure[0, 2, 2:4] = 1
    logits = torch.where(pressure > 0, SURE, -SURE)
    lopsided = pressure.clone()
    lopsided[0, 2, 2] = 3
    misplaced = (0.5 + 0.5) / 2
    assert contact_loss(logits, lopsided, pressure, KNOWN[:1]).item() == pytest.approx(PRESSURE_WEIGHT * misplaced, abs=1e-4)
    assert contact_loss(logits, lopsided, pressure, ~KNOWN[:1]).item() == pytest.approx(0, abs=1e-4)
