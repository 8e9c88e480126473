"""Samples of what draws, searches, learns: sampling, search, networks."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
from good_values import (
    FEW,
    PAIR,
    SPACE,
    SQUARE,
    Arguments,
    both,
    data_set,
    draws,
    feed_forward,
    folder,
    hill,
    of,
    planar,
    problem,
    puma,
    radial_basis,
    small_data,
    w,
)

import dexterity as dx
from dexterity import networks, sampling, search
from dexterity.networks import (
    baselines,
    design,
    domain,
    export,
    growth,
    ladder,
    levenberg_marquardt,
    normal_equations,
)


@cache
def guarded() -> domain.Guarded:
    return domain.Guarded(feed_forward(), SQUARE)


@cache
def planar_index() -> dx.Index:
    return dx.Index("manipulability", "geometric", rows=[0, 1])


SHIPPED = "uvms-manipulability-feed-forward"
TINY = ladder.Effort(
    sizes=(2,), readouts=("identity",), rows=32, epochs=2, restarts=1, validation=16, search=FEW
)


@cache
def learned() -> networks.Learned:
    return networks.for_index(planar(), planar_index(), goal=0.5, name="small", effort=TINY, points=100)


def shipped() -> networks.Network:
    return networks.load_shipped(SHIPPED)


@cache
def saved() -> str:
    path = folder() / "small.npz"
    learned().save(path)
    return str(path)


@cache
def layout() -> normal_equations.Layout:
    return normal_equations.Layout.of(feed_forward())


@cache
def weights() -> torch.Tensor:
    return layout().pack([feed_forward()])


@cache
def sector() -> sampling.TaskSector:
    rest = sampling.Box([-0.5] * 2, [0.5] * 2, 3)
    return sampling.TaskSector((0.0, 1.35, 0.0), (0.0, 0.2, 0.1), 0.5, 1.0, 0.3, 0.3, rest)


def arrays_of(network: networks.Network) -> dict[str, np.ndarray]:
    return {name: array.numpy() for name, array in network.state_dict().items() if "view" not in name}


def learns(**more: object) -> Arguments:
    """Arguments of what compares a function with an index over a space."""
    return of(f=lambda: feed_forward(), index=lambda: hill, space=SQUARE, **more)


SAMPLES: dict[str, Arguments] = {
    # ---- sampling ----
    "sampling.Box": of(lower=-np.ones(3), upper=np.ones(3), levels=3),
    "sampling.Box.from_chain": of(chain=planar, levels=3),
    "sampling.Box.around": of(chain=planar, q=np.zeros(2), half_range=0.1, joints=(0, 1)),
    "sampling.Box.from_unit": of(self=SQUARE, u=0.5 + PAIR),
    "sampling.Box.to_unit": of(self=SQUARE, q=PAIR),
    "sampling.Box.contains": of(self=SQUARE, q=PAIR),
    "sampling.TaskSector": of(
        task_point=(0.0, 1.35, 0.0),
        base_offset=(0.0, 0.0, 0.0),
        r_min=0.5,
        r_max=1.0,
        azimuth=0.3,
        elevation=0.3,
        rest=lambda: sector().rest,
        turned=False,
    ),
    "sampling.TaskSector.from_unit": of(self=sector, u=lambda: np.full(sector().dimensions, 0.4)),
    "sampling.TaskSector.to_unit": of(
        self=sector, q=lambda: sector().from_unit(np.full(sector().dimensions, 0.4)).numpy()
    ),
    "sampling.TaskSector.contains": of(
        self=sector, q=lambda: sector().from_unit(np.full(sector().dimensions, 0.4)).numpy()
    ),
    "sampling.DataSet": of(q=PAIR, values=PAIR[0]),
    "sampling.DataSet.of": of(f=lambda: hill, q=lambda: torch.tensor(PAIR), name="f"),
    "sampling.data_sets": of(
        f=lambda: hill, space=SPACE, train=3, test=2, validation=2, seed=0, method="uniform"
    ),
    "sampling.grid": of(space=SPACE, start=0, stop=5),
    "sampling.grid_size": of(space=SPACE),
    "sampling.on_grid": of(space=SPACE, count=4, random=draws),
    "sampling.relevant_joints": of(chain=puma, index=w),
    "sampling.sobol": of(space=SPACE, count=4, seed=0, overhang=0.0),
    "sampling.uniform": of(space=SPACE, count=4, random=draws),
    "sampling.uvms_space": of(
        index_name="manipulability",
        half_range_deg=15.0,
        step_deg=5.0,
        task_point=(0.0, 1.35, 0.0),
        turned=False,
    ),
    # ---- search ----
    "search.GeneticOptions": of(population=4, generations=3, crossover=0.1, mutation=0.1, patience=3),
    "search.ZoomOptions": of(starts=2, levels=3, shrink=0.5, stages=3),
    "search.extremes": of(f=lambda: hill, space=SQUARE, samples=8, starts=2, steps=2, seed=0),
    "search.extremes (of an index)": of(f=planar_index, space=planar, samples=8, starts=2, steps=2, seed=0),
    "search.genetic_search": of(
        objective=lambda: hill,
        lower=np.zeros(2),
        upper=np.ones(2),
        precision=np.full(2, 0.01),
        generator=draws,
        options=search.GeneticOptions(population=4, generations=3),
    ),
    "search.zoom_search": of(
        objective=lambda: hill,
        lower=np.zeros(2),
        upper=np.ones(2),
        steps=np.full(2, 0.5),
        options=search.ZoomOptions(stages=3),
    ),
    # ---- networks ----
    "networks.Card": of(entries=lambda: {"name": "mine"}),
    "networks.Card.html": of(self=lambda: networks.Card({"name": "mine"}), whole_page=True),
    "networks.Effort": of(
        sizes=(2, 3),
        readouts=("identity",),
        rows=100,
        overhang=0.1,
        epochs=2,
        restarts=1,
        validation=16,
        seed=0,
    ),
    "networks.FeedForward": of(view=both, readout="identity", arrays=lambda: arrays_of(feed_forward())),
    "networks.FeedForward.untrained": of(
        view=both,
        neurons=2,
        q=lambda: data_set().q.numpy(),
        values=lambda: data_set().values.numpy(),
        random=draws,
        readout="identity",
    ),
    "networks.RadialBasis": of(view=both, arrays=lambda: arrays_of(radial_basis())),
    "networks.Network.forward": of(self=lambda: feed_forward(), q=PAIR),
    "networks.View": of(joints=6, inputs=(0, 1, 2)),
    "networks.View.forward": of(self=lambda: both(), q=PAIR),
    "networks.Guarded": of(network=lambda: feed_forward(), space=SQUARE),
    "networks.Guarded.load": of(path=saved),
    "networks.Guarded.of": of(network=lambda: learned().network),
    "networks.Guarded.__call__": of(self=lambda: guarded(), q=PAIR),
    "networks.Guarded.ask": of(self=lambda: guarded(), q=PAIR),
    "networks.Guarded.contains": of(self=lambda: guarded(), q=PAIR),
    "networks.Learned.__call__": of(self=lambda: learned(), q=0.1 * PAIR),
    "networks.Learned.save": of(self=lambda: learned(), path=lambda: folder() / "again.npz"),
    "networks.Recipe": of(
        neurons=4,
        readout="identity",
        rows=100,
        overhang=0.1,
        epochs=10,
        rounds=1,
        worst_points=10,
        round_epochs=2,
    ),
    "networks.Search": of(samples=100, corners=8, starts=4, steps=5),
    "networks.describe": of(
        network=lambda: feed_forward(),
        exact=lambda: hill,
        space=SQUARE,
        about=lambda: {"name": "mine"},
        seed=0,
        count=32,
        search=FEW,
        scale=1.0,
    ),
    "networks.for_index": of(
        chain=planar, index=planar_index, space=SQUARE, goal=0.5, name="small", effort=TINY, points=100
    ),
    "networks.judge": of(f=lambda: feed_forward(), data=data_set, scale=1.0),
    "networks.judge_again": of(network=lambda: learned().network, points=100, seed=1, search=FEW),
    "networks.load": of(path=saved),
    "networks.load_shipped": of(name=SHIPPED),
    "networks.prepare": of(
        recipe=networks.Recipe(neurons=2, rows=32, epochs=2),
        view=lambda: both(),
        index=lambda: hill,
        space=SQUARE,
        seeds=(0,),
        rows_seed=0,
    ),
    "networks.save": of(
        network=lambda: feed_forward(), path=lambda: folder() / "network.npz", card=lambda: {"name": "mine"}
    ),
    # ---- networks: other methods, cards ----
    "networks.baselines.Constant": of(value=1.0, joints=2),
    "networks.baselines.Constant.__call__": of(self=lambda: baselines.Constant(1.0, 2), q=PAIR),
    "networks.baselines.Polynomial.__call__": of(
        self=lambda: baselines.polynomial(both(), data_set(), 2), q=PAIR
    ),
    "networks.baselines.Trees.__call__": of(self=lambda: baselines.trees(both(), data_set()), q=PAIR),
    "networks.baselines.baselines": of(view=lambda: both(), train=data_set, seed=0),
    "networks.baselines.constant": of(train=data_set),
    "networks.baselines.polynomial": of(view=lambda: both(), train=data_set, degree=2),
    "networks.baselines.trees": of(view=lambda: both(), train=data_set, seed=0),
    "networks.card.chain_entry": of(chain=puma),
    "networks.card.index_entry": of(index=w),
    "networks.card.plain": of(value=lambda: networks.Search()),
    **{
        f"networks.card_text.{name}": of(card=lambda: {"name": "mine"})
        for name in ("facts", "limits", "lines", "markdown", "rows_of_errors")
    },
    "networks.card_text.percent": of(value=0.01),
    "networks.comparison.exact_operations": of(chain=planar, index=planar_index),
    "networks.comparison.fits": of(view=lambda: both(), train=data_set, scale=1.0),
    "networks.comparison.times": of(
        exact=lambda: hill,
        network=lambda: feed_forward(),
        q=lambda: torch.tensor(PAIR),
        language="torch",
        rounds=1,
        seconds=1e-4,
    ),
    # ---- networks: design and training ----
    "networks.design.FeedForwardOptions": of(
        testing_error=0.1,
        training_goal=0.1,
        neuron_limit=2,
        first_neurons=1,
        neuron_step=1,
        epoch_limit=2,
        restarts=1,
        damping="gain_ratio",
        readout="identity",
        seed=0,
        sweep="first",
    ),
    "networks.design.RadialBasisOptions": of(
        testing_error=0.1,
        training_goal=0.1,
        error_threshold=0.1,
        first_spread=1.0,
        spread_step=1.0,
        spread_limit=1.0,
        neuron_limit=2,
        input_scale=1.0,
        sweep="first",
    ),
    "networks.design.RadialBasisOptions.scale": of(
        self=lambda: growth.RadialBasisOptions(), view=lambda: both()
    ),
    "networks.design.design_all": of(
        runs=lambda: ((problem(), design.FeedForwardOptions(neuron_limit=1, epoch_limit=1)),),
        n_jobs=1,
        device="cpu",
        progress=False,
    ),
    "networks.design.design_feed_forward": of(
        problem=problem,
        options=design.FeedForwardOptions(neuron_limit=1, epoch_limit=1),
        device="cpu",
        progress=False,
    ),
    "networks.design.design_radial_basis": of(
        problem=problem,
        options=growth.RadialBasisOptions(neuron_limit=2, spread_limit=0.1),
        n_jobs=1,
        progress=False,
    ),
    "networks.problem.DesignProblem": of(view=lambda: both(), data=small_data),
    "networks.problem.largest_relative_error": of(network=lambda: feed_forward(), data=data_set),
    "networks.growth.fit": of(
        view=lambda: both(), train=data_set, centres=PAIR, spread=1.0, input_scale=np.ones(2)
    ),
    "networks.growth.grow": of(
        problem=problem, spread=1.0, options=growth.RadialBasisOptions(neuron_limit=2)
    ),
    "networks.pruning.prune": of(problem=problem, network=lambda: radial_basis(), testing_error=0.5),
    "networks.ladder.climb": of(task=lambda: ladder.Task(both(), hill, SQUARE, 0.5), effort=TINY),
    "networks.learning.fastest": of(chain=planar, index=planar_index),
    "networks.judgement.layer_operations": of(network=lambda: feed_forward()),
    "networks.levenberg_marquardt.Options": of(
        goal=0.1,
        epochs=3,
        damping="gain_ratio",
        initial_damping=0.1,
        smallest_gradient=0.1,
        smallest_step=0.1,
        largest_damping=10.0,
    ),
    "networks.levenberg_marquardt.levenberg_marquardt": of(
        network=lambda: feed_forward(),
        x=lambda: data_set().q.numpy(),
        y=lambda: data_set().values.numpy(),
        options=levenberg_marquardt.Options(epochs=2),
    ),
    "networks.train.for_seeds": of(
        view=lambda: both(),
        neurons=2,
        q=lambda: data_set().q.numpy(),
        values=lambda: data_set().values.numpy(),
        seeds=(0,),
        options=levenberg_marquardt.Options(epochs=2),
        readout="identity",
        device="cpu",
    ),
    "networks.train.initial_networks": of(
        view=lambda: both(),
        neurons=2,
        q=lambda: data_set().q.numpy(),
        values=lambda: data_set().values.numpy(),
        seeds=(0,),
        readout="identity",
    ),
    # ---- networks: export, spaces, judgement ----
    "networks.domain_export.coordinates": of(space=SQUARE),
    "networks.domain_export.javascript_module": of(guarded=lambda: guarded()),
    "networks.domain_export.space_module": of(space=SQUARE),
    "networks.export.CompiledNetwork": of(network=lambda: feed_forward()),
    "networks.export.CompiledNetwork.__call__": of(
        self=lambda: export.compile_network(feed_forward()), q=PAIR
    ),
    "networks.export.c_files": of(network=lambda: feed_forward(), name="small", precision="double"),
    "networks.export.c_source": of(network=lambda: feed_forward(), name="small", precision="double"),
    "networks.export.compile_network": of(network=lambda: feed_forward()),
    "networks.export.javascript_module": of(network=lambda: feed_forward()),
    "networks.export.onnx_model": of(network=lambda: feed_forward(), precision="double"),
    "networks.export.save_onnx": of(
        network=lambda: feed_forward(), path=lambda: folder() / "small.onnx", precision="double"
    ),
    "networks.rounding.is_sound": of(network=lambda: feed_forward(), q=PAIR, error=0.1),
    "networks.rounding.rounding": of(network=lambda: feed_forward(), q=PAIR),
    "networks.spaces.from_card": of(entry=lambda: networks.spaces.to_card(SQUARE)),
    "networks.spaces.to_card": of(space=SQUARE),
    "networks.validation.acceptance_bias": of(
        networks=lambda: (feed_forward(),), test=data_set, fresh=data_set, limit=0.1
    ),
    "networks.validation.error_distribution": learns(count=16, seed=0, method="sobol"),
    "networks.validation.fresh": of(index=lambda: hill, space=SQUARE, count=8, seed=0, method="sobol"),
    "networks.validation.passing_probability": of(share=0.1, points=10),
    "networks.validation.relative_errors": of(f=lambda: feed_forward(), data=data_set, scale=1.0),
    "networks.worst_case.climb": learns(
        u=lambda: torch.full((2, 2), 0.4, dtype=torch.float64), steps=2, scale=1.0
    ),
    "networks.worst_case.worst_case": learns(search=FEW, seed=0, scale=1.0),
    "networks.worst_case.worst_points": learns(search=FEW, seed=0, scale=1.0),
}
