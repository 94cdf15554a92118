"""The study of the resistance of contacts reads, fits and refuses as it says."""

import numpy as np
import pytest

from studies import resistance
from tests.records.contact_signals import Case


def file_of(folder, lengths):
    """Openings of contacts whose separation is later by 1 ms for 0.75 mm."""
    lines, time = ["remaining_length_mm,time_ms,resistance_mohm"], np.arange(0.25, 50.0, 0.25)
    for length in lengths:
        separates = 30.0 + (length - 280.0) / 0.75
        values = np.minimum(0.5 * np.exp(np.maximum(time - separates + 3.0, 0.0)), 10.0)
        values = np.where(time < 14.0, 0.06, values)
        lines += [f"{length},{t},{r:.5f}" for t, r in zip(time, values, strict=True)]
    (folder / "a.csv").write_text("\n".join(lines))
    return folder / "a.csv"


def test_the_length_follows_from_the_times(tmp_path, capsys):
    file = file_of(tmp_path, [280.0, 282.0, 284.0, 286.0, 299.0])
    assert resistance.main([str(file)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 2 + 5 + 2
    assert "0.75" in printed[-1]
    assert "n = 4" in printed[-1]  # the last is too long for the record


@pytest.mark.parametrize("step", [0.05, 0.25, 0.5])
@pytest.mark.parametrize("cut", [5.0, 10.0])
def test_separations_of_a_resistance(step, cut):
    case = Case(np.random.default_rng(5), step=step, cut=cut, main=55.2, arcing=72.6)
    result = resistance.separations(case.time, case.resistance())
    assert result.main == pytest.approx(case.main, abs=4.0 * result.main_sd)
    assert result.arcing == pytest.approx(case.arcing, abs=4.0 * result.arcing_sd)
    seen = case.time < case.arcing - 1.5  # the record ends before
    short = resistance.separations(case.time[seen], case.resistance()[seen])
    assert np.isnan(short.arcing)
    assert short.why


def test_the_residual_sd_has_its_interval():
    rng = np.random.default_rng(1)
    between = np.linspace(10.0, 30.0, 16)
    _, residuals, (sd, low, high) = resistance.fit(
        280.0 + 0.7 * between + 0.2 * rng.standard_normal(16), between
    )
    assert residuals.size == 16
    assert low < sd < high
    assert 0.1 < sd < 0.35


def test_a_wrong_file_is_refused(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("time_ms,resistance_mohm\n1,2\n")
    with pytest.raises(ValueError, match="remaining_length_mm"):
        resistance.read(file)
    file.write_text("remaining_length_mm,time_ms,resistance_mohm\n1,2,x\n")
    with pytest.raises(ValueError, match="x"):
        resistance.read(file)
