"""The study of the resistance of contacts reads and fits as it says."""

import numpy as np
import pytest

from studies import resistance
from tests.records.contact_signals import Case


def test_the_length_follows_from_the_times(tmp_path):
    """Openings of contacts whose separation is later by 1 ms for 0.75 mm; the last is too late."""
    lines, time = ["remaining_length_mm,time_ms,resistance_mohm"], np.arange(0.25, 50.0, 0.25)
    for length in (280.0, 282.0, 284.0, 286.0, 299.0):
        separates = 30.0 + (length - 280.0) / 0.75
        values = np.minimum(0.5 * np.exp(np.maximum(time - separates + 3.0, 0.0)), 10.0)
        values = np.where(time < 14.0, 0.06, values)
        lines += [f"{length},{t},{r:.5f}" for t, r in zip(time, values, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    openings = resistance.read(tmp_path / "a.csv")
    rows = resistance.table({mm: resistance.separations(*pair) for mm, pair in openings.items()})
    assert rows.attrs["n"] == 4
    assert rows.attrs["slope, mm/ms"] == pytest.approx(0.75, rel=0.05)
    assert rows["not seen because"].astype(bool).tolist() == [False] * 4 + [True]


@pytest.mark.parametrize(("step", "cut"), [(0.05, 5.0), (0.25, 10.0), (0.5, 5.0)])
def test_separations_of_a_resistance(step, cut):
    case = Case(np.random.default_rng(5), step=step, cut=cut, main=55.2, arcing=72.6)
    result = resistance.separations(case.time, case.resistance())
    assert result.main == pytest.approx(case.main, abs=4.0 * result.main_sd)
    assert result.arcing == pytest.approx(case.arcing, abs=4.0 * result.arcing_sd)
    seen = case.time < case.arcing - 1.5  # the record ends before
    assert resistance.separations(case.time[seen], case.resistance()[seen]).why
