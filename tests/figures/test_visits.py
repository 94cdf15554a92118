"""The page of two visits: measured first, a row for everything, and its words."""

import pytest

from breaker.diagnosis.changes import QuantityChange
from breaker.diagnosis.inspection_change import (
    Agreement,
    ComparisonSettings,
    InspectionChange,
    VisitMatch,
)
from breaker.figures.reports import visits
from tests.figures.drawn import assert_drawn, written


def row(name, change, verdict, kind="parameter", motion="", **more):
    about = {"name": name, "unit": "mm", "meaning": f"a {kind}", "motion": motion, "kind": kind}
    about |= {"verdict": verdict, "change": change, "unchanged": 0.4, "beyond": 0.3, "worse": None}
    about |= {"more": 0.1, "less": 0.2, "if_changed": change}
    if kind == "measured":
        about |= {"before": 100.0, "today": 101.5, "unchanged": None}
    return QuantityChange(**about | more)


def drawn(parameters="told"):
    measured = [row("stroke", [1.0, 1.5, 2.0], "did not change", "measured", "closing")]
    inferred = [
        row("f", [-12.0, -10.0, -8.0], "changed", worse=0.9),
        row("mu", [-2.0, 0.0, 2.0], "not told"),
        row("touch_after_release", [-90.0, -70.0, -60.0], "changed", "time", "closing"),
    ]
    return visits(
        InspectionChange(
            parameters=parameters,
            family="medium_voltage",
            matches={"closing": {v: VisitMatch(0.5, {"start": 1.0}) for v in ("before", "today")}},
            agreement=Agreement(1.0, ""),
            settings=ComparisonSettings(0.05, 1, 0.02),
            records={"closing": {"before": 1, "today": 2}},
            rejected=(),
            differences=(),
            explanations=(),
            changes=measured + (inferred if parameters == "told" else []),
            mechanisms=(),
            limits=(),
            doubts=["a $f$ in a name"],
        )
    )


@pytest.mark.parametrize("parameters", ["told", "withheld"])
def test_two_visits_are_drawn(parameters):
    """Measured rows first; a change beyond the axis is pointed to."""
    figure = drawn(parameters)
    assert_drawn(figure)
    said = written(figure.subfigs[0])
    assert "WARNING: a \\$f\\$ in a name\nMeasured: no change" in said[0]
