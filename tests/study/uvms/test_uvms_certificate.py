"""The chapter on proved bounds: reduced runs, and the stored certificate checked again in part."""

import shutil

import numpy as np
import pytest
import torch

from dexterity import networks, robots, sampling
from dexterity.codegen.taylor_models import TaylorModels
from dexterity.networks.certificate import recheck, relative_error
from dexterity.networks.certificate_check import is_bounded
from dexterity_study.engine.evidence import Evidence
from dexterity_study.uvms.certificate import experiment, show

pytestmark = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="there is no C compiler"
)


@pytest.fixture(scope="module")
def stored() -> Evidence:
    return Evidence("uvms.certificate")


def test_the_bound_of_the_network_is_what_was_asked_for(stored: Evidence) -> None:
    rows = stored["proofs"].where().set_index(["approximation", "factor"])
    assert rows["complete"].all()
    assert (rows["found"] <= rows["bound"] * (1 + 1e-9)).all()
    assert (rows["bound"] <= rows["wanted"]).all()
    assert rows.loc[("network", 1.01), "bound"] <= 0.0026
    assert rows.loc["network", "seconds"].max() < 3600


@pytest.mark.parametrize("name", ["network", "cubic"])
def test_the_stored_tree_is_the_one_of_the_digest_and_tiles_the_box(stored: Evidence, name: str) -> None:
    one, rows = show.certificate(stored, name), stored["proofs"].where(approximation=name)
    closest = rows.sort_values("factor").iloc[0]
    assert one.complete
    assert one.digest == closest["digest"]
    assert one.bound == pytest.approx(closest["bound"], rel=1e-9)
    lower, upper, _ = one.parts
    np.testing.assert_allclose((upper - lower).prod(1).sum(), (one.upper - one.lower).prod())


def test_parts_of_the_stored_certificate_are_proved_again(stored: Evidence) -> None:
    one, network = show.certificate(stored, "network"), networks.load_shipped(experiment.NETWORK)
    lower, upper, depths = one.parts
    tight = np.argsort(one.bounds[one.tree >= 254])[-3:]
    drawn = np.random.default_rng(0).choice(len(lower), 5, replace=False)
    of = (network, robots.uvms(), network.card.index(), experiment.box_of_network())
    assert recheck(one, *of, parts=[*tight.tolist(), *drawn.tolist()])
    smallest = int(np.argmax(depths))
    assert is_bounded(relative_error(*of), lower[smallest], upper[smallest], one.wanted, degree=4)


def test_a_thousand_parts_were_proved_again(stored: Evidence) -> None:
    rows = stored["checked"].where()
    assert rows["tried"].sum() >= 1000
    assert (rows["confirmed"] == rows["tried"]).all()
    assert rows["compiled_again"].all()
    assert rows["digest"].nunique() == 1


def test_bounds_for_kci_enclose_what_is_sampled() -> None:
    network = networks.load_shipped(experiment.OF_KCI)
    sides = [TaylorModels(side, 2, experiment.PARAMETERS) for side in experiment.sides_of_error(network)]
    exact, half_width = network.card.index().bind(robots.uvms()), 0.002
    random = torch.Generator().manual_seed(0)
    for centre in sampling.uniform(network.card.space(), 3, random):
        given = experiment.axes(network, centre)
        bound = max(experiment.bound_on(side, centre, half_width, given) for side in sides)
        offsets = half_width * (2 * torch.rand(200, sides[0].inputs, generator=random).double() - 1)
        q = centre.repeat(200, 1)
        q[:, : sides[0].inputs] += offsets
        with torch.no_grad():
            error = float((network(q) / exact(q) - 1).abs().max())
        assert error <= bound <= error + 0.002


def test_double_precision_adds_next_to_nothing(stored: Evidence) -> None:
    network, box = networks.load_shipped(experiment.NETWORK), experiment.box_of_network()
    row = stored["evaluation"].where().iloc[0]
    w = network.card.index().bind(robots.uvms())
    assert 0 < row["least_w"] <= float(w(sampling.sobol(box, 500, 0)).min())
    assert 0 < row["rounding"] < 1e-11
