"""The loaded crane's shape: its last node is the tip, all constraints stay closed, energy is work."""

import pytest
import torch
from torch.testing import assert_close

from dexterity import crane
from dexterity.crane.shape import PARTS, bars, displacements, nodal_response
from dexterity.crane.structure import Assembly

PATU = crane.patu655()
WHOLE = Assembly.of(PATU)


def strokes(*batch: int) -> torch.Tensor:
    unit = torch.rand(*batch, 3, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    return unit * torch.tensor(PATU.upper, dtype=torch.float64)


def test_the_last_node_is_the_tip():
    s = strokes(40)
    found, tip = nodal_response(s), crane.load_response(s)
    assert_close(found.nodes[:, -1], crane.tip_position(s), rtol=0, atol=1e-13)
    assert_close(found.own_weight[:, -1, :2], tip.own_weight, rtol=1e-7, atol=1e-12)
    assert_close(found.per_kilogram[:, -1, :2], tip.per_kilogram, rtol=1e-7, atol=1e-14)


def test_displacements_keep_pins_rods_and_pads_closed_and_the_foot_in_its_place():
    pose = WHOLE.placed(strokes(20))
    moved = displacements(WHOLE, pose)
    gaps = WHOLE.constraint_rows(pose) @ moved
    assert_close(gaps, torch.zeros_like(gaps), rtol=0, atol=1e-12)
    assert moved[:, ~WHOLE.free].abs().max() == 0


def test_loads_do_the_work_that_is_stored():
    """The curvature of the judge's energy along the displacement, against the compliance."""
    pose = WHOLE.placed(strokes(20))
    moved = displacements(WHOLE, pose)
    compliance = WHOLE.compliance(pose).diagonal(dim1=-2, dim2=-1)
    for column in range(3):
        share = torch.zeros(20, dtype=torch.float64, requires_grad=True)
        energy = WHOLE.strain_energy(pose, share[:, None] * moved[..., column])
        (slope,) = torch.autograd.grad(energy.sum(), share, create_graph=True)
        (curvature,) = torch.autograd.grad(slope.sum(), share)
        assert_close(curvature, compliance[:, column], rtol=1e-9, atol=0)


def test_bars_hang_together_in_every_pose_and_under_every_load():
    drawn = bars(strokes(10))
    assert set(drawn.parts) == set(PARTS)
    assert drawn.ends.shape == (10, 27, 2, 2)
    lengths = (drawn.ends[..., 1, :] - drawn.ends[..., 0, :]).norm(dim=-1)
    assert lengths.min() > 0.01
    for ends in (drawn.ends, drawn.loaded(0.0), drawn.loaded(500.0, 10.0)):
        points = ends.flatten(1, 2)
        gaps = torch.cdist(points, points, compute_mode="donot_use_mm_for_euclid_dist")
        # Only the foot and the tip are the end of one bar; the extension slides through the jib.
        alone = ((gaps < 1e-12).sum(-1) == 1).sum(-1)
        assert alone.max() <= 5


def test_rods_keep_their_lengths():
    drawn = bars(strokes(30))
    rods = [i for i, part in enumerate(drawn.parts) if part in ("cylinders", "linkage")]
    assert len(rods) == 4
    along = (drawn.ends[:, rods, 1] - drawn.ends[:, rods, 0])[..., None, :]
    along = along / along.norm(dim=-1, keepdim=True)
    for moved in (drawn.own_weight, drawn.per_kilogram):
        stretch = along @ (moved[:, rods, 1] - moved[:, rods, 0])[..., None]
        assert_close(stretch, torch.zeros_like(stretch), rtol=0, atol=1e-12)


def test_magnified_or_not_it_is_affine_in_the_payload():
    drawn = bars([0.3, 0.2, 0.9])
    one, ten = drawn.loaded(300.0) - drawn.ends, drawn.loaded(300.0, 10.0) - drawn.ends
    assert_close(ten, 10 * one)
    assert_close(drawn.loaded([0.0, 500.0]).mean(0), drawn.loaded(250.0), rtol=0, atol=1e-13)
    with pytest.raises(ValueError, match="payload"):
        drawn.loaded(501.0)


def test_batches(batch_shape):
    s = strokes(*batch_shape)
    found, drawn = nodal_response(s), bars(s)
    assert found.own_weight.shape == found.per_kilogram.shape == (*batch_shape, 22, 3)
    assert found.nodes.shape == (*batch_shape, 22, 2)
    assert drawn.ends.shape == drawn.own_weight.shape == (*batch_shape, 27, 2, 2)
    with pytest.raises(ValueError, match="linkage"):
        bars([0.7, 0.0, 0.0])
