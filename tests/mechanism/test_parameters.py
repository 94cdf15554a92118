"""Names, order and scale of what is inferred."""

from breaker.mechanism.parameters import (
    MOTIONS,
    NAMES,
    PARAMETERS,
    is_logarithmic,
    outputs,
    prior_sds,
)


def test_order_and_units():
    """The order is that of every array on disk: changing it is changing the format."""
    assert NAMES == ("mu", "k_a", "k_b", "gamma_a", "gamma_b", "f", "L")
    units = ("1", "1/ms²", "1/ms²", "1/ms", "1/ms", "mm/ms²", "mm")
    assert tuple(parameter.unit for parameter in PARAMETERS) == units
    assert MOTIONS == ("closing", "opening")


def test_scale_of_the_outputs(defaults):
    assert outputs(False) == PARAMETERS
    names = [output.name for output in outputs(True)]
    assert names == [*NAMES, "onset"]
    assert is_logarithmic(names).tolist() == [True] * 7 + [False]
    sds = prior_sds(names, defaults["prior"], defaults["sensor"]["onset_sd"])
    assert sds.tolist() == [0.20, 0.15, 0.20, 0.20, 0.40, 0.10, 0.05, 0.3]
    # By name, not by position.
    assert prior_sds(["L", "onset", "mu"], defaults["prior"], 0.3).tolist() == [0.05, 0.3, 0.20]
