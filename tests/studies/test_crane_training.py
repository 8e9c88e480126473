"""Training and sizes of the crane's networks: that the study is sound, and what its verdicts go by."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from dexterity import crane
from dexterity.report.claims import Outcome
from dexterity.report.runs import run_study
from dexterity.studies.crane import training as study


@pytest.fixture(scope="module")
def result() -> study.Result:
    return run_study("crane.training", study.CONFIGS["smoke"]).result


def outcomes(result: study.Result) -> dict[str, Outcome]:
    return {verdict.claim: verdict.outcome for verdict in study.verdicts(result)}


def test_a_short_run_takes_no_times(result):
    assert result.descent.seconds == {}


# ---- training --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def data():
    whole = crane.training_set()
    return whole.rows[::37, :4], whole.deflection[::37]


def test_a_stack_is_its_networks_one_by_one(data):
    """Networks and gains that are trained side by side come out as each does alone, by plain torch."""
    x, y = data
    networks = [study._untrained(6, x, y, seed) for seed in (0, 1)]
    errors = study._back_propagation(networks, x, y, 0, np.array([0, 1, 5]), 0)
    assert errors.shape == (2, len(study._GAINS), 3)
    gain = study._GAINS[3]
    optimiser = torch.optim.SGD(networks[1].parameters(), lr=gain, momentum=study._MOMENTUM)
    for _ in range(5):
        optimiser.zero_grad()
        miss = (networks[1](x) - y) / networks[1].target_half_range
        (miss.square().sum(-1).mean() / 2).backward()
        optimiser.step()
    with torch.no_grad():
        alone = 1e3 * (networks[1](x) - y).square().sum(-1).mean().sqrt()
    assert errors[1, 3, -1] == pytest.approx(alone.item(), rel=1e-9)


def test_the_errors_of_both_ways_begin_as_one(result):
    for mode in study.MODES:
        starts = result.descent.first_order[mode][..., 0]
        np.testing.assert_allclose(starts, result.descent.second_order[:, :1].repeat(starts.shape[1], 1))


def test_what_diverges_is_infinite(data):
    x, y = data
    errors = study._back_propagation([study._untrained(6, x, y, 0)], x, y, 1, np.array([0, 40]), 0)
    assert not np.isnan(errors).any()
    assert np.isinf(errors[0, -1, -1])
    assert errors[0, 0, -1] < errors[0, 0, 0]


@pytest.mark.parametrize(
    ("better", "outcome"),
    [
        ((True, True), Outcome.REPRODUCED),
        ((True, False), Outcome.IN_SHAPE),
        ((False, False), Outcome.NOT_REPRODUCED),
    ],
)
def test_the_better_training_leaves_less_in_the_same_time(result, better, outcome):
    errors = {mode: np.full_like(own, 10.0) for mode, own in result.descent.first_order.items()}
    left = {(True, True): (5.0, 6.0), (True, False): (1.0, 11.0), (False, False): (11.0, 12.0)}[better]
    second = result.descent.second_order.copy()
    second[:, -1] = left
    changed = replace(result, descent=replace(result.descent, first_order=errors, second_order=second))
    assert outcomes(changed)["crane-lm-is-better"] is outcome


def test_times_decide_what_is_compared(result):
    passes, epochs = result.descent.passes[study.BATCH], result.descent.second_order.shape[1] - 1
    per_pass = {study.LEVENBERG_MARQUARDT: 1.0, study.BATCH: 1.0, study.SOME: 1e9, study.PATTERN: 1e9}
    timed = replace(result, descent=replace(result.descent, seconds=per_pass))
    times, errors = study.history(timed, study.LEVENBERG_MARQUARDT)
    assert times[-1] == epochs
    np.testing.assert_array_equal(errors, result.descent.second_order)
    at = study._at(timed, study.BATCH, float(epochs))
    told = result.descent.first_order[study.BATCH][..., np.searchsorted(passes, epochs)]
    np.testing.assert_array_equal(at, told[:, np.median(told, axis=0).argmin()])


# ---- sizes -----------------------------------------------------------------------------------------


def test_whole_poses_are_held_out():
    whole = crane.training_set()
    out = study._out(whole.rows[:, :4], 0.2, seed=0)
    assert out.double().mean().item() == pytest.approx(0.2, abs=0.002)
    inside, outside = ({tuple(row) for row in whole.strokes[rows].tolist()} for rows in (~out, out))
    assert not inside & outside
    assert not torch.equal(out, study._out(whole.rows[:, :4], 0.2, seed=1))


def test_the_first_fresh_set_is_the_thesis_test():
    config = study.CONFIGS["smoke"]
    fresh = study._fresh(config)
    points, payloads = len(crane.TEST_POINTS), len(crane.TEST_PAYLOADS)
    assert len(fresh.inputs) == (config.sets + 1) * points * payloads
    assert study._per_set(fresh) == config.sets + 1
    rigid = crane.tip_position(fresh.inputs[: points * payloads : payloads, :3])
    np.testing.assert_allclose(rigid, np.array(crane.TEST_POINTS), atol=1e-9)
    np.testing.assert_allclose(fresh.tip - fresh.deflection, crane.tip_position(fresh.inputs[:, :3]))
    assert (crane.within_limits(fresh.inputs[points * payloads :, :3])).all()


def test_choosing_by_luck_is_seen():
    """Of equal networks, the one that 25 points prefer is no better elsewhere, but looks so."""
    errors = np.random.default_rng(0).uniform(1, 2, size=(5, 4, 3_000))
    one, every = (study._lotteries(errors)[name] for name in (study.ONE, study.ALL))
    assert one.reported[1] < 0.85
    assert every.reported[1] < one.reported[1]
    assert one.regret == pytest.approx(1, abs=0.02)
    assert sum(one.counts) == 4 * 3_000
    assert sum(every.counts) == 3_000


def test_a_size_that_is_better_is_chosen():
    errors = np.ones((3, 2, 10)) * np.array([3.0, 1.0, 2.0])[:, None, None]
    choice = study._lotteries(errors)[study.ONE]
    assert choice.counts == (0, 20, 0)
    assert choice.reported == (1.0, 1.0, 1.0)


@pytest.mark.parametrize(
    ("ratio", "outcome"),
    [((1.0, 1.05), Outcome.REPRODUCED), ((1.0, 1.5), Outcome.IN_SHAPE), ((1.5, 1.5), Outcome.NOT_REPRODUCED)],
)
def test_the_thesis_sizes_are_judged_by_the_least_error(result, ratio, outcome):
    networks = {}
    for (name, own), beyond in zip(result.networks.items(), ratio, strict=True):
        test = np.full_like(own.test, 2.0)
        test[0] = 1.0
        test[study._nearest(result, name)] = beyond
        networks[name] = replace(own, test=test)
    assert outcomes(replace(result, networks=networks))["crane-size-by-test-error"] is outcome


@pytest.mark.parametrize(
    ("error", "outcome"),
    [(1.05, Outcome.REPRODUCED), (1.5, Outcome.IN_SHAPE), (3.0, Outcome.NOT_REPRODUCED)],
)
def test_the_rule_is_judged_by_held_out_poses(result, error, outcome):
    networks = {}
    for name, own in result.networks.items():
        held_out = np.full_like(own.held_out, 2.0)
        held_out[0] = 1.0
        networks[name] = replace(own, held_out=held_out, rule=np.full_like(own.rule, error))
    assert outcomes(replace(result, networks=networks))["crane-size-rule"] is outcome


def test_rules_are_evaluated_as_printed(result):
    assert study._size_rule(3670, 4, 2) == pytest.approx(3670 / 30)
    share = study._permitted(3670, 84, 14)
    assert study._size_bound(84, 14, share) == pytest.approx(3670)
    assert share > 1
    table = study.rule_table(result)
    assert [row["neurons of the thesis"] for row in table.values()] == [14, 18, 15, 15, 19]
    assert result.poses == result.rows / 10


def test_tables_have_a_row_for_each(result):
    assert list(study.equal_time_table(result)) == [study.LEVENBERG_MARQUARDT, *study.MODES]
    assert len(study.size_table(result, "direct")) == len(result.sizes) + 1
    assert len(study.choice_table(result)) == 2 * 4
    kept, summed = (study.memory_table(result)[name]["numbers"] for name in (
        "Levenberg–Marquardt, Jacobian kept", "Levenberg–Marquardt, sums alone"
    ))  # fmt: skip
    assert kept > 10 * summed
