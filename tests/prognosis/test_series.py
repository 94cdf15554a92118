"""Records of a life: in common units, aligned over motions, and which of them are new."""

import numpy as np
import pytest
import xarray as xr

from breaker.prognosis.series import events_of, inspections_of, series_of

STEP, LENGTH = 0.2, 400
TIME = STEP * np.arange(LENGTH)


def curves(numbers, motion="closing", *, stroke=14.0, lost=()):
    """Records of one motion as ``read_curves`` returns them; the last samples are padding."""
    rng = np.random.default_rng(len(numbers))
    sign = 1.0 if motion == "closing" else -1.0
    way = np.clip((TIME - 20.0) / 10.0, 0.0, 1.0)
    record = sign * stroke * way**2 * (3.0 - 2.0 * way)
    record = record + 0.02 * rng.standard_normal((len(numbers), LENGTH))
    record[:, -5:] = np.nan
    accepted = ~np.isin(numbers, lost)
    one = np.ones(len(numbers))
    return xr.Dataset(
        {
            "record": (("operation", "sample"), np.where(accepted[:, None], record, np.nan)),
            "accepted": ("operation", accepted),
            "rate": ("operation", one / STEP),
            "record_noise": ("operation", 0.02 * one),
            "record_colour": ("operation", 0.0 * one),
            "measured": (("operation", "quantity"), np.outer(numbers, [1.0, 2.0])),
            "measured_sd": (("operation", "quantity"), np.outer(numbers, [0.1, 0.2])),
        },
        {"operation": numbers, "quantity": ["stroke", "travel_time"]},
    )


def series(**about):
    data = {
        "closing": curves(np.arange(1, 41), lost=[3]),
        "opening": curves(np.arange(2, 43), "opening"),
    }
    about = {"events": {}, "conditions": {}} | about
    return series_of(data, followed={"closing": ["travel_time"]}, **about)


def test_motions_are_aligned_over_all_operations():
    found = series()
    closing, opening = found.motions["closing"], found.motions["opening"]
    assert found.operations.tolist() == list(range(1, 43))
    assert closing.there.tolist() == [o <= 40 and o != 3 for o in found.operations]
    assert opening.there.tolist() == [o >= 2 for o in found.operations]
    assert closing.measured["travel_time"][9] == 20.0
    assert closing.stated["travel_time"][9] == pytest.approx(2.0)
    assert not opening.measured


def test_shapes_are_in_the_units_of_the_new_records():
    closing = series().motions["closing"]
    assert closing.stroke == pytest.approx(14.0, abs=0.02)
    last = closing.way[closing.there][:, -10:].mean()
    assert last == pytest.approx(1.0, abs=1e-3)
    assert np.nanmedian(closing.noise) == pytest.approx(0.02 / 14.0, rel=0.35)
    assert np.isnan(closing.noise[2])


def test_new_are_the_first_50_with_all_motions_under_monitoring():
    found = series()
    assert found.inspections is None
    assert found.operations[found.new].tolist() == [2, *range(4, 41)]
    many = series_of({"closing": curves(np.arange(1, 80))}, followed={}, events={}, conditions={})
    assert many.new.tolist() == list(range(50))
    none = {"closing": curves(np.arange(1, 4), lost=[1, 2, 3])}
    with pytest.raises(ValueError, match="first inspection"):
        series_of(none, followed={}, events={}, conditions={})


@pytest.mark.parametrize("dated", [False, True])
def test_new_is_the_first_inspection(dated):
    """By numbers, or by dates where the counter hardly moves."""
    numbers = np.arange(1, 9) if dated else np.array([1, 2, 201, 202, 401, 402, 601, 602])
    data = curves(numbers)
    if dated:
        data["date"] = "operation", [f"{2000 + k // 2}-05-01" for k in range(8)]
    found = series_of({"closing": data}, followed={}, events={}, conditions={})
    assert found.new.tolist() == [0, 1]
    assert found.inspections.tolist() == [0, 0, 1, 1, 2, 2, 3, 3]
    means, count = found.gathered(np.arange(8.0)[:, None])
    assert count == 2.0
    assert means[1::2, 0].tolist() == [0.5, 2.5, 4.5, 6.5]
    assert np.isnan(means[::2]).all()


def test_maintenance_ends_an_inspection():
    found = inspections_of(np.array([1, 2, 201, 202]), None, events_of({3: "greased"}))
    assert found.tolist() == [0, 0, 1, 2]


def test_work_between_ends_what_is_new():
    found = series(events=events_of({30: "greased", 6: "inspected"}))
    assert found.operations[found.new].tolist() == [2, *range(4, 30)]
    assert found.events[29].renews
    assert not found.events[5].renews


def test_conditions_are_relative_to_those_of_new_operations():
    """Voltages in volts or in percent, whatever the rated one."""
    for rated in (100.0, 110.0):
        volts = dict.fromkeys(range(1, 43), rated) | {42: 0.85 * rated}
        warm = dict.fromkeys(range(1, 42), 20.0)
        conditions = {"voltage": volts, "temperature": warm | {41: 35.0}, "none": {}}
        voltage, temperature = series(conditions=conditions).conditions
        assert voltage[-1] == pytest.approx(-1.5)
        assert temperature[-2:].tolist() == pytest.approx([1.5, 0.0])  # one is not known


def test_events_mean_what_they_start_anew():
    texts = {1: "transducer remounted", 2: "greased, transducer remounted", 3: "oil changed"}
    found = events_of(texts, {"oil changed": ["gamma_a"]})
    assert [each.renews for each in found.values()] == [True, True, True]
    assert [each.transducer for each in found.values()] == [True, False, False]
    with pytest.raises(ValueError, match="oil changed"):
        events_of(texts)
