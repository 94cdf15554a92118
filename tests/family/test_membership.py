"""Which family records belong to."""

from types import SimpleNamespace

import pytest

from breaker.family.membership import Match, choose_family


def family(name, closing, opening, evidence=0.0):
    """One in which records of each motion have p-values, and give evidence together."""
    return SimpleNamespace(name=name, closing=closing, opening=opening, evidence=evidence)


def matched(family):
    p_values = family.closing, family.closing / 10.0, family.closing, family.opening
    half = family.evidence / 2.0
    matches = [Match(p, {"start": 1.0 / p, "end": float("nan")}, None, half) for p in p_values]
    return list(zip(["closing"] * 3 + ["opening"], matches, strict=True))


@pytest.mark.parametrize(
    ("first", "second", "name", "fit"),
    [
        ((0.2, 0.1), (0.9, 0.9, 9.0), "first", True),  # no other one is looked at
        ((0.2, 1e-5), (0.01, 0.01), "second", True),
        ((0.2, 0.05), (0.9, 0.05, 2.0), "second", True),  # at the edge of the first: foreign to it
        ((0.2, 0.05), (0.9, 0.9, -2.0), "first", True),
        ((0.2, 0.05), (0.9, 5e-4, 9.0), "first", True),
        ((1e-4, 0.9), (1e-5, 0.9, 9.0), "first", False),
        ((1e-4, 1e-5), (1e-5, 1e-5), "first", False),
    ],
)
def test_the_family_of_most_evidence_counts_that_fits_every_motion_or_the_nearest(
    first, second, name, fit
):
    families = (family(*item) for item in (("first", *first), ("second", *second)))
    chosen, matches, fits = choose_family(families, matched, 1e-3)
    assert (chosen.name, fits) == (name, fit)
    assert len(matches) == 4
