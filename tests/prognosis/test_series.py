"""Records of a life: in common units, aligned over motions, and which of them are new."""

import numpy as np
import pytest
import xarray as xr

from breaker.prognosis.series import events_of, inspections_of, series_of

STEP, LENGTH = 0.2, 400
TIME = STEP * np.arange(LENGTH)


def curves(numbers, motion="closing", *, lost=()):
    """Records of one motion as ``read_curves`` returns them; the last samples are padding."""
    rng, one, accepted = np.random.default_rng(1), np.ones(len(numbers)), ~np.isin(numbers, lost)
    way = np.clip((TIME - 20.0) / 10.0, 0.0, 1.0)
    record = 14.0 * way**2 * (3.0 - 2.0 * way) * (1.0 if motion == "closing" else -1.0)
    record = record + 0.02 * rng.standard_normal((len(numbers), LENGTH))
    record[:, -5:] = record[~accepted] = np.nan
    columns = {"accepted": accepted, "rate": one / STEP, "record_noise": 0.02 * one}
    data = {name: ("operation", item) for name, item in columns.items()}
    data |= {"record": (("operation", "sample"), record), "record_colour": ("operation", 0.0 * one)}
    for name, share in {"measured": [1.0, 2.0], "measured_sd": [0.1, 0.2]}.items():
        data[name] = ("operation", "quantity"), np.outer(numbers, share)
    return xr.Dataset(data, {"operation": numbers, "quantity": ["stroke", "travel_time"]})


def series(data=None, events=(), conditions=()):
    both = {
        "closing": curves(np.arange(1, 41), lost=[3]),
        "opening": curves(np.arange(2, 43), "opening"),
    }
    return series_of(data or both, [("closing", "travel_time")], dict(events), dict(conditions))


def test_motions_are_aligned_over_all_operations_in_the_units_of_the_new_records():
    result = series()
    closing, opening = result.motions["closing"], result.motions["opening"]
    assert result.operations.tolist() == list(range(1, 43))
    assert closing.there.tolist() == [o <= 40 and o != 3 for o in result.operations]
    assert opening.there.tolist() == [o >= 2 for o in result.operations]
    assert closing.measured["travel_time"][9] == 20.0
    assert closing.stated["travel_time"][9] == pytest.approx(2.0)
    assert closing.stroke == pytest.approx(14.0, abs=0.02)
    assert closing.way[closing.there][:, -10:].mean() == pytest.approx(1.0, abs=1e-3)
    assert np.nanmedian(closing.noise) == pytest.approx(0.02 / 14.0, rel=0.35)


def test_new_are_the_first_50_with_all_motions_under_monitoring():
    result = series()
    assert result.inspections is None
    assert result.operations[result.new].tolist() == [2, *range(4, 41)]
    assert series({"closing": curves(np.arange(1, 80))}).new.tolist() == list(range(50))
    with pytest.raises(ValueError, match="first inspection"):
        series({"closing": curves(np.arange(1, 4), lost=[1, 2, 3])})


@pytest.mark.parametrize("dated", [False, True])
def test_new_is_the_first_inspection(dated):
    """By numbers, or by dates where the counter hardly moves."""
    data = curves(np.arange(1, 9) if dated else np.array([1, 2, 201, 202, 401, 402, 601, 602]))
    if dated:
        data["date"] = "operation", [f"{2000 + k // 2}-05-01" for k in range(8)]
    result = series({"closing": data})
    assert result.new.tolist() == [0, 1]
    assert result.inspections.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    means, count = result.gathered(np.arange(8.0)[:, None])
    assert count == 2.0
    assert means[1::2, 0].tolist() == [0.5, 2.5, 4.5, 6.5]
    assert np.isnan(means[::2]).all()


def test_events_end_an_inspection_and_what_is_new_after_them():
    texts = {1: "transducer remounted", 2: "greased, transducer remounted", 3: "oil changed"}
    assert events_of(texts, {"oil changed": ["gamma_a"]}) == {1: False, 2: True, 3: True}
    with pytest.raises(ValueError, match="oil changed"):
        events_of(texts, {})
    assert inspections_of(np.array([1, 2, 201, 202]), None, [3]).tolist() == [0, 0, 1, 2]
    result = series(events=events_of({30: "greased", 6: "inspected"}, {}))
    assert result.operations[result.new].tolist() == [2, *range(4, 30)]
    assert result.events == {29: True}


def test_conditions_are_relative_to_those_of_new_operations():
    """Voltages in volts or in percent, whatever the rated one."""
    for rated in (100.0, 110.0):
        volts = dict.fromkeys(range(1, 43), rated) | {42: 0.85 * rated}
        warm = dict.fromkeys(range(1, 42), 20.0)
        conditions = {"voltage": volts, "temperature": warm | {41: 35.0}, "none": {}}
        voltage, temperature = series(conditions=conditions).conditions
        assert voltage[-1] == pytest.approx(-1.5)
        assert temperature[-2:].tolist() == pytest.approx([1.5, 0.0])  # one is not known
