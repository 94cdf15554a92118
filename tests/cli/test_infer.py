"""`breaker infer`: what it prints, writes, and where it fails."""

import json
import os
import re
import shutil

import arviz_base
import arviz_stats
import numpy as np
import pandas as pd
import pytest
import yaml

from breaker.cli import main
from breaker.configuration.loading import defaults
from breaker.shipped import model_file
from tests.cli.conftest import FEW, written

LIMITS = """
limits:
  - {name: slow, motion: closing, upper: {touch_time: 5.0}}
  - {name: late, motion: closing, upper: {touch_time: 50.0}}
  - {name: untimed, motion: closing, of: record, upper: {touch_time: 5.0}}
  - {name: wide, motion: opening, upper: {L: 30.0}}
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
    assert err.startswith("breaker: ")
    assert len(re.findall("^breaker: ", err, re.M)) == 1
    assert "Traceback" not in err
    return err


# ---- what is answered ---------------------------------------------------------------------------


def test_a_closing_and_an_opening_are_found_in_any_folder(folder, capsys, prior):
    """Both motions of an operation feed one answer, which holds the truth."""
    closing, opening = answered(capsys, "both.csv")["records"]
    assert (closing["motion"], opening["motion"]) == ("closing", "opening")
    assert closing["fit"]["motions"] == opening["fit"]["motions"] == ["closing", "opening"]
    assert closing["parameters"] == opening["parameters"]
    assert closing["fit"]["resolved"]
    assert not closing["fit"]["misfit"]
    assert not opening["fit"]["misfit"]
    for name, truth in zip(closing["parameters"], prior.medians, strict=True):
        low, high = closing["parameters"][name]["interval_95"]  # false alarm below 1e-3 at 4 sd
        assert low - (high - low) / 2 < truth < high + (high - low) / 2, name
    assert closing["quantities"]["touch_time"]["source"] == "measured, touch inferred"
    touch = closing["quantities"]["touch_after_release"]
    assert touch["source"] == "inferred"
    assert touch["interval_95"][0] - 0.5 < 10.09 < touch["interval_95"][1] + 0.5
    assert opening["quantities"]["stroke"]["source"] == "measured"
    assert opening["quantities"]["opening_speed"]["source"] == "measured, separation inferred"
    (alone,) = answered(capsys, "both.csv", "--motion", "opening")["records"]
    assert alone["fit"]["motions"] == ["opening"]
    assert alone["quantities"]["stroke"] == opening["quantities"]["stroke"]


def test_a_record_out_of_the_family_has_measured_quantities_alone(folder, capsys, prior):
    """A drive that halts for 15 ms half-way is no circuit breaker."""
    written(folder / "odd.csv", prior, "closing", halts=150)
    (record,) = answered(capsys, "odd.csv")["records"]
    assert record["fit"]["misfit"]
    assert record["fit"]["parts"]["main motion"] > 1.0
    assert {each["median"] for each in record["parameters"].values()} == {None}
    assert record["quantities"]["touch_time"]["median"] is None
    assert record["quantities"]["stroke"]["median"] == pytest.approx(13.5, abs=0.3)
    assert call("odd.csv", "--plot", "odd.png") == 0
    assert "OUT OF the family" in capsys.readouterr().out
    assert answered(capsys, "a.csv", "odd.csv")["records"][0]["fit"]["resolved"]


def test_the_size_may_be_given_and_a_fact_narrows(folder, capsys):
    """A fact of the command goes before one of the configuration."""
    size = "size: {lengths: 1.0, times: 1.001}\n"
    (folder / "size.yaml").write_text(size)
    (folder / "facts.yaml").write_text(f"{size}known: {{mu: [4.0, 0.02]}}")
    fact = ["--known", "mu=2.0:0.02", "--config", "facts.yaml"]
    found = [answered(capsys, "a.csv", *more) for more in ([], ["--config", "size.yaml"], fact)]
    assert found[1]["drive"]["size"] == {"lengths": 1.0, "times": 1.001}
    unknown, plain, known = (each["records"][0]["parameters"] for each in found)

    def width(found, name):
        return np.diff(found[name]["interval_95"])[0]

    assert width(plain, "L") < 0.9 * width(unknown, "L")
    assert width(known, "mu") < 0.3 * width(plain, "mu")
    assert known["mu"]["median"] == pytest.approx(2.0, abs=0.03)


def test_limits_are_judged_where_there_are_any(folder, capsys):
    (folder / "limits.yaml").write_text(LIMITS, encoding="utf-8")
    arguments = ["infer", "both.csv", "--config", "few.yaml", "limits.yaml"]
    assert main([*arguments, "--json"]) == 0
    closing, opening = json.loads(capsys.readouterr().out)["records"]
    told = [each["verdict"] for each in closing["limits"]]
    assert told == ["fail", "pass", "inconclusive"]  # no contact was timed
    assert closing["limits"][0]["p_exceeded"] == 1.0
    assert closing["limits"][2]["p_exceeded"] is None
    assert [each["verdict"] for each in opening["limits"]] == ["pass", "pass"]
    assert opening["limits"][1]["words"] == "measured stroke below 12 mm"
    assert (closing["verdict"], opening["verdict"]) == ("fail", "pass")
    assert main(arguments) == 0
    out = capsys.readouterr().out
    assert "FAIL: slow" in out
    assert "PASS: wide, short" in out


def test_a_network_of_another_family_may_be_named(folder, capsys):
    shipped = str(model_file("medium_voltage", "levels"))
    shutil.copy(shipped, folder / "own.safetensors")
    assert answered(capsys, "a.csv", "--model", "own.safetensors") == answered(capsys, "a.csv")


# ---- which files --------------------------------------------------------------------------------


def test_a_folder_with_a_table_of_two_breakers(folder, capsys):
    (folder / "own").mkdir()
    for name in ("a.csv", "open.csv", "both.csv"):
        shutil.copy(folder / name, folder / "own")
    rows = ["file,motion,operation,breaker,date,channel"]
    rows += [f"{name},7,Q1,2024-11-20," for name in ("a.csv,closing", "open.csv,opening")]
    rows += ["both.csv,closing,9,Q2,2024-11-21,travel"]
    (folder / "own" / "operations.csv").write_text("\n".join(rows))
    message = failed(capsys, "own")
    assert "endurance.breaker is None, but" in message
    assert "--breaker NAME" in message
    found = answered(capsys, "own", "--breaker", "Q1")
    numbers = [(each["motion"], each["operation"]) for each in found["records"]]
    assert numbers == [("closing", 7), ("opening", 7)]
    assert found["records"][0]["date"] == "2024-11-20"
    found = answered(capsys, "own", "--breaker", "Q2")
    assert [each["operation"] for each in found["records"]] == [9]
    (folder / "second.yaml").write_text("endurance: {breaker: Q2}")
    assert answered(capsys, "own", "--config", "second.yaml") == found
    assert len(answered(capsys, "own/a.csv", "--config", "second.yaml")["records"]) == 1
    message = failed(capsys, "own", "--breaker", "Q2", "--channel", "travel")
    assert "--channel" in message


def test_folders_without_a_table(folder, capsys):
    (folder / "own").mkdir()
    shutil.copy(folder / "both.csv", folder / "own")
    assert len(answered(capsys, "own")["records"]) == 2
    (folder / "own" / "closing").mkdir()
    shutil.move(folder / "own" / "both.csv", folder / "own" / "closing" / "operation_12.csv")
    (record,) = answered(capsys, "own")["records"]
    assert (record["motion"], record["operation"]) == ("closing", 12)
    (folder / "empty").mkdir()
    assert "empty has no file of a record" in failed(capsys, "empty")


def test_files_that_are_none_do_not_stop_the_others(folder, capsys):
    os.mkfifo(folder / "pipe.csv")
    (folder / "empty.csv").write_bytes(b"")
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 40)
    assert call("a.csv", "c.csv", "pipe.csv", "empty.csv", "noise.csv") == 0
    out, err = capsys.readouterr()
    assert out.count("rejected: ") == 4
    assert "\n  mu " in out
    assert "rejected records: 4" in err


# ---- what is written ----------------------------------------------------------------------------


def test_the_table_is_written(folder, capsys):
    assert call("both.csv", "c.csv", "--output", "out.csv") == 0
    assert capsys.readouterr().out.endswith("written to out.csv\n")
    rows = pd.read_csv("out.csv")
    accepted = rows[rows.accepted & rows["median"].notna()]
    assert (accepted.probability[accepted.kind == "mechanism"] <= 1.0).all()
    accepted = accepted[accepted.kind != "mechanism"]  # which may be exactly 0
    assert set(accepted.motion) == {"closing", "opening"}
    assert (accepted.interval_95_lower < accepted["median"]).all()
    assert (accepted["median"] < accepted.interval_95_upper).all()
    rejected = rows[rows.file == "c.csv"]
    assert len(rejected)
    assert rejected["median"].isna().all()


def test_a_picture_and_a_document_at_once(folder, capsys):
    found = answered(capsys, "both.csv", "--plot", "both.png")
    assert len(found["records"]) == 2
    assert (folder / "both.png").stat().st_size > 50_000
    assert call("open.csv", "--plot", "open.png") == 0  # of one motion alone
    assert "drawn in open.png" in capsys.readouterr().out


def test_arviz_opens_draws_in_one_line(folder):
    assert call("both.csv", "a.csv", "--draws", "draws.zarr") == 0
    tree = arviz_base.convert_to_datatree("draws.zarr")
    assert sorted(tree.children) == ["observed_data", "posterior", "prior", "sample_stats"]
    assert tree["posterior/mu"].dims == ("chain", "draw", "record")
    assert tree["posterior/mu"].shape == tree["prior/mu"].shape == (1, 100, 3)
    assert arviz_stats.summary(tree, var_names=["mu", "L"]).shape[0] == 6


# ---- what fails before the work -----------------------------------------------------------------

OWN_PRIOR = "prior: {L: {median: 11.0, log_sd: 0.05}}"
FOOT = "endurance:\n  format:\n    travel_unit: foot\n"


@pytest.mark.parametrize(
    ("words", "overlay", "reason"),
    [
        ("--model gone.safetensors", "", "gone.safetensors"),
        ("--model open.csv", "", "is not a model file"),
        ("--model changes.safetensors", "", "is a network of changes"),
        ("own.safetensors", "", "name it by --model"),
        ("--phase L1", "", "L1.*none"),
        ("--known L=10:1 mu=2:0.1 --known L=11:1", "", "--known has L twice"),
        *(
            (
                f"--known {name}=2.0:0.1",
                "",
                rf"{name} is not inferred.*L, spring_compression",
            )
            for name in ("weight", "closing_speed", "stroke")
        ),
        ("", FOOT, "own.yaml, line 3: endurance.format"),
        ("--config gone.yaml", "", "gone.yaml: is not there"),
    ],
)
def test_what_makes_no_sense_is_told_before_anything_is_read(
    folder, capsys, words, overlay, reason
):
    (folder / "own.yaml").write_text(overlay or FEW)
    (folder / "changes.safetensors").symlink_to(model_file("medium_voltage", "changes"))
    assert re.search(reason, failed(capsys, "a.csv", *words.split(), "--config", "own.yaml"))


def test_the_configuration_of_the_project_counts(folder, capsys):
    """One in the folder's config/config.yaml comes before the defaults that ship."""
    (folder / "config").mkdir()
    settings = defaults()
    settings["endurance"]["format"]["travel_column"] = "height"
    settings["limits"] = [{"name": "slow", "motion": "closing", "upper": {"touch_time": 5.0}}]
    (folder / "config" / "config.yaml").write_text(yaml.safe_dump(settings), encoding="utf-8")
    assert call("a.csv") == 1
    assert "'height'" in capsys.readouterr().out
    assert call("a.csv", "--channel", "travel") == 0
    assert "FAIL: slow" in capsys.readouterr().out


# ---- nonsense that was taken for sense ----------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--known", "mu"], "is not NAME=VALUE:SD"),
        (["--known", "mu=2.0"], "is not NAME=VALUE:SD"),
        (["--known", "mu=2.0:-1"], "standard deviation -1"),
        (["--known", "L=-10:0.1"], "has the value -10"),
        (["--known", "L=10:1e-12"], "has the standard deviation"),
        (["--motion", "both"], "--motion"),
    ],
)
def test_wrong_values_of_options(folder, capsys, words, message):
    with pytest.raises(SystemExit) as caught:
        main(["infer", "a.csv", *words])
    assert caught.value.code == 2
    assert message in capsys.readouterr().err


def test_no_answer_depends_on_the_call_on_other_records_or_on_names_of_files(folder, capsys):
    (folder / "link.csv").symlink_to("b 2.csv")
    orders = ["a.csv", "b 2.csv", "open.csv"], ["open.csv", "link.csv", "b 2.csv", "./a.csv"]
    first, second = (answered(capsys, *files) for files in orders)
    assert first == second
    assert answered(capsys, "a.csv")["records"] == first["records"][:1]
