"""The kink of KCI that the chapter draws, and the figures made from it."""

import numpy as np
import pytest
import torch
from torch.testing import assert_close

from dexterity import robots
from dexterity.indices import Index
from dexterity_study.uvms.indices import kink, show


@pytest.fixture(scope="module")
def tip() -> torch.Tensor:
    return kink.tip()


def test_the_smallest_singular_values_meet_in_the_papers_range(tip):
    sigma = kink.singular_values(tip)
    assert_close(sigma[4], sigma[5], rtol=0, atol=1e-9)
    assert sigma[3] > 1.01 * sigma[4]
    assert tip[6:].abs().max() <= np.radians(15)


def slopes(q: torch.Tensor, joint: int, step: float = 1e-5) -> list[float]:
    """Slopes of KCI to the left and to the right of joint values."""
    kci = Index("kinematic_conditioning").bind(robots.uvms())
    unit = torch.eye(12, dtype=q.dtype)[joint] * step
    return [float((kci(q) - kci(q - unit)) / step), float((kci(q + unit) - kci(q)) / step)]


def test_the_slope_of_kci_jumps_at_the_kink_and_nowhere_near_by(tip):
    before, after = slopes(tip, kink.JOINTS[0])
    assert before > 0.05 > -0.05 > after
    beside = tip.clone()
    beside[kink.JOINTS[0]] -= 0.05
    before, after = slopes(beside, kink.JOINTS[0])
    assert_close(before, after, rtol=1e-3, atol=0)


def test_the_line_goes_through_the_kink(tip):
    angles, sigma = kink.line(tip, 40)
    assert len(angles) == 41
    assert_close(angles[20].deg2rad(), tip[kink.JOINTS[0]])
    assert (sigma[:, 4] - sigma[:, 5]).argmin() == 20
    assert angles.abs().max() <= kink.HALF_WIDTH_DEG + 1e-9


def test_the_sheets_are_the_singular_values_over_both_joints(tip):
    sheet = kink.sheet(tip, 5)
    q = tip.clone()
    q[list(kink.JOINTS)] = torch.stack([sheet.first_deg[1], sheet.second_deg[4]]).deg2rad()
    assert_close(sheet.sigma[1, 4], kink.singular_values(q))


def test_a_pair_of_joints_that_cannot_meet_is_refused(monkeypatch):
    monkeypatch.setattr(kink, "JOINTS", (0, 11))
    with pytest.raises(RuntimeError, match="apart"):
        kink.tip()


def test_figures_draw_kci_and_both_singular_values(tip):
    top, bottom = show.kink_line(tip).axes
    (kci,), (fifth, sixth) = top.get_lines(), bottom.get_lines()
    peak = int(np.argmax(kci.get_ydata()))
    assert fifth.get_ydata()[peak] == pytest.approx(sixth.get_ydata()[peak], abs=1e-9)
    (surface,) = show.kink_surface(tip).axes
    assert len(surface.collections) == 2
