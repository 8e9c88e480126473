"""Table 5 in GNU Octave: function files of an exact index and of networks, a script that times them, its answer.

Octave runs MATLAB's language in an interpreter. The exact index is the Jacobian as a function file of plain
expressions, followed by LU or by LAPACK's singular values. Networks are evaluated as plain matrix operations and
through `simulate`, a function of our own that does what a toolbox does beside the arithmetic: it checks its
arguments, wraps inputs into cells, and calls each step of each layer by its name. It is not the toolbox of MATLAB.

Source: Sotiropoulos & Aspragathos (2016), section 4.5 and Table 5.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from string import Template

import numpy as np
import sympy
from sympy import Expr, Symbol

from dexterity.networks.feed_forward import FeedForward
from dexterity.networks.folding import Bells, folded
from dexterity.networks.network import Network
from dexterity.networks.radial_basis import BIAS, RadialBasis
from dexterity.program import Program

Files = Mapping[str, str]
"""Texts of files by name."""

PROGRAM = "octave-cli"
PATIENCE = 3600.0
"""Seconds after which a script that has not ended is stopped."""

WAYS_OF_NETWORK = ("plain", "at_once", "simulated", "simulated_at_once")
"""How a network is evaluated: both as matrix operations and through `simulate`, one by one and all at once."""


@dataclass(frozen=True)
class OctaveWay:
    """A function of all configurations, by the name of its file.

    Attributes
    ----------
    weights
        Name of the function that returns its second argument; "" if it has none.
    every
        It is timed in one of so many runs, beginning with the first.
    """

    weights: str = ""
    every: int = 1


@dataclass(frozen=True)
class Answer:
    """Values of all configurations by one way, and the processor times [s] of its runs, each for all of them."""

    values: np.ndarray
    times: np.ndarray


# ---- files -----------------------------------------------------------------------------------------


def jacobian_files(index: str, joints: Sequence[Symbol], entries: Sequence[Expr]) -> dict[str, str]:
    """Return function files of an index by its Jacobian, entries (6n) by rows: written out, shared, and at once.

    A function of all configurations q (m, n) belongs to each: `exact_written` and `exact_shared` loop over one
    Jacobian after the other, `exact_at_once` loops over those that `jacobian_at_once` returned together.
    """
    steps, shared = sympy.cse(list(entries), symbols=sympy.numbered_symbols("x"))
    named = _assigned(steps)
    formula = _INDEX[index]
    files = {
        "jacobian_written": _function(
            "J = jacobian_written(q)", _arguments(joints), _matrix(entries, joints)
        ),
        "jacobian_shared": _function(
            "J = jacobian_shared(q)", [*_arguments(joints), *named], _matrix(shared, joints)
        ),
        "jacobian_at_once": _function(
            "J = jacobian_at_once(q)", [*_arguments(joints, rows=":"), *named], _pages(shared, joints)
        ),
        "index_of": _function("value = index_of(J)", [], formula),
    }
    for way in ("written", "shared"):
        files[f"exact_{way}"] = _loop(f"exact_{way}(q)", f"index_of(jacobian_{way}(q(i, :)))")
    files["exact_at_once"] = _loop(
        "exact_at_once(q)", "index_of(pages(:, :, i))", "pages = jacobian_at_once(q);"
    )
    return files


def closed_form_files(program: Program) -> dict[str, str]:
    """Return function files of w from a program for its square: one by one in a loop, and all at once."""
    (square,) = program.outputs
    numbers = {q: i for i, q in enumerate(program.inputs, 1)}
    arguments = [f"{q} = q(:, {numbers[q]});" for q in program.used_inputs]
    body = [*arguments, *_assigned(program.steps)]
    return {
        "closed_form": _function("value = closed_form(q)", body, [f"value = sqrt({_code(square)});"]),
        "exact_closed": _loop("exact_closed(q)", "closed_form(q(i, :))"),
        "exact_closed_at_once": _function(
            "values = exact_closed_at_once(q)", [], ["values = closed_form(q);"]
        ),
    }


def network_files(side: str, network: Network) -> dict[str, str]:
    """Return function files that evaluate a network of the printed kinds, and its weights as `weights_of_SIDE`.

    Raises
    ------
    TypeError
        If it is neither a feed-forward network of the paper nor a radial-basis network.
    """
    weights = folded(network)
    if isinstance(weights, Bells):
        plain = "p.output * exp(-sum((p.centres - (p.scale .* q(i, p.inputs)')') .^ 2, 2)) + p.bias"
        at_once = [
            "x = p.scale .* q(:, p.inputs)';",
            "apart = sum(p.centres .^ 2, 2) + sum(x .^ 2, 1) - 2 * p.centres * x;",
            "values = (p.output * exp(-apart) + p.bias)';",
        ]
        numbers = {
            "scale": weights.scale[:, None],
            "centres": weights.centres,
            "output": weights.output[None],
        }
        numbers["bias"] = np.atleast_2d(weights.output_bias)
    else:
        plain = "p.output * tanh(p.hidden * q(i, p.inputs)' + p.biases) + p.bias"
        at_once = ["values = (p.output * tanh(p.hidden * q(:, p.inputs)' + p.biases) + p.bias)';"]
        numbers = {
            "hidden": weights.hidden,
            "biases": weights.hidden_biases[:, None],
            "output": weights.output,
        }
        numbers["bias"] = weights.output_biases[:, None]
    assigned = [f"p.{name} = {_literal(array)};" for name, array in numbers.items()]
    inputs = _literal(np.array([network.inputs]) + 1)
    return {
        f"weights_of_{side}": _function(
            f"p = weights_of_{side}()", [f"p.inputs = {inputs};", *assigned], [f"p.net = {_layers(network)};"]
        ),
        f"{side}_plain": _loop(f"{side}_plain(q, p)", plain),
        f"{side}_at_once": _function(f"values = {side}_at_once(q, p)", [], at_once),
        f"{side}_simulated": _loop(f"{side}_simulated(q, p)", "simulate(p.net, q(i, p.inputs)')"),
        f"{side}_simulated_at_once": _function(
            f"values = {side}_simulated_at_once(q, p)", [], ["values = simulate(p.net, q(:, p.inputs)')';"]
        ),
    }


def script(ways: Mapping[str, OctaveWay], runs: int) -> str:
    """Return the script that evaluates each way once, then times all of them in turn, run after run.

    The time is that of the processor, since one run of the Jacobian written out is long enough for other programs to
    interrupt it, and one of a network is not.
    """
    listed = "".join(f'  "{name}", "{way.weights}", {way.every};\n' for name, way in ways.items())
    return _SCRIPT.substitute(ways=listed, runs=runs)


# ---- the run ---------------------------------------------------------------------------------------


def run(files: Files, ways: Mapping[str, OctaveWay], q: np.ndarray, runs: int) -> dict[str, Answer]:
    """Run the script on configurations q (m, n), on one thread, in a folder that is removed afterwards.

    Raises
    ------
    RuntimeError
        If there is no Octave, it fails, or it has not ended after an hour.
    ValueError
        If its answer is not that of these ways.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for title, text in {**_SIMULATE, **files, "times": script(ways, runs)}.items():
            (folder / f"{title}.m").write_text(text, encoding="utf-8")
        np.savetxt(folder / "q.txt", q, fmt="%.17g")
        answers = parsed(_octave("times.m", folder=folder))
    sizes = {name: (answer.values.size, answer.times.size) for name, answer in answers.items()}
    needed = {name: (len(q), -(-runs // way.every)) for name, way in ways.items()}
    if sizes != needed:
        raise ValueError(f"Octave answered with numbers of values and times {sizes}; {needed} are needed")
    return answers


def versions() -> dict[str, str]:
    """Return the versions of Octave, of its BLAS and of its LAPACK, as it names them."""
    names = ("GNU Octave", "BLAS of Octave", "LAPACK of Octave")
    told = _octave("--eval", 'printf("%s\\n", version(), version("-blas"), version("-lapack"))')
    return dict(zip(names, told.splitlines(), strict=True))


def parsed(text: str) -> dict[str, Answer]:
    """Read what the script printed: a line "values NAME …" and a line "times NAME …" for each way.

    Raises
    ------
    ValueError
        If a line is neither, or a way lacks one of its lines.
    """
    held: dict[str, dict[str, np.ndarray]] = {"values": {}, "times": {}}
    for line in text.splitlines():
        kind, _, rest = line.partition(" ")
        name, *numbers = rest.split()
        if kind not in held or name in held[kind]:
            raise ValueError(
                f"Octave printed {line[:80]!r}; one line of values and one of times a way are needed"
            )
        held[kind][name] = np.array(numbers, dtype=float)
    if held["values"].keys() != held["times"].keys():
        raise ValueError(
            f"Octave printed values of {list(held['values'])} and times of {list(held['times'])}"
        )
    return {name: Answer(values, held["times"][name]) for name, values in held["values"].items()}


def _octave(*arguments: str, folder: Path | None = None) -> str:
    command = [PROGRAM, "--no-gui", "--norc", "--quiet", *arguments]
    one_thread = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        ended = subprocess.run(  # noqa: S603
            command,
            cwd=folder,
            env={**os.environ, **one_thread},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise RuntimeError(f"{PROGRAM} did not run to its end: {error}") from error
    if ended.returncode != 0:
        raise RuntimeError(f"{PROGRAM} failed with status {ended.returncode}: {ended.stderr[-500:]}")
    return ended.stdout


# ---- texts -----------------------------------------------------------------------------------------


def _code(expression: Expr) -> str:
    # Element by element, so that the same text serves one configuration and a column of them.
    return str(sympy.octave_code(expression))


def _assigned(steps: Sequence[tuple[Symbol, Expr]]) -> list[str]:
    return [f"{name} = {_code(expression)};" for name, expression in steps]


def _arguments(joints: Sequence[Symbol], rows: str = "1") -> list[str]:
    return [f"{q} = q({rows}, {i});" for i, q in enumerate(joints, 1)]


def _matrix(entries: Sequence[Expr], joints: Sequence[Symbol]) -> list[str]:
    n = len(joints)
    by_row = [entries[i : i + n] for i in range(0, len(entries), n)]
    return ["J = [", *(f"  {', '.join(map(_code, row))};" for row in by_row), "];"]


def _pages(entries: Sequence[Expr], joints: Sequence[Symbol]) -> Iterator[str]:
    n = len(joints)
    yield f"J = zeros({len(entries) // n}, {n}, rows(q));"
    for place, entry in enumerate(entries):
        if entry != 0:
            yield f"J({place // n + 1}, {place % n + 1}, :) = {_code(entry)};"


def _function(head: str, *bodies: Sequence[str] | Iterator[str]) -> str:
    lines = [line for body in bodies for line in body]
    return "\n".join([f"function {head}", *(f"  {line}" for line in lines), "end", ""])


def _loop(head: str, value: str, before: str = "") -> str:
    preparing = [before] if before else []
    body = ["values = zeros(rows(q), 1);", "for i = 1:rows(q)", f"  values(i) = {value};", "end"]
    return _function(f"values = {head}", preparing, body)


def _literal(array: np.ndarray) -> str:
    return "[" + "; ".join(", ".join(f"{float(x):.17g}" for x in row) for row in array) + "]"


def _layers(network: Network) -> str:
    """Return a network as the structure that `simulate` takes, with its scaling apart from its weights."""
    own = {name: np.atleast_2d(tensor.numpy()) for name, tensor in network.state_dict().items()}
    if isinstance(network, FeedForward):
        scaling = own["input_centre"].T, own["input_half_range"].T
        rescaling = own["target_centre"].T, own["target_half_range"]
        hidden = "dot_product", own["hidden_weights"], own["hidden_biases"].T, "net_sum", "sigmoid"
        output = own["output_weights"], own["output_biases"].T
    elif isinstance(network, RadialBasis):
        scaling = np.zeros_like(own["input_scale"].T), 1 / own["input_scale"].T
        rescaling = np.zeros((1, 1)), np.ones((1, 1))
        widths = np.full((network.neurons, 1), BIAS / own["spread"].item())
        hidden = "distances", own["centres"], widths, "net_product", "bell"
        output = own["output_weights"], own["output_bias"]
    else:
        raise TypeError(f"network is a {type(network).__name__}; FeedForward or RadialBasis is needed")
    layers = [_layer(*hidden), _layer("dot_product", *output, "net_sum", "linear")]
    return (
        f'struct("size", {len(network.inputs)}, "input", {{{{{_scaling(*scaling)}}}}}, '
        f'"layers", {{{{{", ".join(layers)}}}}}, "output", {{{{{_scaling(*rescaling)}}}}})'
    )


def _scaling(centre: np.ndarray, half_range: np.ndarray) -> str:
    return f'struct("centre", {_literal(centre)}, "half_range", {_literal(half_range)})'


def _layer(weighting: str, weights: np.ndarray, biases: np.ndarray, netting: str, transfer: str) -> str:
    numbers = f'"weights", {_literal(weights)}, "biases", {_literal(biases)}'
    return f'struct("weighting", "{weighting}", {numbers}, "netting", "{netting}", "transfer", "{transfer}")'


_INDEX = {
    "w": ["value = sqrt(det(J * J'));"],
    "KCI": ["sigma = svd(J);", "value = sigma(end) / sigma(1);"],
}
"""Value of an index from its Jacobian; `det` works by LU, `svd` by LAPACK's dgesvd."""

_SCRIPT = Template("""\
1;
svd_driver("gesvd");
q = load("q.txt");
ways = {
$ways};
runs = $runs;
weights = cell(rows(ways), 1);
for k = 1:rows(ways)
  if isempty(ways{k, 2})
    weights{k} = {};
  else
    weights{k} = {feval(ways{k, 2})};
  end
  values = feval(ways{k, 1}, q, weights{k}{:});
  printf("values %s", ways{k, 1});
  printf(" %.17g", values);
  printf("\\n");
end
taken = NaN(runs, rows(ways));
for run = 1:runs
  for k = 1:rows(ways)
    if mod(run - 1, ways{k, 3}) == 0
      started = cputime();
      feval(ways{k, 1}, q, weights{k}{:});
      taken(run, k) = cputime() - started;
    end
  end
end
for k = 1:rows(ways)
  printf("times %s", ways{k, 1});
  printf(" %.9g", taken(1:ways{k, 3}:end, k));
  printf("\\n");
end
""")

_SIMULATE: Files = {
    "simulate": """\
function y = simulate(net, x)
  if ! isstruct(net) || ! all(isfield(net, {"size", "input", "layers", "output"}))
    error("simulate: net is no network");
  end
  alone = ! iscell(x);
  if alone
    x = {x};
  end
  y = cell(size(x));
  for t = 1:numel(x)
    given = x{t};
    if ! isnumeric(given) || ! isreal(given)
      error("simulate: inputs are not real numbers");
    end
    if rows(given) != net.size
      error("simulate: %d inputs are needed", net.size);
    end
    held = cell(1, numel(net.layers) + 1);
    held{1} = feval("scaled", given, net.input{1});
    for k = 1:numel(net.layers)
      layer = net.layers{k};
      if columns(layer.weights) != rows(held{k})
        error("simulate: layer %d does not fit", k);
      end
      parts = {feval(layer.weighting, layer.weights, held{k}), layer.biases};
      held{k + 1} = feval(layer.transfer, feval(layer.netting, parts{:}));
    end
    y{t} = feval("scaled_back", held{end}, net.output{1});
  end
  if alone
    y = y{1};
  end
end
""",
    "scaled": "function y = scaled(x, by)\n  y = (x - by.centre) ./ by.half_range;\nend\n",
    "scaled_back": "function y = scaled_back(x, by)\n  y = x .* by.half_range + by.centre;\nend\n",
    "dot_product": "function z = dot_product(w, x)\n  z = w * x;\nend\n",
    "distances": """\
function z = distances(w, x)
  z = zeros(rows(w), columns(x));
  if columns(x) < rows(w)
    for i = 1:columns(x)
      z(:, i) = sum((w' - x(:, i)) .^ 2, 1)';
    end
  else
    for i = 1:rows(w)
      z(i, :) = sum((x - w(i, :)') .^ 2, 1);
    end
  end
  z = sqrt(z);
end
""",
    "net_sum": "function n = net_sum(z, b)\n  n = z + b;\nend\n",
    "net_product": "function n = net_product(z, b)\n  n = z .* b;\nend\n",
    "sigmoid": "function a = sigmoid(n)\n  a = 2 ./ (1 + exp(-2 * n)) - 1;\nend\n",
    "bell": "function a = bell(n)\n  a = exp(-n .^ 2);\nend\n",
    "linear": "function a = linear(n)\n  a = n;\nend\n",
}
"""A network as a toolbox evaluates it: our own, with a function for each step and each of them called by its name."""
