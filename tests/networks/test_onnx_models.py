"""ONNX models: both precisions, batches of any size, and no digit lost where eigenvalues meet."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from dexterity.networks import onnx_models
from dexterity.networks.rounding import rounding
from example_networks import JOINTS, examples, feed_forward, random_configurations

onnx = pytest.importorskip("onnx")
runtime = pytest.importorskip("onnxruntime")
NETWORKS = examples()


def session(model):
    return runtime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])


@pytest.mark.parametrize("rows", [0, 1, 1000])
@pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)
def test_batches_of_any_size_agree_with_the_network(rng, network, rows):
    """onnxruntime#2874 (an operator missing in double), pytorch#157621 (a frozen batch), mmpretrain#1273."""
    q = random_configurations(rng, rows)
    (values,) = session(onnx_models.onnx_model(network)).run(None, {"q": q.numpy()})
    assert values.shape == (rows,)
    np.testing.assert_allclose(values, network(q).detach().numpy(), rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)
def test_the_single_precision_form_takes_and_returns_single_precision(rng, network):
    """Case 15 of the library review: a float32 feed was refused."""
    q = random_configurations(rng, 500)
    (values,) = session(onnx_models.onnx_model(network, "float")).run(None, {"q": q.float().numpy()})
    assert values.dtype == np.float32
    bound = 20 * rounding(network, q).amplification * np.finfo(np.float32).eps
    np.testing.assert_allclose(values, network(q).detach().numpy(), rtol=bound)


def test_a_model_of_one_precision_refuses_the_other(rng):
    """onnxruntime#2874: nothing is rounded in silence; the error says which type is expected."""
    network, q = next(iter(NETWORKS.values())), random_configurations(rng, 3)
    for precision, rows in (("double", q.float()), ("float", q)):
        with pytest.raises(Exception, match=r"(?i)unexpected input data type"):
            session(onnx_models.onnx_model(network, precision)).run(None, {"q": rows.numpy()})


def eigenvalue_session(dtype):
    """Smallest eigenvalue by itself: a model of six columns."""
    graph = onnx_models._Graph(onnx, dtype)
    graph.add("Identity", onnx_models._smallest_eigenvalue(graph, graph.columns("u", 6)), name="value")
    kind = onnx.helper.np_dtype_to_tensor_dtype(np.dtype(dtype))
    ends = [
        onnx.helper.make_tensor_value_info(name, kind, ["N", width])
        for name, width in (("u", 6), ("value", 1))
    ]
    model = onnx.helper.make_model(
        onnx.helper.make_graph(graph.nodes, "eigenvalue", ends[:1], ends[1:], graph.constants),
        opset_imports=[onnx.helper.make_opsetid("", onnx_models.OPSET)],
        ir_version=onnx_models.IR_VERSION,
    )
    return session(model)


@pytest.fixture(scope="module")
def eigenvalue():
    return eigenvalue_session(np.float64)


@pytest.mark.parametrize("gap", [1.0, 1e-4, 1e-8, 1e-12, 0.0])
@pytest.mark.parametrize("meeting", ["smallest two", "largest two", "all three"])
def test_the_smallest_eigenvalue_keeps_its_digits_where_eigenvalues_meet(rng, eigenvalue, gap, meeting):
    rotations = np.linalg.qr(rng.normal(size=(3000, 3, 3)))[0]
    first, second, third = rng.uniform(1, 2, (3, 3000))
    values = {
        "smallest two": [-first, -first + gap * second, third],
        "largest two": [-first, second, second + gap * third],
        "all three": [first, first + gap * second, first + gap * third],
    }[meeting]
    matrices = np.einsum("nij,jn,nkj->nik", rotations, np.array(values), rotations)
    u = np.stack([matrices[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))], axis=1)
    (found,) = eigenvalue.run(None, {"u": u})
    np.testing.assert_allclose(found[:, 0], np.linalg.eigvalsh(matrices)[:, 0], rtol=0, atol=1e-14)


@given(st.lists(st.sampled_from([0.0, 1.0, -1.0, 0.5, 1e-160, 1e-9, 3.0, 1e6]), min_size=6, max_size=6))
@settings(max_examples=200, deadline=None)
def test_matrices_of_whole_and_tiny_numbers(eigenvalue, u):
    (found,) = eigenvalue.run(None, {"u": np.array([u])})
    a, b, c, d, e, f = u
    exact = np.linalg.eigvalsh([[a, d, e], [d, b, f], [e, f, c]])[0]
    np.testing.assert_allclose(found[0, 0], exact, rtol=0, atol=1e-14 * max(1e-140, *map(abs, u)))


def test_a_triple_costs_no_loop(rng):
    """Point 6b.3 of the engineer's trial: 506 operators, 11 µs a row; sweeps of rotations over columns."""
    model = onnx_models.onnx_model(feed_forward(rng, "triple"))
    assert len(model.graph.node) < 200


def test_an_unknown_precision_is_refused(rng, annotations_unchecked):
    with pytest.raises(ValueError, match=r"^precision is 'half'"):
        onnx_models.onnx_model(feed_forward(rng, "cone"), "half")


def test_answers_are_those_of_the_network_far_outside(rng):
    """Large inputs saturate every neuron; neither form may turn that into NaN."""
    q = 1e6 * random_configurations(rng, 200)
    for name, network in NETWORKS.items():
        if "radial" in name or "origin" in name:
            continue
        (values,) = session(onnx_models.onnx_model(network)).run(None, {"q": q.numpy()})
        torch.testing.assert_close(torch.from_numpy(values), network(q).detach(), rtol=1e-9, atol=0, msg=name)
    assert q.shape == (200, JOINTS)
