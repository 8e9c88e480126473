"""Paper C, section VI.A: what other methods make of its data, Tables VI and VII.

Liao & Mao (2018). Every method but the networks is trained on data of our generator with the settings that
the ledger assumes, and judged on the paper's number of test rows and, for confidence, on a larger set beside
it. A small network on the paper's columns stands there for its own claims only, that it beats them all; the
networks themselves have a study of their own. Methods that cannot take all rows get a part of them, which is
told, and for confidence also smaller parts, which show where more rows would lead.

Confidence is done on data as drawn and with as many poses in reach as out of it, in training and test, since
the accuracies and correlations of Table VI fit equal classes only. Estimation is done for Jacobians in the
axes of the tool and of the base, and once more for those of the tool with a test set that is scaled by
itself, as the library's functions that the paper names would do it.

Thresholds: a row of Table VI is *reproduced* if every printed number is within half a printed digit and two
standard errors of a test set of 3 000 rows from ours, on data as drawn; *fitted* if it is so with equal
classes; *in shape* if all numbers are within 0.05 for either; else *not reproduced*. A row of Table VII is
*reproduced* if errors are within 2 % and scores within 0.01, for the tool's axes; *fitted* if they are so
with a test set scaled by itself; *in shape* if within 10 % and 0.1 for either; else *not reproduced*. Scores
count the constant targets. Linear methods are alike if their accuracies are within 0.01.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, Final, Literal, NamedTuple, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from dexterity.networks.threads import one_thread
from dexterity.report.claims import Acceptance, Claim, Outcome, Verdict, load_paper
from dexterity.report.ranges import with_range
from dexterity.report.stored import Tolerance
from dexterity.timing import Timing, Way, measure
from dexterity.workspace.dataset import (
    ConfidenceData,
    JacobianData,
    Samples,
    Scaling,
    confidence_data,
    features,
    jacobian_data,
)
from dexterity.workspace.jacobian_net import Architecture, JacobianNet, encode
from dexterity.workspace.training import Options, confidence_rows, epochs, estimation_rows, network_for, train

__all__ = [
    "CLASSIFIERS",
    "CONFIGS",
    "CONSTANT_TARGETS",
    "JUDGED_AS_STORED",
    "NETWORKS",
    "REGRESSORS",
    "TOLERANCE",
    "Classification",
    "Classifier",
    "Config",
    "Errors",
    "Regressor",
    "Result",
    "acceptance",
    "classifiers",
    "confidence_table",
    "equal_classes",
    "errors_of",
    "estimation_table",
    "growth_table",
    "regressors",
    "run",
    "scores_of",
    "time_table",
    "verdicts",
]

CLASSIFIERS: Mapping[str, str] = {
    "SVM(RBF)": "svm-radial",
    "SVM(Sigmoid)": "svm-sigmoid",
    "SVM(Lin. L2)": "svm-linear",
    "LogisticReg.": "logistic-regression",
    "RidgeReg.(0.5)": "ridge-regression",
    "Naive Bayes": "naive-bayes",
    "Gauss. Process": "gaussian-process",
    "Decision Tree": "decision-tree",
    "Random Forest": "random-forest",
    "AdaBoosted DT": "boosted-trees",
    "XGboost": "xgboost",
    "LightGBM": "lightgbm",
}
"""Methods of Table VI but the networks, with what the ledger calls them."""

REGRESSORS: Mapping[str, str] = {
    "Lin.Reg.": "linear-regression",
    "RidgeReg.": "ridge-regression",
    "Decision Tree": "decision-tree",
    "Gauss. Process": "gaussian-process",
    "k-NN": "nearest-neighbours",
}
"""Methods of Table VII but the network, with what the ledger calls them."""

NETWORKS: Mapping[str, float] = {"NN(.5)": 0.5, "NN(.25)": 0.25, "NN(.75)": 0.75}
"""The network at the thresholds of Table VI; it is ``NN`` in estimation."""

CONSTANT_TARGETS: Mapping[str, int] = {"tool": 2, "world": 1}
"""Constant entries of the Jacobian that the paper's targets have beside those that vary.

Its library scales a constant to the lower end, −1. To predict zero then costs 1 in the mean square there, and
the printed rows of ridge regression and of the Gaussian process, which predicts zero, differ by 2 of 25.
"""

TOLERANCE = Tolerance(rtol=1e-2, atol=5e-2)
"""What a probe may miss by, since a tree that splits elsewhere answers otherwise for a few rows."""

JUDGED_AS_STORED = True
"""Verdicts and acceptance figures are those of the stored result, since a book trains on too few rows."""

_PAPER = "liao2018"
_LARGE, _SMALL = "large", "small"
_DRAWN, _EQUAL = "as drawn", "equal classes"
_TOOL: Final = "tool"
_WORLD: Final = "world"
_BY_ITSELF: Final = "tool, test scaled by itself"
_STUMPS_RATE = 0.1
_VARYING_TARGETS = 23  # in the axes of the tool
_PRINTED_ROWS = 3000

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Config:
    """How many rows methods get.

    Attributes
    ----------
    seeds
        Of data and methods. Methods that get a part of the rows, AdaBoost and networks take the first one
        only, and so does all that is done with equal classes.
    train, small, large
        Rows for confidence: for training, of the test set of the paper's size and of the larger one.
    kernel, process
        Rows that SVMs with kernels and Gaussian processes get for confidence; the last is what counts.
    estimation_train, estimation_test
        Rows for estimation.
    tree, neighbours, estimation_process
        Rows that these get for estimation.
    confidence_epochs, estimation_epochs
        Of the small networks.
    rounds, seconds
        How often a time to predict is taken, and for how long at least [s]; no times without rounds.
    """

    seeds: tuple[int, ...] = (0,)
    train: int = 40_000
    small: int = 3000
    large: int = 10_000
    kernel: tuple[int, ...] = (1250, 2500, 5000)
    process: tuple[int, ...] = (250, 500, 1000)
    estimation_train: int = 20_000
    estimation_test: int = 2000
    tree: int = 2000
    neighbours: int = 20_000
    estimation_process: int = 500
    confidence_epochs: int = 30
    estimation_epochs: int = 20
    rounds: int = 3
    seconds: float = 0.01


CONFIGS: Mapping[str, Config] = {
    "smoke": Config(
        seeds=(0, 1), train=400, small=100, large=200, kernel=(100, 200), process=(50, 100),
        estimation_train=300, estimation_test=100, tree=200, neighbours=300, estimation_process=50,
        confidence_epochs=2, estimation_epochs=2, rounds=0,
    ),
    "book": Config(),
    "full": Config(
        seeds=(0, 1, 2), train=297_000, large=20_000, kernel=(5000, 10_000, 20_000),
        process=(500, 1000, 2000), estimation_train=198_000, tree=10_000, neighbours=50_000,
        estimation_process=2000, confidence_epochs=20, estimation_epochs=15,
    ),
}  # fmt: skip
"""What runs at each scale."""


# ---- results ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Classification:
    """Scores on a test set, an entry for each seed; the class that counts is that of poses in reach.

    Attributes
    ----------
    accuracy
        Share of right answers, which the paper prints as JSC; its 0-1 loss is the rest.
    precision, recall, correlation
        The last is Matthews's.
    jaccard
        Poses rightly said to be in reach over those that are or are said to be.
    """

    accuracy: tuple[float, ...]
    precision: tuple[float, ...]
    recall: tuple[float, ...]
    correlation: tuple[float, ...]
    jaccard: tuple[float, ...]


@dataclass(frozen=True)
class Classifier:
    """What a method makes of confidence.

    Attributes
    ----------
    rows
        It was trained on.
    scores
        On the `"small"` and on the `"large"` test set.
    times
        Of a row, to predict the small test set at once; empty if none was taken.
    """

    rows: int
    scores: Mapping[str, Classification]
    times: tuple[Timing, ...]


@dataclass(frozen=True)
class Errors:
    """Errors and scores, means over targets, an entry for each seed.

    Attributes
    ----------
    absolute, squared
        Mean errors of targets scaled to [−1, 1].
    explained, determination
        EVS and R².
    """

    absolute: tuple[float, ...]
    squared: tuple[float, ...]
    explained: tuple[float, ...]
    determination: tuple[float, ...]


@dataclass(frozen=True)
class Regressor:
    """What a method makes of estimation.

    Attributes
    ----------
    rows
        It was trained on.
    varying, all_targets
        Over the targets that vary, and with the constant ones.
    times
        Of a row, to predict the test set at once; empty if none was taken.
    """

    rows: int
    varying: Errors
    all_targets: Errors
    times: tuple[Timing, ...]


@dataclass(frozen=True)
class Result:
    """What all methods make of the paper's two tasks.

    Attributes
    ----------
    confidence
        By classes, `"as drawn"` or `"equal classes"`, then by method; networks as drawn only.
    share
        Of poses in reach, in the large test set of the first seed, by classes.
    growth
        Accuracy on the large test set, as drawn, by method and number of training rows.
    estimation
        By targets, `"tool"`, `"world"` or `"tool, test scaled by itself"`, then by method.
    """

    confidence: Mapping[str, Mapping[str, Classifier]]
    share: Mapping[str, float]
    growth: Mapping[str, Mapping[str, float]]
    estimation: Mapping[str, Mapping[str, Regressor]]


def run(config: Config) -> Result:
    """Train and judge all methods."""
    with one_thread():
        drawn = _Confidence(config, equal=False)
        equal = _Confidence(config, equal=True)
        estimation = _Estimation(config)
        return Result(
            confidence={_DRAWN: drawn.found(), _EQUAL: equal.found()},
            share={_DRAWN: drawn.share, _EQUAL: equal.share},
            growth=drawn.growth,
            estimation={
                **{targets: estimation.found(targets) for targets in (_TOOL, _WORLD)},
                _BY_ITSELF: {name: _joined_regressors(own) for name, own in estimation.by_itself.items()},
            },
        )


# ---- methods ---------------------------------------------------------------------------------------


def classifiers(seed: int) -> dict[str, Any]:
    """Return untrained classifiers in the order of `CLASSIFIERS`, with the settings that the ledger assumes.

    Ridge regression predicts a number, which is cut at 0.5.
    """
    from lightgbm import LGBMClassifier
    from sklearn.ensemble import AdaBoostClassifier, RandomForestClassifier
    from sklearn.gaussian_process import GaussianProcessClassifier
    from sklearn.linear_model import LogisticRegression, Ridge
    from sklearn.naive_bayes import GaussianNB
    from sklearn.svm import SVC, LinearSVC
    from sklearn.tree import DecisionTreeClassifier
    from xgboost import XGBClassifier

    stumps = {"max_depth": 1, "n_estimators": 100, "learning_rate": _STUMPS_RATE}
    return dict(
        zip(
            CLASSIFIERS,
            (
                SVC(kernel="rbf", gamma="auto"),
                SVC(kernel="sigmoid", gamma="auto"),
                LinearSVC(random_state=seed),
                LogisticRegression(),
                Ridge(),
                GaussianNB(),
                GaussianProcessClassifier(_kernel(), random_state=seed),
                DecisionTreeClassifier(random_state=seed),
                RandomForestClassifier(n_estimators=10, random_state=seed),
                AdaBoostClassifier(n_estimators=50, random_state=seed),
                XGBClassifier(**stumps, n_jobs=1, random_state=seed),
                LGBMClassifier(n_jobs=1, verbosity=-1, random_state=seed),
            ),
            strict=True,
        )
    )


def regressors(seed: int) -> dict[str, Any]:
    """Return untrained regressors in the order of `REGRESSORS`, with the settings that the ledger assumes."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.linear_model import LinearRegression, Ridge
    from sklearn.neighbors import KNeighborsRegressor
    from sklearn.tree import DecisionTreeRegressor

    return dict(
        zip(
            REGRESSORS,
            (
                LinearRegression(),
                Ridge(),
                DecisionTreeRegressor(random_state=seed),
                GaussianProcessRegressor(_kernel(), random_state=seed),
                KNeighborsRegressor(),
            ),
            strict=True,
        )
    )


def _kernel() -> Any:
    """Return the kernel of a Gaussian process, whose height and width of 1 are not fitted."""
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    return ConstantKernel(1.0, "fixed") * RBF(1.0, "fixed")


def _times(name: str, model: Any, x: Array, config: Config) -> tuple[Timing, ...]:
    if not config.rounds:
        return ()
    return measure([Way(name, partial(model.predict, x), len(x))], config.rounds, config.seconds)


# ---- confidence ------------------------------------------------------------------------------------


def equal_classes(count: int, seed: int) -> ConfidenceData:
    """Draw samples of which half are in reach; all others beyond these are dropped.

    Raises
    ------
    ValueError
        If `count` is not positive or is odd.
    """
    if count < 2 or count % 2:
        raise ValueError(f"count is {count}; a positive even number is needed")
    # A good third is out of reach, as drawn.
    drawn = confidence_data(round(1.5 * count) + 100, seed)
    halves = [where.nonzero()[: count // 2, 0] for where in (drawn.reachable, ~drawn.reachable)]
    rows = torch.cat(halves).sort().values
    return ConfidenceData(drawn.samples.rows(rows), drawn.reachable[rows])


def scores_of(truth: NDArray[np.bool_], answer: NDArray[np.bool_]) -> Classification:
    """Score answers (n) beside the truth (n)."""
    from sklearn.metrics import jaccard_score, matthews_corrcoef, precision_score, recall_score

    return Classification(
        accuracy=(float(np.mean(truth == answer)),),
        precision=(float(precision_score(truth, answer, zero_division=0.0)),),
        recall=(float(recall_score(truth, answer, zero_division=0.0)),),
        correlation=(float(matthews_corrcoef(truth, answer)),),
        jaccard=(float(jaccard_score(truth, answer, zero_division=0.0)),),
    )


class _Labelled(NamedTuple):
    data: ConfidenceData
    x: Array
    y: NDArray[np.bool_]


class _Confidence:
    """All that is done with one set of classes."""

    def __init__(self, config: Config, equal: bool) -> None:
        self.config, self.equal = config, equal
        self.growth: dict[str, dict[str, float]] = {}
        self.classifiers: dict[str, list[Classifier]] = {}
        for seed in config.seeds[:1] if equal else config.seeds:
            self.judge(seed)

    def found(self) -> dict[str, Classifier]:
        return {name: _joined_classifiers(own) for name, own in self.classifiers.items()}

    def judge(self, seed: int) -> None:
        draw = equal_classes if self.equal else confidence_data
        first = seed == self.config.seeds[0]
        data = draw(self.config.train, 3 * seed)
        scaling = Scaling.to_unit_deviation(features(data.samples))
        rows = _labelled(data, scaling)
        tests = {
            _SMALL: _labelled(draw(self.config.small, 3 * seed + 1), scaling),
            _LARGE: _labelled(draw(self.config.large, 3 * seed + 2), scaling),
        }
        if first:
            self.share = float(tests[_LARGE].y.mean())
        for name, model in classifiers(seed).items():
            if first or name not in _ONCE:
                for count in self.sizes(name):
                    model.fit(rows.x[:count], rows.y[:count])
                    found = self.classifier(name, model, count, tests)
                    self.note_growth(name, found)
                self.classifiers.setdefault(name, []).append(found)
        if first and not self.equal:
            self.judge_network(rows.data, scaling, tests, seed)

    def sizes(self, name: str) -> tuple[int, ...]:
        parts = {
            "SVM(RBF)": self.config.kernel,
            "SVM(Sigmoid)": self.config.kernel,
            "Gauss. Process": self.config.process,
        }.get(name, (self.config.train,))
        return parts[-1:] if self.equal else parts

    def note_growth(self, name: str, found: Classifier) -> None:
        if len(self.sizes(name)) > 1:
            self.growth.setdefault(name, {})[f"{found.rows}"] = found.scores[_LARGE].accuracy[0]

    def classifier(self, name: str, model: Any, count: int, tests: Mapping[str, _Labelled]) -> Classifier:
        timed = count == self.sizes(name)[-1] and not self.equal
        return Classifier(
            count,
            {
                size: scores_of(test.y, np.asarray(model.predict(test.x)) > 0.5)
                for size, test in tests.items()
            },
            _times(name, model, tests[_SMALL].x, self.config) if timed else (),
        )

    def judge_network(
        self, data: ConfidenceData, scaling: Scaling, tests: Mapping[str, _Labelled], seed: int
    ) -> None:
        nothing = torch.zeros(_VARYING_TARGETS, dtype=torch.float64)
        random = torch.Generator().manual_seed(seed)
        network = JacobianNet(
            Architecture(), "columns", _TOOL, scaling, Scaling(nothing, nothing + 1), random
        )
        options = Options(epochs(confidence=self.config.confidence_epochs), batch=_batch(len(data.reachable)))
        train(network, {"confidence": confidence_rows(network, data)}, options, seed)
        network.eval()
        with torch.no_grad():
            answers = {
                size: network.estimate(test.data.samples).confidence.numpy() for size, test in tests.items()
            }
        for name, threshold in NETWORKS.items():
            scores = {size: scores_of(test.y, answers[size] >= threshold) for size, test in tests.items()}
            self.classifiers[name] = [Classifier(len(data.reachable), scores, ())]


_ONCE = ("SVM(RBF)", "SVM(Sigmoid)", "Gauss. Process", "AdaBoosted DT")


def _labelled(data: ConfidenceData, scaling: Scaling) -> _Labelled:
    return _Labelled(data, scaling.apply(features(data.samples)).numpy(), data.reachable.numpy())


def _batch(rows: int) -> int:
    """At least a few steps an epoch."""
    return min(1024, max(2, rows // 10))


def _joined_classifiers(own: Sequence[Classifier]) -> Classifier:
    scores = {
        size: Classification(**_joined([found.scores[size] for found in own])) for size in (_SMALL, _LARGE)
    }
    return Classifier(own[-1].rows, scores, own[0].times)


def _joined(own: Sequence[Any]) -> dict[str, tuple[float, ...]]:
    """Put the entries of like scores of several seeds one after the other."""
    return {name: tuple(value for one in own for value in getattr(one, name)) for name in vars(own[0])}


# ---- estimation ------------------------------------------------------------------------------------


def errors_of(truth: Array, answer: Array) -> Errors:
    """Judge answers (n, k) beside the truth (n, k); each target weighs the same.

    A constant target scores 1 if it is met exactly, and 0 otherwise, as in scikit-learn.
    """
    from sklearn import metrics

    return Errors(
        (float(metrics.mean_absolute_error(truth, answer)),),
        (float(metrics.mean_squared_error(truth, answer)),),
        (float(metrics.explained_variance_score(truth, answer)),),
        (float(metrics.r2_score(truth, answer)),),
    )


class _Scaled(NamedTuple):
    x: Array
    y: Array


Frame = Literal["tool", "world"]


class _Estimation:
    """All that is done with Jacobians."""

    def __init__(self, config: Config) -> None:
        self.config = config
        self.regressors: dict[str, dict[str, list[Regressor]]] = {_TOOL: {}, _WORLD: {}}
        self.by_itself: dict[str, list[Regressor]] = {}
        for seed in config.seeds:
            data = jacobian_data(config.estimation_train, 2 * seed)
            test = jacobian_data(config.estimation_test, 2 * seed + 1)
            self.judge(data, test, "tool", seed)
            if seed == config.seeds[0]:
                self.judge(data, test, "world", seed)
                self.judge_network(data, test, seed)

    def found(self, targets: str) -> dict[str, Regressor]:
        return {name: _joined_regressors(own) for name, own in self.regressors[targets].items()}

    def judge(self, data: JacobianData, test: JacobianData, frame: Frame, seed: int) -> None:
        scalings = _scalings(data, frame)
        rows, judged, alone = (
            _scaled(data, frame, scalings),
            _scaled(test, frame, scalings),
            _scaled(test, frame, _scalings(test, frame)),
        )
        for name, model in regressors(seed).items():
            if seed != self.config.seeds[0] and name in ("Decision Tree", "Gauss. Process"):
                continue
            count = self.rows(name)
            model.fit(rows.x[:count], rows.y[:count])
            first = seed == self.config.seeds[0] and frame == _TOOL
            times = _times(name, model, judged.x, self.config) if first else ()
            own = _regressor(count, judged.y, model.predict(judged.x), frame, times)
            self.regressors[frame].setdefault(name, []).append(own)
            if frame == _TOOL:
                own = _regressor(count, alone.y, model.predict(alone.x), frame, ())
                self.by_itself.setdefault(name, []).append(own)

    def rows(self, name: str) -> int:
        return {
            "Decision Tree": self.config.tree,
            "Gauss. Process": self.config.estimation_process,
            "k-NN": self.config.neighbours,
        }.get(name, self.config.estimation_train)

    def judge_network(self, data: JacobianData, test: JacobianData, seed: int) -> None:
        network = network_for(Architecture(), "columns", _TOOL, data, seed)
        options = Options(epochs(estimation=self.config.estimation_epochs), batch=_batch(len(data.jacobian)))
        train(network, {"estimation": estimation_rows(network, data)}, options, seed)
        network.eval()
        with torch.no_grad():
            answer = network.estimate(test.samples).jacobian
        scalings = _scalings(data, "tool")
        truth, said = (_targets(J, test.samples, "tool", scalings[1]) for J in (test.jacobian, answer))
        own = _regressor(len(data.jacobian), truth, said, "tool", ())
        self.regressors[_TOOL]["NN"] = [own]


def _scalings(data: JacobianData, frame: Frame) -> tuple[Scaling, Scaling]:
    targets = encode(data.jacobian, data.samples, frame)
    return Scaling.to_unit_deviation(features(data.samples)), Scaling.to_range(targets)


def _scaled(data: JacobianData, frame: Frame, scalings: tuple[Scaling, Scaling]) -> _Scaled:
    x = scalings[0].apply(features(data.samples)).numpy()
    return _Scaled(x, _targets(data.jacobian, data.samples, frame, scalings[1]))


def _targets(J: Tensor, samples: Samples, frame: Frame, scaling: Scaling) -> Array:
    """Return scaled targets, those that vary first, the constant ones at −1 behind them."""
    varying = scaling.apply(encode(J, samples, frame))
    constant = varying.new_full((len(varying), CONSTANT_TARGETS[frame]), -1.0)
    return torch.cat([varying, constant], 1).numpy()


def _regressor(rows: int, truth: Array, answer: Array, frame: Frame, times: tuple[Timing, ...]) -> Regressor:
    varying = slice(truth.shape[1] - CONSTANT_TARGETS[frame])
    return Regressor(rows, errors_of(truth[:, varying], answer[:, varying]), errors_of(truth, answer), times)


def _joined_regressors(own: Sequence[Regressor]) -> Regressor:
    varying, all_targets = (
        Errors(**_joined([getattr(found, part) for found in own])) for part in ("varying", "all_targets")
    )
    return Regressor(own[0].rows, varying, all_targets, own[0].times)


# ---- tables ----------------------------------------------------------------------------------------

_NOTHING = "–"
_PAPERS = "paper"


def confidence_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Table VI with ours, on the large test set, beside the paper's; by method and whose.

    The networks are small ones. Accuracy is told for a test set of the paper's size as well.
    """
    rows = {}
    for name in (*NETWORKS, *CLASSIFIERS):
        printed = dict(zip(_SCORES, _printed_scores(name), strict=True))
        rows[name, _PAPERS] = {"rows": _NOTHING, **printed, "Jaccard": _NOTHING, "JSC, 3 000 rows": _NOTHING}
        for classes, methods in result.confidence.items():
            if name in methods:
                rows[name, classes] = _score_row(methods[name])
    return rows


_SCORES = ("JSC", "0-1", "MCC", "Prec.", "Rec.")


def _printed_scores(name: str) -> tuple[str, ...]:
    key = CLASSIFIERS.get(name) or f"network-{100 * NETWORKS[name]:.0f}"
    # One of the rows has its correlation to more digits than its accuracy.
    middle = ["correlation"] if key == "network-25" else []
    parts = ["confidence", *middle, "retrieval"]
    return tuple(text for part in parts for text in _formatted(f"{part}-{key}"))


def _formatted(claim: str) -> tuple[str, ...]:
    found = _claim(claim)
    return tuple(found.format(value).replace("-", "−") for value in _numbers(found))


def _score_row(own: Classifier) -> dict[str, str]:
    large = own.scores[_LARGE]
    columns = (large.accuracy, _losses(large), large.correlation, large.precision, large.recall)
    return {
        "rows": f"{own.rows:,}",
        **{title: with_range(values, _three) for title, values in zip(_SCORES, columns, strict=True)},
        "Jaccard": with_range(large.jaccard, _three),
        "JSC, 3 000 rows": with_range(own.scores[_SMALL].accuracy, _three),
    }


def estimation_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Table VII with ours beside the paper's, by method and targets; EVS and R² in both ways of counting.

    The network is a small one.
    """
    rows = {}
    for name in ("NN", *REGRESSORS):
        rows[name, _PAPERS] = {"rows": _NOTHING, **_printed_errors(name), **dict.fromkeys(_VARYING, _NOTHING)}
        for targets, methods in result.estimation.items():
            if name in methods:
                rows[name, targets] = _error_row(methods[name])
    return rows


_ERRORS = ("MAE", "MSE", "EVS", "R²")
_VARYING = ("EVS of what varies", "R² of what varies")


def _printed_errors(name: str) -> dict[str, str]:
    if name == "Gauss. Process":
        absolute, squared, determination = _formatted("estimation-gaussian-process")
        values = (absolute, squared, *_formatted("variance-gaussian-process"), determination)
    else:
        values = _formatted(f"estimation-{REGRESSORS.get(name, 'network')}")
    return dict(zip(_ERRORS, values, strict=True))


def _error_row(own: Regressor) -> dict[str, str]:
    every, varying = own.all_targets, own.varying
    columns = (every.absolute, every.squared, every.explained, every.determination)
    return {
        "rows": f"{own.rows:,}",
        **{title: with_range(values, _four) for title, values in zip(_ERRORS, columns, strict=True)},
        **{
            title: with_range(values, _four)
            for title, values in zip(_VARYING, (varying.explained, varying.determination), strict=True)
        },
    }


def growth_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Accuracy of the methods that do not get all rows, by method and number of rows, beside the paper's."""
    return {
        (name, f"{int(count):,}"): {"ours": _three(accuracy), _PAPERS: _printed_scores(name)[0]}
        for name, own in result.growth.items()
        for count, accuracy in own.items()
    }


def time_table(result: Result) -> dict[tuple[str, str], dict[str, str]]:
    """Set times of a row beside the paper's, by table and method; empty if none were taken."""
    tables = (
        ("confidence", CLASSIFIERS, result.confidence[_DRAWN]),
        ("estimation", REGRESSORS, result.estimation[_TOOL]),
    )
    return {
        (task, name): {
            "trained on": f"{methods[name].rows:,}",
            "median [µs]": f"{1e6 * time.median:.3g}",
            "quartiles [µs]": f"{1e6 * time.lower:.3g}–{1e6 * time.upper:.3g}",
            _PAPERS: _claim(f"time-{task}-{key}").printed,
        }
        for task, keys, methods in tables
        for name, key in keys.items()
        for time in methods[name].times
    }


def _three(value: float) -> str:
    return f"{value:.3f}".replace("-", "−")


def _four(value: float) -> str:
    return f"{value:.4f}".replace("-", "−")


# ---- verdicts --------------------------------------------------------------------------------------


def verdicts(result: Result) -> tuple[Verdict, ...]:
    """Judge the claims of the ledger that this study answers for; see above for how."""
    return (
        *_on_networks(result),
        *_on_orders(result),
        _on_jaccard(),
        *(verdict for name in CLASSIFIERS for verdict in _on_classifier(result, name)),
        *(verdict for name in REGRESSORS for verdict in _on_regressor(result, name)),
    )


def _on_networks(result: Result) -> tuple[Verdict, ...]:
    methods = {name: own.scores[_LARGE] for name, own in result.confidence[_DRAWN].items()}
    others = [methods[name] for name in CLASSIFIERS]
    leads = {
        name: min(
            min(methods[name].accuracy) - max(max(other.accuracy) for other in others),
            min(methods[name].correlation) - max(max(other.correlation) for other in others),
        )
        for name in NETWORKS
    }
    ahead = sum(lead > 0 for lead in leads.values())
    best = max(others, key=lambda other: max(other.accuracy))
    confident = (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.IN_SHAPE, Outcome.REPRODUCED)[ahead]
    network = result.estimation[_TOOL]["NN"].all_targets
    rivals = [result.estimation[_TOOL][name].all_targets for name in REGRESSORS]
    first = all(
        max(network.absolute) < min(own.absolute)
        and max(network.squared) < min(own.squared)
        and min(network.explained) > max(own.explained)
        and min(network.determination) > max(own.determination)
        for own in rivals
    )
    both = (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED)
    what = "A network of three small layers, on the paper's columns, in place of the paper's."
    return (
        _verdict(
            "more-accurate", both[(ahead == len(NETWORKS)) + first],
            f"accuracy {_three(min(methods['NN(.5)'].accuracy))}, R² {_three(network.determination[0])}",
            f"best of the others: {_three(max(best.accuracy))}, "
            f"{_three(max(max(own.determination) for own in rivals))}",
            what,
        ),
        _verdict(
            "networks-first-in-confidence", confident,
            ", ".join(_three(methods[name].accuracy[0]) for name in NETWORKS),
            f"best of the others over all seeds: {_three(max(best.accuracy))}",
            f"{what} {ahead} of three thresholds are ahead in both columns.",
        ),
        _verdict(
            "network-first-in-estimation", Outcome.of(first),
            ", ".join(_four(values[0]) for values in vars(network).values()),
            f"smallest MSE of the others: {_four(min(min(own.squared) for own in rivals))}",
            what,
        ),
    )  # fmt: skip


def _on_orders(result: Result) -> tuple[Verdict, ...]:
    accuracy = {
        name: float(np.median(result.confidence[_DRAWN][name].scores[_LARGE].accuracy))
        for name in CLASSIFIERS
    }
    order = sorted(CLASSIFIERS, key=lambda name: -accuracy[name])
    led = order[0] == "LightGBM"
    as_printed = order[:3] == ["LightGBM", "SVM(RBF)", "Random Forest"]
    linear = [accuracy[name] for name in ("SVM(Lin. L2)", "LogisticReg.", "RidgeReg.(0.5)")]
    alike, spread = max(linear) - min(linear) <= _ALIKE, max(linear) - min(linear)
    below = sorted(
        name for name in CLASSIFIERS if accuracy[name] < max(linear) and accuracy[name] not in linear
    )
    trees = result.estimation[_TOOL]["Decision Tree"].all_targets.determination
    others = [
        value
        for name in REGRESSORS
        if name != "Decision Tree"
        for value in result.estimation[_TOOL][name].all_targets.determination
    ]
    worst, futile = max(trees) < min(others), max(trees) < 0
    return (
        _verdict(
            "lightgbm-second",
            Outcome.REPRODUCED if as_printed else Outcome.IN_SHAPE if led else Outcome.NOT_REPRODUCED,
            ", ".join(f"{name} {_three(accuracy[name])}" for name in order[:3]),
            _on_rows(result, "SVM(RBF)"),
            "The SVM gets a part of the rows.",
        ),
        _verdict(
            "linear-models-alike",
            Outcome.REPRODUCED
            if alike and below == ["SVM(Sigmoid)"]
            else Outcome.IN_SHAPE if alike else Outcome.NOT_REPRODUCED,
            ", ".join(map(_three, linear)), f"{_three(spread)} apart",
            f"Worse than these: {', '.join(below) or 'none'}. What is in reach is no half space.",
        ),
        _verdict(
            "tree-worst-in-estimation",
            (Outcome.NOT_REPRODUCED, Outcome.IN_SHAPE, Outcome.REPRODUCED)[worst + futile],
            f"R² {_three(max(trees))}", f"lowest of the others: {_three(min(others))}",
            "It answers with a single row, whose own variance adds to that of the target.",
        ),
    )  # fmt: skip


_ALIKE = 0.01


def _on_jaccard() -> Verdict:
    """Tell from the printed numbers alone what JSC is."""
    told, implied = [], []
    for key in CLASSIFIERS.values():
        accuracy, loss, _ = _numbers(_claim(f"confidence-{key}"))
        precision, recall = _numbers(_claim(f"retrieval-{key}"))
        told.append(abs(accuracy + loss - 1))
        implied.append(accuracy - 1 / (1 / precision + 1 / recall - 1))
    return _verdict(
        "jaccard",
        Outcome.CONTRADICTED if max(told) < 0.0015 and min(implied) > 0.01 else Outcome.REPRODUCED,
        f"JSC and 0-1 loss add up to one within {_three(max(told))} in all rows",
        f"a coefficient by precision and recall is {_three(min(implied))} to {_three(max(implied))} less",
        "By the paper's own numbers JSC is the share of right answers.",
    )


_Columns: TypeAlias = Mapping[str, tuple[tuple[float, ...], ...]]
"""Numbers of each seed, for each printed number, by classes or targets."""


def _on_classifier(result: Result, name: str) -> tuple[Verdict, Verdict]:
    by_classes = {classes: methods[name].scores[_LARGE] for classes, methods in result.confidence.items()}
    scores: dict[str, _Columns] = {
        "confidence": {key: (own.accuracy, _losses(own), own.correlation) for key, own in by_classes.items()},
        "retrieval": {key: (own.precision, own.recall) for key, own in by_classes.items()},
    }
    first, second = (
        _on_scores(f"{part}-{CLASSIFIERS[name]}", own, _on_rows(result, name)) for part, own in scores.items()
    )
    return first, second


def _on_scores(claim_id: str, ours: _Columns, rows: str) -> Verdict:
    claim = _claim(claim_id)
    printed = _numbers(claim)
    variances = (
        [printed[0] * printed[1], printed[0] * printed[1], 1 - printed[2] ** 2]
        if len(printed) == 3
        else [2 * value * (1 - value) for value in printed]  # of about half of the rows
    )
    limits = [claim.rounding + 2 * math.sqrt(variance / _PRINTED_ROWS) for variance in variances]
    gaps = {
        key: [_gap(one, value) for one, value in zip(own, printed, strict=True)] for key, own in ours.items()
    }
    within = {
        key: all(gap <= limit for gap, limit in zip(own, limits, strict=True)) for key, own in gaps.items()
    }
    near = any(max(own) <= _NEAR_SCORE for own in gaps.values())
    return _verdict(
        claim_id, _outcome(within[_DRAWN], within[_EQUAL], near),
        _medians(ours[_DRAWN], claim), _spread(ours[_DRAWN], claim),
        f"{rows}. With equal classes: {_medians(ours[_EQUAL], claim)}.",
    )  # fmt: skip


_NEAR_SCORE = 0.05


def _on_regressor(result: Result, name: str) -> tuple[Verdict, ...]:
    by_targets = {targets: result.estimation[targets][name] for targets in (_TOOL, _BY_ITSELF)}
    key, rows = f"estimation-{REGRESSORS[name]}", f"{by_targets[_TOOL].rows:,} training rows"
    every = {targets: own.all_targets for targets, own in by_targets.items()}
    varying = by_targets[_TOOL].varying
    counted = f"{rows}. Over the targets that vary, R² is {_three(float(np.median(varying.determination)))}."
    errors = {targets: (own.absolute, own.squared) for targets, own in every.items()}
    if name != "Gauss. Process":
        scores = {targets: (own.explained, own.determination) for targets, own in every.items()}
        return (_on_errors(key, errors, scores, counted),)
    explained = {targets: (own.explained,) for targets, own in every.items()}
    determined = {targets: (own.determination,) for targets, own in every.items()}
    nothing: dict[str, tuple[tuple[float, ...], ...]] = dict.fromkeys(every, ())
    return (
        _on_errors(key, errors, determined, f"{counted} Rows are so far apart that it predicts zero."),
        _on_errors(
            "variance-gaussian-process", nothing, explained,
            f"{rows}. It is {_three(varying.explained[0])} over the targets that vary; a constant one has 1 "
            "or 0 by whether zero is predicted to the last digit.",
        ),
    )  # fmt: skip


def _on_errors(claim_id: str, errors: _Columns, scores: _Columns, sentence: str) -> Verdict:
    claim = _claim(claim_id)
    printed = _numbers(claim)
    count = len(errors[_TOOL])

    def within(targets: str, share: float, score: float) -> bool:
        limits = [share * value for value in printed[:count]] + [score] * (len(printed) - count)
        ours = errors[targets] + scores[targets]
        return all(
            _gap(own, value) <= limit + claim.rounding
            for own, value, limit in zip(ours, printed, limits, strict=True)
        )

    ours, alone = (errors[targets] + scores[targets] for targets in (_TOOL, _BY_ITSELF))
    near = any(within(targets, 0.1, 0.1) for targets in errors)
    return _verdict(
        claim_id, _outcome(within(_TOOL, 0.02, 0.01), within(_BY_ITSELF, 0.02, 0.01), near),
        _medians(ours, claim), _spread(ours, claim),
        f"{sentence} With a test set scaled by itself: {_medians(alone, claim)}.",
    )  # fmt: skip


def _outcome(as_chosen: bool, otherwise: bool, near: bool) -> Outcome:
    if as_chosen:
        return Outcome.REPRODUCED
    if otherwise:
        return Outcome.FITTED
    return Outcome.IN_SHAPE if near else Outcome.NOT_REPRODUCED


def _gap(ours: Sequence[float], printed: float) -> float:
    """How far a printed number is from the range of ours."""
    return max(min(ours) - printed, printed - max(ours), 0.0)


def _medians(ours: Sequence[Sequence[float]], claim: Claim) -> str:
    form = _four if claim.rounding < 1e-4 else _three
    return ", ".join(form(float(np.median(values))) for values in ours)


def _spread(ours: Sequence[Sequence[float]], claim: Claim) -> str:
    if len(ours[0]) == 1:
        return "one seed"
    form = _four if claim.rounding < 1e-4 else _three
    return (
        ", ".join(f"{form(min(values))} to {form(max(values))}" for values in ours)
        + f"; {len(ours[0])} seeds"
    )


def _on_rows(result: Result, name: str) -> str:
    rows = f"{result.confidence[_DRAWN][name].rows:,} training rows"
    fewer = list(result.growth.get(name, {}).items())[:-1]
    if not fewer:
        return rows
    return f"{rows}; accuracy with {', '.join(f'{int(count):,}: {_three(value)}' for count, value in fewer)}"


def _losses(own: Classification) -> tuple[float, ...]:
    return tuple(1 - value for value in own.accuracy)


@cache
def _claim(claim_id: str) -> Claim:
    return load_paper(_PAPER).claim(claim_id)


def _numbers(claim: Claim) -> tuple[float, ...]:
    if claim.value is None:
        raise ValueError(f"claim {claim.id} has no value")
    return claim.value if isinstance(claim.value, tuple) else (claim.value,)


def acceptance(result: Result) -> tuple[Acceptance, ...]:
    """Figures that must hold for the book to be built."""
    own = result.estimation[_TOOL]["RidgeReg."]
    count = CONSTANT_TARGETS["tool"]
    targets = count + _VARYING_TARGETS
    errors = [
        abs(all_targets - (_VARYING_TARGETS * varying + count) / targets)
        for all_targets, varying in zip(own.all_targets.determination, own.varying.determination, strict=True)
    ]
    return (Acceptance("R² of ridge regression by both ways of counting", max(errors), 1e-9),)


def _verdict(claim: str, outcome: Outcome, ours: str, spread: str, sentence: str) -> Verdict:
    return Verdict(_PAPER, claim, outcome, ours, spread, sentence)
