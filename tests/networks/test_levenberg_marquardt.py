"""The trainer against its printed formula by autograd, and against other trainers."""

import logging
import math

import numpy as np
import pytest
import torch
from scipy.optimize import least_squares
from torch.testing import assert_close

import dexterity as dx
from dexterity import sampling
from dexterity.indices import Index
from dexterity.networks import levenberg_marquardt as trainer
from dexterity.networks import normal_equations, train
from dexterity.networks.feed_forward import FeedForward, target_of
from dexterity.networks.levenberg_marquardt import Options, Stop, levenberg_marquardt
from dexterity.networks.network import View

VIEW = View(4, [0, 1, 3])
READOUTS = ["identity", "reciprocal", "logarithm", "cone", "triple"]
RESTARTS = 7
# Stated before the trainers were compared.
NO_WORSE_THAN = 1.15


def rows(count=120, values=1, seed=0):
    """Return positive values that vary smoothly, without noise."""
    q = torch.from_numpy(np.random.default_rng(seed).uniform(-1, 1, (count, 4)))
    y = torch.stack([2 + torch.sin(q[:, 0] + i * q[:, 1]) * torch.cos(q[:, 3]) for i in range(values)], -1)
    return q, y[:, 0] if values == 1 else y


def network(q, y, readout="identity", neurons=3, seed=0, view=VIEW):
    return FeedForward.untrained(view, neurons, q, y, torch.Generator().manual_seed(seed), readout)


def flat(network):
    """All weights in one row, in the order of the network's parameters."""
    return torch.cat([p.detach().flatten() for p in network.parameters()])


def residuals_of(network, q, y):
    """Scaled residuals as a function of all weights in one row."""
    sizes = {name: p.shape for name, p in network.named_parameters()}
    target = target_of(y, network.readout)

    def residuals(weights):
        parts = weights.split([math.prod(shape) for shape in sizes.values()])
        named = {name: part.view(shape) for (name, shape), part in zip(sizes.items(), parts, strict=True)}
        values = torch.func.functional_call(network, named, (q,))
        return ((target_of(values, network.readout) - target) / network.target_half_range).flatten()

    return residuals


def jacobian_and_residuals(network, q, y):
    residuals = residuals_of(network, q, y)
    return torch.autograd.functional.jacobian(residuals, flat(network)), residuals(flat(network)).detach()


def stepped(network, q, y, damping):
    """Weights after one step that was taken, less those before."""
    training = levenberg_marquardt(
        network, q, y, Options(epochs=1, damping="factor", initial_damping=damping, largest_damping=1e30)
    )
    assert training.history[1] < training.history[0]
    return flat(training.network) - flat(network)


# ---- one step --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("readout", "values"), [*((readout, 1) for readout in READOUTS), ("identity", 3)])
def test_a_step_is_that_of_eq_20(readout, values):
    q, y = rows(values=values)
    # Ten neurons are more than are taken at a time for products of pairs.
    untrained = network(q, y, readout, neurons=10)
    if readout == "reciprocal":  # whose values must not change sign while autograd looks at their target
        untrained.output_weights.data *= 0.1
    J, e = jacobian_and_residuals(untrained, q, y)
    expected = -torch.linalg.solve(J.mT @ J + 10 * torch.eye(J.shape[1], dtype=J.dtype), J.mT @ e)
    assert_close(stepped(untrained, q, y, 10.0), expected, rtol=1e-9, atol=1e-12)


def test_little_damping_gives_the_step_of_gauss_and_newton():
    q, y = rows()
    near = network(q, y)
    y = near(q).detach()
    near.output_weights.data += 0.01
    near.hidden_biases.data -= 0.01
    J, e = jacobian_and_residuals(near, q, y)
    gauss_newton = -torch.linalg.lstsq(J, e[:, None], driver="gelsd").solution[:, 0]
    errors = [(stepped(near, q, y, mu) - gauss_newton).norm() / gauss_newton.norm() for mu in (1e-2, 1e-8)]
    assert errors[1] < 1e-3 < errors[0]


def test_much_damping_gives_a_short_step_down_the_gradient():
    q, y = rows()
    untrained = network(q, y)
    J, e = jacobian_and_residuals(untrained, q, y)
    assert_close(stepped(untrained, q, y, 1e12) * 1e12, -J.mT @ e, rtol=1e-4, atol=1e-3)


def test_at_the_tip_of_a_cone_the_step_is_finite():
    q, y = rows()
    at_the_tip = network(q, y, "cone")
    at_the_tip.output_weights.data[1:] = 0
    at_the_tip.output_biases.data[1:] = 0
    assert torch.isfinite(stepped(at_the_tip, q, y, 1.0)).all()


# ---- whole trainings -------------------------------------------------------------------------------


@pytest.mark.parametrize("readout", READOUTS)
@pytest.mark.parametrize("damping", ["gain_ratio", "factor"])
def test_errors_fall_and_are_those_of_the_network(readout, damping):
    q, y = rows(3000)
    training = levenberg_marquardt(network(q, y, readout, 5), q, y, Options(epochs=25, damping=damping))
    assert list(training.history) == sorted(training.history, reverse=True)
    assert training.history[-1] < 0.5 * training.history[0]
    assert len(training.history) == training.epochs + 1
    target = target_of(y, readout)[:, 0]
    error = (target_of(training.network(q).detach(), readout)[:, 0] - target).square().mean().item()
    assert training.mean_square_error == pytest.approx(error, rel=1e-9)
    assert training.mean_square_error == training.history[-1]


def test_a_network_is_found_again_from_its_values():
    q, y = rows(400)
    known = network(q, y, seed=1)
    starts = [network(q, known(q).detach(), seed=seed) for seed in range(10)]
    trainings = levenberg_marquardt(starts, q, known(q).detach(), Options(epochs=200, goal=1e-20))
    best = min(trainings, key=lambda training: training.mean_square_error)
    assert best.success
    assert_close(best.network(q), known(q), rtol=0, atol=1e-10)


@pytest.mark.parametrize(("readout", "values"), [("identity", 1), ("identity", 2), ("cone", 1)])
def test_together_is_as_alone(readout, values):
    q, y = rows(values=values)
    networks = [network(q, y, readout, 4, seed) for seed in range(5)]
    options = Options(epochs=12, goal=2e-3)
    together = levenberg_marquardt(networks, q, y, options)
    assert len({training.epochs for training in together}) > 1 or values > 1
    for one, training in zip(networks, together, strict=True):
        alone = levenberg_marquardt(one, q, y, options)
        assert (training.epochs, training.stop) == (alone.epochs, alone.stop)
        np.testing.assert_allclose(training.history, alone.history, rtol=1e-6)
        assert_close(training.network(q), alone.network(q), rtol=1e-5, atol=1e-6)


def test_each_network_may_have_rows_and_scaling_of_its_own():
    sets = [rows(seed=seed) for seed in range(3)]
    networks = [network(q, y, seed=5) for q, y in sets]
    q, y = (torch.stack(parts) for parts in zip(*sets, strict=True))
    for (own_q, own_y), one, training in zip(
        sets, networks, levenberg_marquardt(networks, q, y, Options(epochs=10)), strict=True
    ):
        alone = levenberg_marquardt(one, own_q, own_y, Options(epochs=10))
        np.testing.assert_allclose(training.history, alone.history, rtol=1e-8)


def test_pieces_of_rows_and_of_networks_change_nothing(monkeypatch):
    q, y = rows(2000)
    networks = [network(q, y, seed=seed) for seed in range(4)]
    whole = levenberg_marquardt(networks, q, y, Options(epochs=6))
    monkeypatch.setattr(normal_equations, "_numbers_at_once", lambda weights: 2**14)
    for one, other in zip(whole, levenberg_marquardt(networks, q, y, Options(epochs=6)), strict=True):
        np.testing.assert_allclose(one.history, other.history, rtol=1e-9)


def test_what_is_given_is_left_as_it_is():
    q, y = rows()
    untrained = network(q, y)
    before = flat(untrained).clone()
    training = levenberg_marquardt(untrained, q.clone().requires_grad_(False), y, Options(epochs=3))
    assert torch.equal(flat(untrained), before)
    assert not torch.equal(flat(training.network), before)
    assert all(p.requires_grad for p in training.network.parameters())


def test_rows_that_occur_twice_are_no_trouble():
    q, y = rows(30)
    twice, values = torch.cat([q, q]), torch.cat([y, y])
    alone, doubled = (
        levenberg_marquardt(network(q, y), *data, Options(epochs=8)) for data in ((q, y), (twice, values))
    )
    np.testing.assert_allclose(doubled.history[:3], alone.history[:3], rtol=1e-6)


# ---- why it ends -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "stop"),
    [
        (Options(goal=1e-3), Stop.GOAL),
        (Options(goal=1e9), Stop.GOAL),
        (Options(epochs=3), Stop.EPOCHS),
        (Options(epochs=500, smallest_gradient=1e-3), Stop.GRADIENT),
        (Options(epochs=500, smallest_gradient=0, smallest_step=1e-2), Stop.STEP),
        (Options(epochs=500, damping="factor", largest_damping=1e-2, initial_damping=1e-20), Stop.DAMPING),
    ],
    ids=str,
)
def test_why_it_ends(options, stop):
    q, y = rows(60)
    training = levenberg_marquardt(network(q, y, neurons=4, seed=1), q, y, options)
    assert training.stop is stop
    assert training.success is (stop is Stop.GOAL)
    assert training.epochs <= options.epochs
    if options.goal > 1:
        assert training.epochs == 0


def test_an_interrupt_returns_the_best_so_far(monkeypatch):
    q, y = rows()
    networks = [network(q, y, seed=seed) for seed in range(3)]
    step, calls = trainer._State.step, []

    def interrupted(state):
        calls.append(state)
        if len(calls) == 6:
            raise KeyboardInterrupt
        return step(state)

    monkeypatch.setattr(trainer._State, "step", interrupted)
    for one, training in zip(networks, levenberg_marquardt(networks, q, y), strict=True):
        assert training.stop is Stop.INTERRUPTED
        assert training.epochs == 5
        error = (training.network(q).detach() - y).square().mean().item()
        assert training.mean_square_error == pytest.approx(error, rel=1e-9)
        assert error < (one(q).detach() - y).square().mean().item()


# ---- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"damping": "none"}, "damping is 'none'"),
        ({"epochs": 0}, "epochs is 0"),
        ({"goal": -1.0}, "goal is -1.0"),
        ({"goal": math.nan}, "goal is nan"),
        ({"smallest_step": math.inf}, "smallest_step is inf"),
        ({"initial_damping": 0.0}, "initial_damping is 0.0"),
    ],
)
def test_options_out_of_range(change, message, annotations_unchecked):
    with pytest.raises(ValueError, match=message):
        Options(**change)


def test_bad_rows_and_networks():
    q, y = rows()
    one = network(q, y)
    bad = [
        ([], q, y, "empty sequence"),
        (one, q[:, :3], y, r"x has shape \(1, 120, 3\)"),
        (one, q[:0], y[:0], "no rows"),
        (one, q, y[1:], r"y has shape \(1, 119, 1\)"),
        (one, q, y[:, None], "y has shape"),
        (one, torch.where(q > 0.99, math.nan, q), y, "x is not finite|x .*finite"),
        (one, q, torch.full_like(y, math.inf), "finite"),
        ([one] * 3, torch.stack([q] * 2), torch.stack([y] * 2), "3, N, 4"),
        ([one, network(q, y, neurons=4)], q, y, "network 1 differs"),
        ([one, network(q, y, "logarithm")], q, y, "network 1 differs"),
        ([one, network(q, y, view=View(4, [0, 1, 2]))], q, y, "network 1 differs"),
        (network(q, y, "logarithm"), q, -y, "needs positive"),
    ]
    for networks, x, values, message in bad:
        with pytest.raises(ValueError, match=message):
            levenberg_marquardt(networks, x, values)


# ---- other trainers --------------------------------------------------------------------------------


def w_task():
    index = Index("manipulability").bind(dx.robots.uvms())
    data = sampling.data_sets(index, sampling.uvms_space("manipulability"), train=300, test=1, validation=1)
    view = View(12, range(4, 11))
    starts = [network(data.train.q, data.train.values, "identity", 8, seed, view) for seed in range(RESTARTS)]
    return data.train.q, data.train.values, starts


def by_scipy(start, q, y):
    """Let MINPACK find the weights, with Eqs. 13 to 16 and their derivatives written out."""
    x = ((start.view(q) - start.input_centre) / start.input_half_range).numpy()
    target = ((y - start.target_centre) / start.target_half_range).numpy()
    ends = np.cumsum([p.numel() for p in start.parameters()])[:-1]

    def layers(weights):
        hidden_weights, hidden_biases, output_weights, output_bias = np.split(weights, ends)
        hidden = np.tanh(x @ hidden_weights.reshape(-1, x.shape[1]).T + hidden_biases)
        return hidden, output_weights, output_bias

    def residuals(weights):
        hidden, output_weights, output_bias = layers(weights)
        return hidden @ output_weights + output_bias - target

    def jacobian(weights):
        hidden, output_weights, _ = layers(weights)
        into_hidden = output_weights * (1 - hidden**2)
        by_weights = (into_hidden[:, :, None] * x[:, None]).reshape(len(x), -1)
        return np.hstack([by_weights, into_hidden, hidden, np.ones((len(x), 1))])

    found = least_squares(residuals, flat(start).numpy(), jacobian, method="lm", max_nfev=80)
    return 2 * found.cost / len(y) * start.target_half_range.item() ** 2


class Answering(torch.nn.Module):
    """A network as torch-levenberg-marquardt takes it: without a look at whether its inputs are finite."""

    def __init__(self, start):
        super().__init__()
        self.start = levenberg_marquardt(start, torch.zeros(1, 12), [12.0], Options(goal=1e9)).network

    def forward(self, x):
        return self.start.answer(x)


def by_torch_levenberg_marquardt(start, q, y):
    # Brings all of Lightning along, which takes seconds: not for every process that collects tests.
    from torch_levenberg_marquardt.damping import StandardDampingStrategy
    from torch_levenberg_marquardt.training import LevenbergMarquardtModule

    module = LevenbergMarquardtModule(
        Answering(start), damping_strategy=StandardDampingStrategy(), solve_method="cholesky"
    )
    x = start.view(q)
    for _ in range(80):
        _, _, done, _ = module.training_step(x, y)
        if done:
            break
    return (module.model(x).detach() - y).square().mean().item()


def test_median_errors_are_those_of_other_trainers():
    logging.getLogger("torch_levenberg_marquardt").setLevel(logging.ERROR)
    q, y, starts = w_task()
    ours = levenberg_marquardt(starts, q, y, Options(epochs=80))
    median = np.median([training.mean_square_error for training in ours])
    for peer in (by_scipy, by_torch_levenberg_marquardt):
        other = np.median([peer(start, q, y) for start in starts])
        assert median <= NO_WORSE_THAN * other, peer.__name__


# ---- values that overflow, and gradients that nobody asked for: cases of the review, faults #13 and #23 ----


@pytest.mark.parametrize(
    ("size", "readout", "message"),
    [
        (1e308, "identity", "range overflows"),
        (1e200, "identity", "mean square error is not finite"),
        (1e-310, "reciprocal", "target for the readout 'reciprocal' overflows"),
        (1e-200, "reciprocal", "mean square error is not finite"),
    ],
)
def test_values_whose_errors_overflow_are_refused(size, readout, message):
    q = torch.linspace(-1, 1, 50, dtype=torch.float64)[:, None]
    values = size * (q[:, 0] if readout == "identity" else 1.5 + 0.5 * q[:, 0])
    with pytest.raises(ValueError, match=message):
        train.for_seeds(View(1, [0]), 3, q, values, [0], readout=readout)


def test_inputs_that_require_gradients_are_taken():
    q = torch.linspace(-1, 1, 50, dtype=torch.float64)[:, None]
    (start,) = train.initial_networks(View(1, [0]), 3, q, q.sin()[:, 0], [0])
    plain = levenberg_marquardt(start, q, q.sin()[:, 0])
    q.requires_grad_()
    tracked = levenberg_marquardt(start, q, q.sin()[:, 0])
    assert tracked.history == plain.history


def test_the_number_of_threads_changes_no_bit():
    """Faults #37: two threads gave other bits than one."""
    q = torch.linspace(-1, 1, 4001, dtype=torch.float64)[:, None].repeat(1, 3) ** torch.tensor([1, 2, 3])
    values = q.sin().sum(-1)
    (start,) = train.initial_networks(View(3, [0, 1, 2]), 9, q, values, [0])
    threads = torch.get_num_threads()
    histories = []
    for number in (1, 2):
        torch.set_num_threads(number)
        histories.append(levenberg_marquardt(start, q, values, Options(epochs=5)).history)
    torch.set_num_threads(threads)
    assert histories[0] == histories[1]


@pytest.mark.parametrize(
    "options", [{"epochs": math.inf}, {"epochs": 2.5}, {"goal": math.nan}, {"goal": "0"}]
)
@pytest.mark.usefixtures("annotations_unchecked")
def test_options_that_are_no_numbers_are_refused(options):
    with pytest.raises((TypeError, ValueError), match=f"^{next(iter(options))} is"):
        Options(**options)


def test_held_out_rows_end_a_training_and_choose_its_weights():
    random = torch.Generator().manual_seed(0)
    q = torch.linspace(-1, 1, 40, dtype=torch.float64)[:, None]
    noisy = (3 * q[:, 0]).sin() + 0.3 * torch.randn(40, generator=random, dtype=torch.float64)
    (network,) = train.initial_networks(View(1, [0]), 12, q[::2], noisy[::2], [0])
    held_out = sampling.DataSet(q[1::2], noisy[1::2])
    ended = levenberg_marquardt(network, q[::2], noisy[::2], Options(epochs=300, rises=4), held_out=held_out)
    on = levenberg_marquardt(network, q[::2], noisy[::2], Options(epochs=300))

    def error(of, q, values):
        return (of(q) - values).square().mean().item()

    assert ended.stop is Stop.RISES
    assert ended.epochs < 300
    assert error(ended.network, *vars(held_out).values()) < error(on.network, *vars(held_out).values())
    # The reported error is that of the network returned, and not that of the last step.
    assert ended.mean_square_error == pytest.approx(error(ended.network, q[::2], noisy[::2]))
    assert ended.mean_square_error > ended.history[-1]


def test_held_out_rows_have_the_joints_of_the_network():
    q = torch.linspace(-1, 1, 9, dtype=torch.float64)[:, None]
    (network,) = train.initial_networks(View(1, [0]), 2, q, q[:, 0], [0])
    with pytest.raises(ValueError, match=r"held_out\.q has shape"):
        levenberg_marquardt(network, q, q[:, 0], held_out=sampling.DataSet(q.repeat(1, 2), q[:, 0]))
