import dataclasses
from functools import partial

import numpy as np
import pytest
import sympy
import torch

from dexterity import robots, studies, symbolic
from dexterity.report.claims import Acceptance, Outcome, Verdict, ledger_faults, load_papers
from dexterity.report.provenance import ProbeMissed
from dexterity.report.runs import run_study
from dexterity.report.study import load_study
from dexterity.store import content_key
from dexterity.studies import STUDIES, __main__, catalogue
from dexterity.studies.uvms import cost, kinematics

PAPERS = load_papers()


@pytest.fixture(scope="module")
def runs():
    """Return a run of every study, by name, at the scale of tests."""
    return {name: run_study(name, load_study(name).CONFIGS["smoke"]) for name in STUDIES}


@pytest.fixture
def remembered(runs, monkeypatch):
    """Let the package remember these runs and no others."""
    monkeypatch.setattr(catalogue, "remember", runs.__getitem__)
    return runs


def test_the_studies_of_part_one_are_found():
    assert set(STUDIES) >= {"uvms.kinematics", "uvms.indices", "uvms.tasks", "uvms.cost"}
    assert list(STUDIES) == sorted(set(STUDIES))


@pytest.mark.parametrize("name", STUDIES)
class TestStudy:
    def test_it_has_a_frozen_config_of_primitives_for_each_scale(self, name):
        study = load_study(name)
        assert study.CONFIGS.keys() == {"smoke", "book", "full"}
        for config in study.CONFIGS.values():
            assert type(config) is study.Config
            content_key(config)
        for kind in (study.Config, study.Result):
            assert kind.__dataclass_params__.frozen

    def test_it_returns_valid_verdicts(self, name, runs):
        verdicts = load_study(name).verdicts(runs[name].result)
        assert isinstance(verdicts, tuple)
        for verdict in verdicts:
            assert type(verdict) is Verdict
            assert type(verdict.outcome) is Outcome
            assert verdict.sentence.strip()

    def test_it_judges_exactly_its_own_claims(self, name, runs):
        judged = [(v.paper, v.claim) for v in load_study(name).verdicts(runs[name].result)]
        own = [(paper.key, claim.id) for paper in PAPERS for claim in paper.claims if claim.study == name]
        assert sorted(judged) == sorted(own)

    def test_its_acceptance_figures_hold(self, name, runs):
        figures = load_study(name).acceptance(runs[name].result)
        assert [figure for figure in figures if not figure.holds] == []

    def test_it_gives_the_same_result_again(self, name, runs):
        again = run_study(name, runs[name].config)
        assert content_key(again.result) == content_key(runs[name].result)


def test_every_claim_has_a_study_or_is_open(remembered):
    assert ledger_faults(PAPERS, studies.verdicts_by_study()) == ()


def test_a_claim_whose_verdict_is_missing_fails(remembered):
    verdicts = studies.verdicts_by_study()
    missing = verdicts["uvms.kinematics"][0].claim
    verdicts["uvms.kinematics"] = verdicts["uvms.kinematics"][1:]
    (fault,) = ledger_faults(PAPERS, verdicts)
    assert missing in fault


def test_a_claim_marked_open_whose_study_exists_fails(remembered):
    (paper, *others) = PAPERS
    claims = [dataclasses.replace(c, open=c.open or c.study == "uvms.tasks") for c in paper.claims]
    faults = ledger_faults(
        [dataclasses.replace(paper, claims=tuple(claims)), *others], studies.verdicts_by_study()
    )
    assert len(faults) == sum(claim.study == "uvms.tasks" for claim in claims)
    assert all("marked open" in fault for fault in faults)


def test_all_verdicts_are_those_of_the_studies(remembered):
    assert set(studies.verdicts()) == {v for own in studies.verdicts_by_study().values() for v in own}


def test_check_passes_where_all_is_well(remembered, capsys):
    assert __main__.main(["check"]) == 0
    assert capsys.readouterr().out == "all is well\n"


def test_check_fails_on_a_figure_that_does_not_hold(remembered, monkeypatch, capsys):
    monkeypatch.setattr(__main__, "acceptances", lambda: {"x": (Acceptance("largest error", 2.0, 1.0),)})
    assert __main__.main(["check"]) == 1
    assert capsys.readouterr().out == "study x: largest error is 2, its limit is 1\n"


def test_check_fails_on_a_verdict_that_is_missing(remembered, monkeypatch, capsys):
    monkeypatch.setattr(__main__, "verdicts_by_study", lambda: dict.fromkeys(STUDIES, ()))
    assert __main__.main(["check"]) == 1
    assert "uvms.kinematics gives claim" in capsys.readouterr().out


def test_full_stores_all_studies_or_one(monkeypatch, tmp_path, capsys):
    written = []
    monkeypatch.setattr(__main__, "write_stored", lambda name: written.append(name) or tmp_path / name)
    assert __main__.main(["full", "uvms.tasks"]) == 0
    assert written == ["uvms.tasks"]
    assert __main__.main(["full"]) == 0
    assert written[1:] == list(STUDIES)
    with pytest.raises(SystemExit, match="2"):
        __main__.main(["full", "uvms.nothing"])


def test_probe_tries_every_stored_result_and_fails_if_one_is_missed(monkeypatch, capsys):
    def miss(name):
        if name == STUDIES[0]:
            raise ProbeMissed(f"{name} is off")

    monkeypatch.setattr(__main__, "load_stored", lambda name: name)
    monkeypatch.setattr(__main__, "check_stored", miss)
    assert __main__.main(["probe"]) == 1
    assert capsys.readouterr().out == f"{STUDIES[0]} is off\n"
    monkeypatch.setattr(__main__, "load_stored", lambda name: None)
    assert __main__.main(["probe"]) == 0


class TestCost:
    @pytest.fixture
    def result(self, runs):
        return runs["uvms.cost"].result

    def test_printed_networks_have_the_printed_numbers_of_neurons(self):
        (paper,) = (paper for paper in PAPERS if paper.key == "sotiropoulos2016")
        for config in cost.CONFIGS.values():
            w, kci = config.feed_forward_neurons
            assert w == paper.claim("feed-forward-w-neurons").value
            assert kci == paper.claim("feed-forward-kci-neurons").value
            assert config.radial_basis_neurons[0] == paper.claim("radial-basis-w-neurons").value
            (assumed,) = (entry for entry in paper.assumptions if entry.id == "neurons-behind-the-count")
            assert assumed.chosen == f"{config.radial_basis_neurons[1]}."

    def test_networks_have_an_input_for_each_joint_that_matters(self, result):
        for networks in (result.feed_forward, result.radial_basis):
            assert {name: network.inputs for name, network in networks.items()} == {"w": 7, "KCI": 11}

    def test_each_way_of_counting_saves_operations(self, result):
        for row in cost.table_4(result).values():
            assert row["written out"] >= row["terms shared"] >= row["reduced"] > 0

    def test_parts_of_the_appendix_add_up_in_each_of_our_ways(self, result):
        parts = cost.appendix_a(result)
        for way, root in (("written out", 0), ("terms shared", 1)):
            w = sum(parts[part][way] for part in ("Jacobian", "JJᵀ", "its determinant"))
            assert parts["w in all"][way] == w + root
            kci = parts["Jacobian"][way] + parts["singular values"][way]
            assert parts["KCI in all"][way] == kci

    def test_the_sum_that_gives_the_table_is_called_fitted(self, result):
        fitted = [v.claim for v in cost.verdicts(result) if v.outcome is Outcome.FITTED]
        assert fitted == ["w-operations-table"]

    def test_every_way_of_the_ladder_computes_the_same(self, result):
        for errors in result.way_errors.values():
            assert len(errors) == 8
            assert max(errors.values()) < 1e-12

    def test_smoke_takes_no_times_so_that_its_result_comes_again(self, result):
        assert result.ladder == {"w": (), "KCI": ()}

    def test_a_drawing_has_every_step_once_and_right_of_what_it_uses(self):
        symbols = symbolic.SymbolicChain.from_description(robots.describe("uvms"))
        derivation = symbolic.derive(symbols, cost.INDICES["w"])
        drawing = cost.draw(derivation)
        steps = derivation.squared_manipulability.steps
        assert len(drawing.places) == len(drawing.stages) == len(steps) + len(derivation.matters)
        assert len({tuple(place) for place in drawing.places}) == len(drawing.places)
        x = drawing.places[:, 0]
        assert all(x[used] < x[user] for used, user in drawing.arrows)

    @pytest.mark.parametrize("name", ["docking_arm", "uvms"])
    def test_the_jacobian_written_out_is_that_of_the_chain(self, name):
        chain = robots.build(robots.describe(name))
        q = torch.linspace(-1, 1, chain.joints, dtype=torch.float64)
        J = in_numbers(cost.written_out, name, q)
        np.testing.assert_allclose(J, chain.spatial_jacobian(q), rtol=0, atol=1e-14)

    def test_as_printed_its_columns_are_those_of_the_kinematics_chapter(self):
        q = torch.linspace(-1, 1, 12, dtype=torch.float64)
        J = in_numbers(partial(cost.written_out, home_in_adjoint=True), "uvms", q)
        printed = kinematics.equation_6_as_printed(robots.uvms(), q)
        np.testing.assert_allclose(J, printed, rtol=0, atol=1e-14)


def in_numbers(jacobian, name, q):
    """Evaluate a Jacobian in symbols, for a robot with its lengths as described."""
    chain = symbolic.SymbolicChain.from_description(robots.describe(name))
    lengths = {length: robots.describe(name).lengths[str(length)] for length in chain.lengths}
    joints = sympy.symbols(f"q1:{chain.joints + 1}", real=True)
    J = jacobian(chain).xreplace(lengths | dict(zip(joints, q.tolist(), strict=True)))
    return np.array(J.evalf(), dtype=float)
