"""`breaker compare`: what it prints and draws, and where it fails."""

import json

import pytest

from breaker.cli import main
from tests.cli.conftest import written

BOTH = ("closing", "opening")


@pytest.fixture
def inspections(folder, prior):
    """Two inspections of the reference drive, whose force has fallen by 15 %."""
    weaker = type(prior)(prior.medians * [1, 1, 1, 1, 1, 0.85, 1], prior.log_sds)
    for name, drive in (("then", prior), ("now", weaker)):
        (folder / name).mkdir()
        written(folder / name / f"{name}.csv", drive, *BOTH)
    return folder


def call(*arguments):
    return main(["compare", *arguments])


def compared(capsys, *arguments):
    """The document of a comparison."""
    assert call(*arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


def write_tables(folder, columns, *rows, **more):
    """Write a table into the folder of both inspections, of columns beyond the usual ones.

    ``{}`` in a row is the name of the inspection.
    """
    for name in ("then", "now"):
        lines = [row.format(name) for row in more.get(name, rows)]
        table = "\n".join([f"file,motion,operation,{columns}", *lines])
        (folder / name / "operations.csv").write_text(table)


def test_a_weaker_force_is_measured_noticed_and_drawn(inspections, capsys):
    result = compared(capsys, "then", "--today", "now", "--plot", "both.png")
    assert result["records"] == {motion: {"before": 1, "today": 1} for motion in BOTH}
    assert (result["family"], result["state"]) == ("medium_voltage", "estimated")
    rows = {(row["name"], row["motion"]): row for row in result["measured"] + result["inferred"]}
    for name in ("closing_speed_10_50", "closing_speed_50_90"):
        assert rows[name, "closing"]["changed"]
    way = rows["opening_over_travel", "opening"]
    assert way["change"][1] == pytest.approx(100.0 * way["difference"] / way["before"], rel=1e-4)
    force = rows["f", ""]
    assert force["changed"]
    low, _, high = force["change"]  # 90 %: false alarm below 1e-3 at three times its half
    assert low - (high - low) < -15.0 < high + (high - low)
    codes = [sentence["code"] for sentence in result["sentences"]]
    assert codes.index("measured-changed") < codes.index("parameters-changed")
    assert (inspections / "both.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["a.csv", "--today", "a.csv"], "a.csv is named"),
        (["a.csv", "--today", "open.csv"], "today: open.csv"),
        (["a.csv", "--today", "missing.csv"], "missing.csv"),
        (["a.csv", "--today", "b 2.csv", "--plot", "both.csv"], ".png"),
    ],
)
def test_what_cannot_be_compared_is_refused(folder, capsys, arguments, message):
    assert call(*arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_a_ratio_is_an_explanation_unless_the_transducer_is_the_same(inspections, capsys):
    """The same by the option, or by a column of both tables."""
    write_tables(inspections, "transducer", *(f"{{}}.csv,{motion},1,shaft" for motion in BOTH))
    files = "then/then.csv", "--today", "now/now.csv"
    causes = []
    for arguments in (files, (*files, "--same-transducer"), ("then", "--today", "now")):
        rows = compared(capsys, *arguments)["explanations"]
        causes.append({row["cause"]: row["probability"] for row in rows})
    assert ["ratio" in some for some in causes] == [True, False, False]
    assert all(some["drive"] > 0.99 for some in causes)


def test_a_phase_of_a_table_is_chosen_and_others_are_left_out(inspections, capsys):
    write_tables(inspections, "phase", *(f"{{}}.csv,closing,{i},L{i}" for i in (1, 2)))
    assert call("then", "--today", "now") == 1
    assert "--phase NAME" in capsys.readouterr().err
    one = {"closing": {"before": 1, "today": 1}}
    assert compared(capsys, "then", "--today", "now", "--phase", "L2")["records"] == one
    write_tables(inspections, "date", "{}.csv,closing,1,")
    result = compared(capsys, "then", "--today", "both.csv")
    assert result["records"] == one
    (rejected,) = result["rejected"]
    assert (rejected["inspection"], rejected["motion"]) == ("today", "opening")
    different = {"then": ["then.csv,closing,1,L1"], "now": ["now.csv,closing,1,L2"]}
    write_tables(inspections, "breaker", **different)
    assert call("then", "--today", "now") == 1
    err = capsys.readouterr().err
    assert "L1" in err
    assert "L2" in err


def test_phases_that_are_left_out_are_named(tmp_path, monkeypatch, capsys):
    """The example: three poles."""
    monkeypatch.chdir(tmp_path)
    main(["example", "some", "--inspections"])
    form = "time_column: Time, time_unit: ms, travel_column: Travel R, delimiter: ;"
    (tmp_path / "my.yaml").write_text(f"endurance: {{format: {{{form}}}}}")
    capsys.readouterr()
    files = "some/inspection_2014-05-12.csv", "--today", "some/inspection_2026-03-02.csv"
    for arguments, expected in (((), ["phase-taken"]), (("--phase", "R"), [])):
        result = compared(capsys, *files, "--config", "my.yaml", *arguments)
        assert len(result["doubts"]) == len(expected)
        codes = [sentence["code"] for sentence in result["sentences"]]
        assert codes[: len(expected)] == expected
