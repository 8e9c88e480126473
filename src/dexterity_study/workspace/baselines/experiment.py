"""Other methods of machine learning on the data of paper C, and a small network beside them.

Liao & Mao (2018), section VI.A, Tables VI and VII. A method that cannot take all rows gets a part of them, and for
confidence also smaller parts, which show what more rows are worth. The network has three small layers and the
paper's columns; it is here for the claims that compare it with the other methods.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from sklearn import clone, metrics
from sklearn.ensemble import AdaBoostClassifier, RandomForestClassifier
from sklearn.gaussian_process import GaussianProcessClassifier, GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF
from sklearn.linear_model import LinearRegression, LogisticRegression, Ridge
from sklearn.naive_bayes import GaussianNB
from sklearn.neighbors import KNeighborsRegressor
from sklearn.svm import SVC, LinearSVC
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor
from torch import Tensor

from dexterity.workspace import dataset, training
from dexterity.workspace.dataset import ConfidenceData, JacobianData, Scaling
from dexterity.workspace.jacobian_net import Architecture, JacobianNet, encode
from dexterity_study.engine.experiment import experiment


class Method(NamedTuple):
    """A method of the paper's tables: its name in the ledger, and an untrained model with the assumed settings."""

    key: str
    model: Any


def _xgboost() -> Any:
    from xgboost import XGBClassifier  # the book does without it

    return XGBClassifier(max_depth=1, n_estimators=100, learning_rate=0.1, n_jobs=1)


def _lightgbm() -> Any:
    from lightgbm import LGBMClassifier  # the book does without it

    return LGBMClassifier(n_jobs=1, verbosity=-1)


CLASSIFIERS: Mapping[str, Method] = {
    "SVM(RBF)": Method("svm-radial", SVC(kernel="rbf", gamma="auto")),
    "SVM(Sigmoid)": Method("svm-sigmoid", SVC(kernel="sigmoid", gamma="auto")),
    "SVM(Lin. L2)": Method("svm-linear", LinearSVC()),
    "LogisticReg.": Method("logistic-regression", LogisticRegression()),
    # It predicts a number, which is cut at 0.5.
    "RidgeReg.(0.5)": Method("ridge-regression", Ridge()),
    "Naive Bayes": Method("naive-bayes", GaussianNB()),
    "Gauss. Process": Method("gaussian-process", GaussianProcessClassifier(RBF(1.0, "fixed"))),
    "Decision Tree": Method("decision-tree", DecisionTreeClassifier()),
    "Random Forest": Method("random-forest", RandomForestClassifier(n_estimators=10)),
    "AdaBoosted DT": Method("boosted-trees", AdaBoostClassifier(n_estimators=50)),
    "XGboost": Method("xgboost", _xgboost),
    "LightGBM": Method("lightgbm", _lightgbm),
}
"""Methods of Table VI except the networks."""

REGRESSORS: Mapping[str, Method] = {
    "Lin.Reg.": Method("linear-regression", LinearRegression()),
    "RidgeReg.": Method("ridge-regression", Ridge()),
    "Decision Tree": Method("decision-tree", DecisionTreeRegressor()),
    "Gauss. Process": Method("gaussian-process", GaussianProcessRegressor(RBF(1.0, "fixed"))),
    "k-NN": Method("nearest-neighbours", KNeighborsRegressor()),
}
"""Methods of Table VII except the network."""

THRESHOLDS = {"NN(.5)": 0.5, "NN(.25)": 0.25, "NN(.75)": 0.75}
"""Thresholds of the network in Table VI."""

TARGETS = {"tool": (23, 2), "world": (21, 1)}
"""Numbers of entries of the Jacobian that vary and of constant ones that the paper's targets have besides.

Its library scales a constant to the lower end, −1. To predict zero then costs 1 in the mean square there, and
the printed rows of ridge regression and of the Gaussian process, which predicts zero, differ by 2 of 25.
"""

PARTS = {
    "SVM(RBF)": (5000, 10_000, 20_000),
    "SVM(Sigmoid)": (5000, 10_000, 20_000),
    "Gauss. Process": (500, 1000, 2000),
    "AdaBoosted DT": (297_000,),
}
"""Rows of the slow methods; all others take all rows."""

SMALL = {"train": 400, "test": 200}
SMALL_PARTS = dict(zip(PARTS, [(100, 200), (100, 200), (50, 100), (400,)], strict=True))
# A tree that splits elsewhere answers otherwise for a few rows.
NEAR = {"rtol": 1e-2, "atol": 5e-2}
CONFIDENCE: Any = {"keys": ("method", "rows"), **NEAR}
CLASSES: Any = {"paper": "liao2018", "assumes": ("test-classes",), "readings": ("test-classes=equal",)}
Array = NDArray[np.float64]
Rows = Iterator[dict[str, Any]]


def seeded(method: Method, seed: int) -> Any:
    """Return an untrained model, with a seed for what it draws."""
    model = method.model() if callable(method.model) else clone(method.model)
    return model.set_params(random_state=seed) if "random_state" in model.get_params() else model


@experiment(seeds=3, reading_seeds=1, smoke=SMALL, **CONFIDENCE, **CLASSES)
def confidence(seed: int, reading: Mapping[str, Any], train: int = 297_000, test: int = 20_000) -> Rows:
    """Answers of the methods of Table VI that take all rows."""
    parts = {name: (train,) for name in CLASSIFIERS if name not in PARTS}
    return _classified(seed, reading["test-classes"], parts, train, test)


@experiment(reading_seeds=1, smoke={**SMALL, "parts": SMALL_PARTS}, **CONFIDENCE, **CLASSES)
def slow_confidence(
    seed: int, reading: Mapping[str, Any], parts: Mapping[str, Sequence[int]] = PARTS, **sizes: int
) -> Rows:
    """Answers of AdaBoost and of the methods that take a part of the rows, smaller and larger."""
    return _classified(seed, reading["test-classes"], parts, **sizes)


def _classified(
    seed: int, classes: str, parts: Mapping[str, Sequence[int]], train: int = 297_000, test: int = 20_000
) -> Rows:
    """Fit methods to the first rows, as many as each gets, and test them."""
    draw = equal_classes if classes == "equal" else dataset.confidence_data
    (samples, label), (others, truth) = draw(train, 3 * seed), draw(test, 3 * seed + 2)
    scaling = Scaling.to_unit_deviation(dataset.features(samples))
    x, test_x = (scaling.apply(dataset.features(own)).numpy() for own in (samples, others))
    for name, counts in parts.items():
        for count in counts:
            model = seeded(CLASSIFIERS[name], seed).fit(x[:count], label.numpy()[:count])
            yield {
                "method": name,
                "rows": count,
                **shares_of(truth, torch.as_tensor(model.predict(test_x) > 0.5)),
            }


@experiment(smoke={**SMALL, "epochs": 2}, **CONFIDENCE)
def confidence_network(seed: int, epochs: int = 20, train: int = 297_000, test: int = 20_000) -> Rows:
    """Answers of a small network at three thresholds."""
    data, (others, truth) = (dataset.confidence_data(n, 3 * seed + k) for n, k in ((train, 0), (test, 2)))
    scaling = Scaling.to_unit_deviation(dataset.features(data.samples))
    nothing = torch.zeros(TARGETS["tool"][0], dtype=torch.float64)
    random = torch.Generator().manual_seed(seed)
    network = JacobianNet(Architecture(), "columns", "tool", scaling, Scaling(nothing, nothing + 1), random)
    _train(network, "confidence", training.confidence_rows(network, data), epochs, seed)
    answer = network.estimate(others).confidence
    for name, threshold in THRESHOLDS.items():
        yield {"method": name, "rows": train, **shares_of(truth, answer >= threshold)}


def equal_classes(count: int, seed: int) -> ConfidenceData:
    """Draw an even number of samples, of which half are in reach; all others beyond these are dropped."""
    # A good third is out of reach, as drawn.
    drawn = dataset.confidence_data(round(1.5 * count) + 100, seed)
    halves = [where.nonzero()[: count // 2, 0] for where in (drawn.reachable, ~drawn.reachable)]
    rows = torch.cat(halves).sort().values
    return ConfidenceData(drawn.samples.rows(rows), drawn.reachable[rows])


def shares_of(truth: Tensor, answer: Tensor) -> dict[str, float]:
    """Return the shares of the answers (n) that find a pose in reach, miss it, or find one that is out of reach."""
    cases = {"hits": truth & answer, "misses": truth & ~answer, "false_alarms": ~truth & answer}
    return {name: case.double().mean().item() for name, case in cases.items()}


@experiment(
    seeds=3,
    keys=("method",),
    paper="liao2018",
    assumes=("baseline-inputs", "estimation-frame"),
    readings=("baseline-inputs=each-set", "estimation-frame=world"),
    smoke={"train": 300, "test": 100, "parts": (200, 50, 300)},
    **NEAR,
)
def estimation(
    seed: int,
    reading: Mapping[str, Any],
    train: int = 198_000,
    test: int = 2000,
    parts: Sequence[int] = (10_000, 2000, 50_000),
) -> Rows:
    """Errors and scores of the methods of Table VII; the last three take a part of the rows."""
    data, others = _jacobians(seed, train, test)
    frame = reading["estimation-frame"]
    x, y = _scaled(data, frame, data)
    test_x, truth = _scaled(others, frame, others if reading["baseline-inputs"] == "each-set" else data)
    for (name, method), count in zip(REGRESSORS.items(), (train, train, *parts), strict=True):
        answer = seeded(method, seed).fit(x[:count], y[:count]).predict(test_x)
        yield {"method": name, "rows": count, **errors_of(truth, answer, TARGETS[frame][0])}


@experiment(smoke={"train": 300, "test": 100, "epochs": 2}, **NEAR)
def estimation_network(seed: int, epochs: int = 15, train: int = 198_000, test: int = 2000) -> Rows:
    """Errors and scores of a small network."""
    data, others = _jacobians(seed, train, test)
    network = training.network_for(Architecture(), "columns", "tool", data, seed)
    _train(network, "estimation", training.estimation_rows(network, data), epochs, seed)
    estimate = others._replace(jacobian=network.estimate(others.samples).jacobian)
    truth, answer = (_scaled(own, "tool", data)[1] for own in (others, estimate))
    yield {"rows": train, **errors_of(truth, answer, TARGETS["tool"][0])}


def errors_of(truth: Array, answer: Array, varying: int) -> dict[str, float]:
    """Judge answers (n, k) against the truth (n, k), of whose columns the first ones vary; each weighs the same.

    A constant target scores 1 if it is met exactly, and 0 otherwise, as in scikit-learn.
    """
    scores = {"explained": metrics.explained_variance_score, "determination": metrics.r2_score}
    return {
        "absolute": metrics.mean_absolute_error(truth, answer),
        "squared": metrics.mean_squared_error(truth, answer),
        **{name: score(truth, answer) for name, score in scores.items()},
        **{
            f"{name}_of_varying": score(truth[:, :varying], answer[:, :varying])
            for name, score in scores.items()
        },
    }


def _jacobians(seed: int, train: int, test: int) -> tuple[JacobianData, JacobianData]:
    return dataset.jacobian_data(train, 2 * seed), dataset.jacobian_data(test, 2 * seed + 1)


def _scaled(data: JacobianData, frame: Any, fitted: JacobianData) -> tuple[Array, Array]:
    """Return inputs and targets, scaled as `fitted` is; targets that vary come first, constant ones are −1."""
    inputs = Scaling.to_unit_deviation(dataset.features(fitted.samples)).apply(dataset.features(data.samples))
    scaling = Scaling.to_range(encode(fitted.jacobian, fitted.samples, frame))
    varying = scaling.apply(encode(data.jacobian, data.samples, frame))
    constant = varying.new_full((len(varying), TARGETS[frame][1]), -1.0)
    return inputs.numpy(), torch.cat([varying, constant], 1).numpy()


def _train(network: JacobianNet, head: Any, rows: training.Rows, epochs: int, seed: int) -> None:
    # At least a few steps an epoch.
    options = training.Options(training.epochs(**{head: epochs}), batch=min(1024, max(2, len(rows.x) // 10)))
    training.train(network, {head: rows}, options, seed)
    network.requires_grad_(False)
