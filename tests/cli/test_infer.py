"""`breaker infer`: what it prints, writes, and where it fails."""

import json
import os
import re
import shutil

import numpy as np
import pandas as pd
import pytest

from breaker.cli import main
from breaker.shipped import model_file
from tests.cli.conftest import FEW

LIMITS = """
limits:
  - {name: slow, motion: closing, upper: {touch_time: 5.0}}
  - {name: late, motion: closing, upper: {touch_time: 50.0}}
  - {name: untimed, motion: closing, of: record, upper: {touch_time: 5.0}}
  - {name: short, motion: opening, of: record, lower: {stroke: 12.0}}
  - {name: stiff, of: change, upper: {gamma_a: +15 %}}
"""


def call(*arguments):
    return main(["infer", *arguments, "--config", "few.yaml"])


def answered(capsys, *arguments):
    """The document of a call."""
    assert call(*arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


def failed(capsys, *arguments):
    """Run what has to fail before anything is read; returns the message."""
    assert main(["infer", *arguments]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert len(re.findall("^breaker: ", err, re.M)) == 1
    assert "Traceback" not in err
    return err


def test_both_motions_of_a_file_give_one_state_and_limits_are_judged(folder, capsys, prior):
    (folder / "limits.yaml").write_text(LIMITS, encoding="utf-8")
    arguments = ["infer", "both.csv", "--config", "few.yaml", "limits.yaml"]
    assert main([*arguments, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    closing, opening = result["records"]
    assert (closing["motion"], opening["motion"]) == ("closing", "opening")
    assert closing["fit"]["motions"] == opening["fit"]["motions"] == ["closing", "opening"]
    assert closing["parameters"] == opening["parameters"]
    assert closing["fit"]["resolved"]
    for name, truth in zip(closing["parameters"], prior.medians, strict=True):
        low, high = closing["parameters"][name]["interval_95"]  # false alarm below 1e-3 at 4 sd
        assert low - (high - low) / 2 < truth < high + (high - low) / 2, name
    sources = {name: value.get("source") for name, value in opening["quantities"].items()}
    assert (sources["stroke"], sources["opening_speed"]) == ("measured", "mixed")
    touch = closing["quantities"]["touch_after_release"]
    assert touch["source"] == "estimated"
    assert touch["interval_95"][0] - 0.5 < 10.09 < touch["interval_95"][1] + 0.5
    verdicts = [(limit["verdict"], limit["p_exceeded"]) for limit in closing["limits"]]
    assert verdicts == [("fail", 1.0), ("pass", pytest.approx(0, abs=0.01)), ("inconclusive", None)]
    assert (result["verdict"], opening["verdict"]) == ("fail", "pass")
    assert [remark["code"] for remark in result["remarks"]] == ["limits-of-change"]
    assert main(arguments) == 0
    assert capsys.readouterr().out.startswith("FAIL: slow")
    one = answered(capsys, "both.csv", "--motion", "opening", "--config", "few.yaml", "limits.yaml")
    assert [warning["code"] for warning in one["warnings"]] == ["limits-without-record"]
    (alone,) = one["records"]
    assert alone["fit"]["motions"] == ["opening"]
    assert alone["quantities"]["stroke"] == opening["quantities"]["stroke"]


def test_the_size_may_be_given_and_a_known_value_narrows(folder, capsys):
    (folder / "size.yaml").write_text("size: {lengths: 1.0, times: 1.001}\n")
    known = ["--known", "mu=2.0:0.02", "--config", "size.yaml"]
    results = [answered(capsys, "a.csv", *more) for more in ([], ["--config", "size.yaml"], known)]
    assert results[1]["settings"]["size"] == {"lengths": 1.0, "times": 1.001}
    unknown, plain, known = (result["records"][0]["parameters"] for result in results)

    def width(parameters, name):
        return np.diff(parameters[name]["interval_95"])[0]

    assert width(plain, "L") < 0.9 * width(unknown, "L")
    assert width(known, "mu") < 0.3 * width(plain, "mu")
    assert known["mu"]["median"] == pytest.approx(2.0, abs=0.03)


def test_a_folder_with_a_table_of_two_breakers(folder, capsys):
    (folder / "own").mkdir()
    for name in ("a.csv", "open.csv", "both.csv"):
        shutil.copy(folder / name, folder / "own")
    rows = ["file,motion,operation,breaker,date,channel"]
    rows += [f"{name},7,Q1,2024-11-20," for name in ("a.csv,closing", "open.csv,opening")]
    rows += ["both.csv,closing,9,Q2,2024-11-21,travel"]
    (folder / "own" / "operations.csv").write_text("\n".join(rows))
    assert "--breaker NAME" in failed(capsys, "own")
    result = answered(capsys, "own", "--breaker", "Q1")
    numbers = [(record["motion"], record["operation"]) for record in result["records"]]
    assert numbers == [("closing", 7), ("opening", 7)]
    assert result["records"][0]["date"] == "2024-11-20"
    result = answered(capsys, "own", "--breaker", "Q2")
    (folder / "second.yaml").write_text("endurance: {breaker: Q2}")
    assert answered(capsys, "own", "--config", "second.yaml") == result
    assert "--channel" in failed(capsys, "own", "--breaker", "Q2", "--channel", "travel")


def test_files_without_a_record_do_not_stop_the_others_and_all_is_written(folder, capsys):
    os.mkfifo(folder / "pipe.csv")
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 40)
    outputs = ["--output", "out.csv", "--plot", "out.png"]
    assert call("both.csv", "a.csv", "c.csv", "pipe.csv", "noise.csv", *outputs) == 0
    out, err = capsys.readouterr()
    assert all(name in out for name in ("c.csv", "pipe.csv", "noise.csv", "stroke"))
    assert "3" in err
    rows = pd.read_csv("out.csv")
    known = rows[rows["median"].notna() & (rows.kind != "effect")]  # which may be exactly 0
    assert set(known.motion) == {"closing", "opening"}
    assert (known.interval_95_lower < known["median"]).all()
    assert (known["median"] < known.interval_95_upper).all()
    rejected = rows[rows.file == "c.csv"]
    assert len(rejected)
    assert rejected["median"].isna().all()
    assert (folder / "out.png").stat().st_size > 50_000


@pytest.mark.parametrize(
    ("words", "overlay", "reason"),
    [
        ("--model gone.safetensors", "", "gone.safetensors"),
        ("--model open.csv", "", "open.csv"),
        ("--model changes.safetensors", "", "changes.safetensors"),
        ("--phase L1", "", "L1"),
        ("--known stroke=2.0:0.1", "", "stroke.*L, spring_compression"),
        (
            "",
            "endurance:\n  format:\n    travel_unit: foot\n",
            "own.yaml.*\n.*travel_unit",
        ),
        ("--config gone.yaml", "", "gone.yaml"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_read(
    folder, capsys, words, overlay, reason
):
    (folder / "own.yaml").write_text(overlay or FEW)
    (folder / "changes.safetensors").symlink_to(model_file("medium_voltage", "changes"))
    assert re.search(reason, failed(capsys, "a.csv", *words.split(), "--config", "own.yaml"))


@pytest.mark.parametrize("known", ["mu", "mu=2.0", "L=10:1e-12"])
def test_wrong_known_values_are_wrong_options(folder, known):
    with pytest.raises(SystemExit) as caught:
        main(["infer", "a.csv", "--known", known])
    assert caught.value.code == 2


def test_no_answer_depends_on_other_records_on_names_of_files_or_where_a_network_lies(
    folder, capsys
):
    (folder / "link.csv").symlink_to("b 2.csv")
    orders = ["a.csv", "b 2.csv", "open.csv"], ["open.csv", "link.csv", "b 2.csv", "./a.csv"]
    first, second = (answered(capsys, *files) for files in orders)
    assert first == second
    shutil.copy(model_file("medium_voltage", "levels"), folder / "own.safetensors")
    alone = answered(capsys, "a.csv", "--model", "own.safetensors")
    assert alone["records"] == first["records"][:1]
