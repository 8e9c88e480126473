"""How fast the data of paper C are drawn, on one core."""

from dexterity.networks.threads import one_thread
from dexterity.timing import Way, measure
from dexterity.workspace import dataset

LABELS = 400_000
JACOBIANS = 20_000


def test_a_million_labels_and_ten_thousand_jacobians_in_a_second():
    with one_thread():
        labels, jacobians = measure(
            [
                Way("labels", lambda: dataset.confidence_data(LABELS, 0), LABELS),
                Way("Jacobians", lambda: dataset.jacobian_data(JACOBIANS, 0), JACOBIANS),
            ]
        )
    print(f"{1 / labels.median:,.0f} labels and {1 / jacobians.median:,.0f} Jacobians a second")
    assert 1 / labels.median > 1e6
    assert 1 / jacobians.median > 1e4
