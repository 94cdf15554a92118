"""The figure of exactness: shares, gap, rounds and examples, and curves that say nothing."""

import numpy as np
import pytest

from breaker.figures.exactness import exactness
from breaker.paper import validation as comparison
from breaker.paper.validation import summary
from tests.figures.drawn import assert_drawn
from tests.validation.made import CURVES, JUDGED, NAMES, judgement, posteriors


def usual(names=NAMES, curves=CURVES, judged=JUDGED):
    amortised, corrected = posteriors(names, curves)
    return judgement(corrected, judged), amortised, corrected


def resolved(tenths):
    judged, amortised, corrected = usual(NAMES[:2])
    corrected["resolved"] = ("curve", np.arange(CURVES) % 10 < tenths)
    judged = judgement(corrected)
    if not tenths:
        judged["resolved"] = ("curve", np.arange(JUDGED) < 2)  # a mean needs some
    return judged, amortised, corrected


def faulty():
    """The paper's own setting, few curves, weights that say nothing, infinite ones."""
    judged, amortised, corrected = usual(NAMES[:7], 10, 10)
    corrected.draws[1] = np.nan
    corrected.resolved[1] = False
    for name in ("efficiency", "pareto_k"):
        corrected[name][1] = np.nan
    judged = judgement(corrected, 10)
    for name in ("efficiency", "pareto_k", "divergence"):
        judged[name][4] = np.nan
    judged.pareto_k[5], judged.divergence[6] = np.inf, np.inf
    return judged, amortised, corrected


def no_example():
    found = usual(NAMES[:2])
    found[2].draws[:] = np.nan
    return found


CASES = {
    "usual": usual,
    "some resolved": lambda: resolved(3),
    "none resolved": lambda: resolved(0),
    "faulty": faulty,
    "no example": no_example,
}


@pytest.mark.parametrize("case", CASES)
def test_exactness_is_drawn(case):
    judged, amortised, corrected = CASES[case]()
    examples = comparison.examples(judged, amortised, corrected)
    row = summary(judged, corrected).iloc[0]
    figure = exactness(judged, corrected, examples, row, motion="opening")
    assert_drawn(figure)
