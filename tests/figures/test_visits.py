"""The page of two visits: measured first, a row for everything, and its words."""

import pytest

from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.explanations import Explanation
from breaker.diagnosis.inspection_change import InspectionChange
from breaker.figures.reports import visits
from tests.figures.drawn import assert_drawn, written


def row(name, change, changed, motion="", **more):
    about = {"name": name, "unit": "mm", "meaning": "a quantity", "motion": motion}
    about |= {"p_unchanged": 0.4, "p_worse": None, "changed": changed}
    about |= {"change": change, "if_changed": change}
    return QuantityChange(**about | more)


def drawn(inferred):
    return visits(
        InspectionChange(
            state="estimated" if inferred else "beyond_wear",
            family="medium_voltage",
            matches={"closing": {v: {"p_value": 0.5} for v in ("before", "today")}},
            agreement={"p_value": 1.0, "parameter": ""},
            settings={"seed": 1, "misfit_p_value": 0.02},
            records={"closing": {"before": 1, "today": 2}},
            rejected=(),
            differences=(),
            explanations=[Explanation("none", "", 1.0, [0.0] * 3)],
            measured=[row("stroke", [1.0, 1.5, 2.0], False, "closing", before=100.0, today=101.5)],
            inferred=inferred,
            limits=(),
            doubts=["a $f$ in a name"],
        )
    )


@pytest.mark.parametrize("estimated", [True, False])
def test_two_inspections_are_drawn(estimated):
    """Measured rows come first; a change beyond the axis is pointed to."""
    inferred = [
        row("f", [-12.0, -10.0, -8.0], True, p_worse=0.9),
        row("L", [-90.0, -70.0, -60.0], True, p_worse=0.0),
        row("mu", [0.0, 0.0, 0.0], False, identifiable=False),
    ]
    figure = drawn(inferred if estimated else [])
    assert_drawn(figure)
    assert "a \\$f\\$ in a name" in written(figure.subfigs[0])[0]
    labels = [text.get_text() for text in figure.subfigs[1].axes[0].get_yticklabels()]
    assert len(labels) == (4 if estimated else 2)
