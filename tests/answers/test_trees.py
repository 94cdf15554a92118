"""Draws as a tree, and the table."""

import numpy as np
import pytest

from breaker.answers.rows import table_of
from breaker.answers.trees import tree


def test_a_tree_has_the_records_with_a_posterior(answers, models):
    found = tree(answers, models, seed=1)
    posterior = found["posterior"]
    assert posterior.motion.values.tolist() == ["closing"] * 2 + ["opening"] * 2
    assert posterior.record.values.tolist() == [0, 1, 2, 3]
    assert posterior.phase.values.tolist() == ["L1"] * 4
    draws = answers["opening"].draws.sel(output="L")[1]
    assert np.array_equal(posterior["L"].sel(chain=0, record=3), draws)
    assert posterior["L"].attrs["unit"] == "mm"
    assert np.isfinite(found["sample_stats/lp"]).all()
    assert found["prior/mu"].shape == (1, draws.size)


def test_predictions_are_of_their_records(answers, models):
    """Of 151 samples of each record some 95 % lie in the band; below 80 % once in 1e6."""
    found = tree(answers, models, seed=1)
    low, high = found["posterior_predictive/travel"].quantile([0.025, 0.975], ("chain", "draw"))
    observed = found["observed_data/travel"]
    assert (((low <= observed) & (observed <= high)).mean("time") > 0.8).all()


def test_there_is_no_tree_of_nothing(answers, models):
    with pytest.raises(ValueError, match="no record has a posterior"):
        tree({"closing": answers["closing"].isel(operation=[2])}, models, seed=1)


def test_a_table_has_a_row_for_each_parameter_and_quantity(answers):
    rows = table_of(answers)
    counts = rows.groupby(["motion", "operation"]).size()
    assert counts.tolist() == [8 + 6] * 6
    one = rows[(rows.motion == "closing") & (rows.operation == 1)].set_index("output")
    assert one.loc["touch_time", "kind"] == "quantity"
    assert one.loc["touch_time", "unit"] == "ms"
    assert (one.verdict == "not healthy").all()
    assert (one.exceeded_slow == 1.0).all()
    assert (one.phase == "L1").all()
    assert rows[rows.operation == 3]["median"].isna().all()
