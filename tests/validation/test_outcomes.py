"""What titles state of a check, from numbers known by hand."""

from types import SimpleNamespace

import numpy as np

from breaker.paper.validation.diagnostics import contraction_words, pairs_words, recovery_words


def test_shares_inside_intervals_are_stated_from_the_least_to_the_largest():
    found = SimpleNamespace(covered_50=np.array([0.48, 0.52]), covered_95=np.array([0.951, 0.953]))
    told = "95 % intervals contain 95 % of the true values, 50 % intervals 48 to 52 %"
    assert recovery_words(found) == told


def test_contraction_names_best_and_least_known():
    found = SimpleNamespace(mean_contraction=np.array([0.4, 0.95]), z_sd=np.array([0.98, 1.0]))
    told = contraction_words(found, ["L", "f"], np.array([0.43, 0.9]))
    assert told.startswith("best known: f (0.95), least: L (0.40); at most 0.03 below the limit; ")
    assert told.endswith("; z-score sd 0.98 to 1.00")
    assert "; not below the limit" in contraction_words(found, ["L", "f"], np.array([0.4, 0.9]))
    assert "limit" not in contraction_words(found, ["L", "f"])
    one = SimpleNamespace(mean_contraction=np.array([0.4]), z_sd=np.array([0.98]))
    assert contraction_words(one, ["L"]).startswith("best known: L (0.40); z-score sd")


def test_the_closest_pair_is_never_one_output_with_itself():
    strength = np.array([[1.0, 0.2, -0.3], [0.2, 1.0, 0.1], [-0.3, 0.1, 1.0]])
    draws = np.linspace(0.0, 1.0, 101)[:, None] * np.ones(3)
    told = pairs_words(draws, np.array([0.5, 0.97, 0.99]), strength, ["a", "b", "c"])
    assert told == "95 % intervals contain 2 of 3 true values; closest pair: a and c (−0.30)"
    alone = pairs_words(draws[:, :1], np.array([0.5]), strength[:1, :1], ["a"])
    assert alone == "95 % intervals contain 1 of 1 true values"
