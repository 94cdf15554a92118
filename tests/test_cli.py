"""The command `breaker`, and `breaker infer`: what it prints, writes, and where it fails."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import breaker.posterior
from breaker import cli
from breaker.cli import main
from breaker.files.manifest import Operation
from breaker.mechanism.curves import travel
from breaker.mechanism.parameters import outputs
from breaker.model.bank import simulate
from breaker.model.joint import Model
from breaker.model.randomness import generator
from breaker.posterior.batches import freeze_inputs
from breaker.posterior.estimator import Posterior
from breaker.posterior.predictive import infer
from breaker.posterior.tables import table
from breaker.records.export import write_curve
from breaker.records.reader import read_curves
from tests.networks_fixtures import MARKS, NETWORK, left_out, one_thread  # noqa: F401

pytestmark = MARKS
ROOT = Path(__file__).parents[1]
DRAWS = 40


@pytest.fixture(scope="module")
def trained(tmp_path_factory, defaults, prior, sensor):
    """File of a small model of closings, untrained: the command is the same for it."""
    settings = {"motion": "closing", "network": NETWORK}
    settings |= {"prior": defaults["prior"], "sensor": defaults["sensor"]}
    posterior = Posterior(settings, discrepancy=left_out(sensor.samples, size=0.02))
    rng = generator(0, "test command")
    bank = simulate(Model(prior, sensor, "closing"), 128, rng)
    freeze_inputs(posterior, bank, rng)
    file = tmp_path_factory.mktemp("models") / "closing.safetensors"
    posterior.save(file)
    return file


@pytest.fixture
def project(tmp_path, monkeypatch, trained):
    """A project's folder: configuration, model, two closings and an opening."""
    for part in ("config",):
        shutil.copytree(ROOT / part, tmp_path / part)
    overlay = {"endurance": {"draws": DRAWS, "posterior": "amortised"}}
    (tmp_path / "few.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    shutil.copy(trained, tmp_path / "closing.safetensors")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(autouse=True)
def curves(project, prior):
    time = 0.1 * np.arange(760)
    for name, motion in (("a.csv", "closing"), ("b 2.csv", "closing"), ("open.csv", "opening")):
        exact = travel(prior.medians[None], time, motion, onset=10.0).travel[0]
        noise = 0.1 * generator(1, "test curve", name).standard_normal(time.size)
        write_curve(project / name, time, exact + noise, motion=motion, operation=1)


def call(*arguments):
    return main(["infer", *arguments])


def few(*arguments):
    return call(*arguments, "--config", "few.yaml")


def failed(capsys, *arguments):
    """Run what has to fail; returns the message."""
    assert call(*arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("breaker: ")
    assert "Traceback" not in err
    return err


def test_medians_intervals_and_units_are_printed_for_each_file(capsys, defaults, sensor):
    assert few("closing.safetensors", "a.csv", "b 2.csv") == 0
    out = capsys.readouterr().out
    settings = defaults["endurance"]
    posterior = Posterior.load("closing.safetensors").at(settings["discrepancy"])
    operations = [Operation(1, "a.csv"), Operation(2, "b 2.csv")]
    read = read_curves(operations, settings["format"], sensor.times, "closing")
    seed, p_value = defaults["seed"], settings["misfit_p_value"]
    expected = table(infer(posterior, read, draws=DRAWS, seed=seed, misfit_p_value=p_value))
    blocks = re.split(r"\n(?=a\.csv\n|b 2\.csv\n)", out)
    assert [block.split("\n")[0] for block in blocks[1:]] == ["a.csv", "b 2.csv"]
    for k, block in enumerate(blocks[1:], start=1):
        rows = expected[expected.operation == k]
        assert rows.output.tolist() == [output.name for output in outputs(onset=True)]
        for row in rows.itertuples():
            numbers = f"{row.interval_95_lower:.4g} to {row.interval_95_upper:.4g}"
            line = rf"  {row.output} +{row.median:.4g} +95 %: {re.escape(numbers)} +{row.unit}"
            assert re.search(rf"^{line}$", block, flags=re.MULTILINE)
        p = f"posterior predictive p = {rows.iloc[0].p_value:.2g}"
        verdict = "does NOT fit the model" if rows.iloc[0].misfit else "fits the model"
        assert f"  {verdict} ({p})" in block


def test_the_corrected_posterior_is_the_default_and_says_what_is_not_resolved(project, capsys):
    """The untrained model is far off: one round does not get there, and the rest do."""
    overlay = {"endurance": {"draws": 500, "posterior": "corrected"}}
    (project / "many.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    arguments = ("closing.safetensors", "a.csv", "--output", "out.csv", "--config", "many.yaml")
    assert call(*arguments) == 0
    assert "resolved" not in capsys.readouterr().out
    written = pd.read_csv(project / "out.csv").set_index("output")
    assert written.resolved.all()
    assert (written.effective_size > 400).all()
    # The curve is that of the prior's medians: the exact posterior of its best known is near.
    known = written.loc[["gamma_a", "k_a", "f"]]
    assert known["median"].to_numpy() == pytest.approx([0.30, 0.045, 0.75], rel=0.15)
    overlay["correction"] = {"rounds": 1}
    (project / "many.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    assert call(*arguments) == 0
    assert "NOT resolved" in capsys.readouterr().out
    assert not pd.read_csv(project / "out.csv").resolved.any()


def test_the_table_is_written_with_all_columns(project, capsys):
    assert few("closing.safetensors", "a.csv", "open.csv", "b 2.csv", "--output", "out.csv") == 0
    assert capsys.readouterr().out.endswith("written to out.csv\n")
    written = pd.read_csv(project / "out.csv")
    assert written.groupby("operation").file.first().to_dict() == {
        1: "a.csv",
        2: "open.csv",
        3: "b 2.csv",
    }
    assert len(written) == 3 * 8
    assert {"output", "unit", "median", "p_value", "misfit", "reason"} <= set(written.columns)
    accepted = written.accepted
    assert accepted.groupby(written.operation).first().tolist() == [True, False, True]
    assert written["median"].notna().equals(accepted)
    assert (written.interval_95_lower < written["median"])[accepted].all()
    assert (written["median"] < written.interval_95_upper)[accepted].all()


def test_a_rejected_file_is_told_and_the_rest_goes_on(capsys):
    assert few("closing.safetensors", "open.csv", "a.csv") == 0
    out = capsys.readouterr().out
    assert re.search(r"\nopen\.csv\n  rejected: open\.csv: .* which is no closing", out)
    assert "nan" not in out
    assert re.search(r"\na\.csv\n  mu +\d", out)


def test_if_every_file_is_rejected_it_fails(capsys):
    message = failed(capsys, "closing.safetensors", "open.csv")
    assert "none of 1 closing files can be used" in message
    assert "which is no closing" in message


def test_if_no_file_has_an_answer_it_fails(capsys, monkeypatch):
    """Though files were accepted: each without a posterior."""
    nothing = {"median": np.nan, "accepted": False, "reason": "a.csv: no posterior: no draw"}
    monkeypatch.setattr(breaker.posterior, "table", lambda result: table(result).assign(**nothing))
    assert few("closing.safetensors", "a.csv") == 1
    assert f"breaker: nothing was inferred: {nothing['reason']}\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (KeyboardInterrupt(), 130, "breaker: interrupted\n"),
        (ModuleNotFoundError("No module named 'zuko'", name="zuko"), 1, "zuko. Run `make environ"),
    ],
)
def test_what_ends_a_command_is_one_line(capsys, monkeypatch, error, status, words):
    def run(_):
        raise error

    monkeypatch.setattr(cli, "_infer", run)
    assert call("closing.safetensors", "a.csv") == status
    message = capsys.readouterr().err
    assert words in message
    assert message.count("\n") == 1


def test_a_reader_that_leaves_is_no_error_of_the_command():
    """As in `breaker infer ... | head`."""
    script = (
        "import sys; from breaker import cli\n"
        "cli._infer = lambda _: print('text ' * 10**6) or 0\n"
        "sys.exit(cli.main(['infer', 'model', 'file']))"
    )
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", script], **pipes) as command:
        command.stdout.close()
        assert command.wait(timeout=60) == 141
        assert command.stderr.read() == b""


def test_the_same_call_prints_the_same(capsys):
    texts = []
    for _ in range(2):
        assert few("closing.safetensors", "a.csv") == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1]


def test_an_overlay_says_how_the_files_are_written(project, capsys):
    text = (project / "a.csv").read_text(encoding="utf-8")
    text = text.replace(".", ";").replace(",", "|").replace(";", ",").replace("|", ";")
    (project / "german.csv").write_text(text, encoding="utf-8")
    assert few("closing.safetensors", "a.csv") == 0
    plain = capsys.readouterr().out
    overlay = {"endurance": {"format": {"delimiter": ";", "decimal": ","}}}
    (project / "german.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    arguments = ("closing.safetensors", "german.csv", "--config", "few.yaml", "german.yaml")
    assert call(*arguments) == 0
    assert capsys.readouterr().out == plain.replace("a.csv", "german.csv")


def test_how_far_the_model_is_from_right_is_a_setting(project, capsys, defaults, trained):
    """Another scale, another posterior; a network that knows of none takes 0 alone."""
    texts = []
    for scale in (1.0, 0.0):
        overlay = {"endurance": {"discrepancy": scale}}
        (project / "scale.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
        arguments = ("a.csv", "--config", "few.yaml", "scale.yaml")
        assert call("closing.safetensors", *arguments) == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] != texts[1]
    plain = Posterior(Posterior.load(trained).settings)
    freeze_inputs(plain, simulate(plain.model, 64, generator(0, "test")), generator(0, "test"))
    plain.save(project / "plain.safetensors")
    assert call("plain.safetensors", *arguments) == 0
    capsys.readouterr()
    assert few("plain.safetensors", "a.csv") == 1
    assert "set endurance.discrepancy to 0" in capsys.readouterr().err


# ---- inspect and check --------------------------------------------------------------------------


def test_a_file_is_inspected_and_its_proposal_reads_it(project, capsys):
    text = (project / "a.csv").read_text(encoding="utf-8")
    text = text.replace(".", ";").replace(",", "|").replace(";", ",").replace("|", ";")
    (project / "german.csv").write_text(text, encoding="utf-8")
    arguments = ["german.csv", "--output", "german.yaml", "--plot", "german.png"]
    assert main(["inspect", *arguments]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    overlay = (project / "german.yaml").read_text(encoding="utf-8")
    assert overlay in out
    assert 'delimiter: ";"' in overlay
    assert "accepted" in out
    assert (project / "german.png").stat().st_size > 10_000
    arguments = ("closing.safetensors", "german.csv", "--config", "few.yaml", "german.yaml")
    assert call(*arguments) == 0


def test_a_file_that_cannot_be_inspected(project, capsys):
    assert main(["inspect", "c.csv"]) == 1
    assert capsys.readouterr().err.startswith("breaker: c.csv: is not there")
    (project / "words.csv").write_text("once upon a time", encoding="utf-8")
    assert main(["inspect", "words.csv"]) == 1
    assert "no columns of numbers" in capsys.readouterr().err
    assert main(["inspect", "a.csv", "--channel", "force"]) == 1
    assert "there are 'travel'" in capsys.readouterr().err


def test_a_folder_is_checked(project, capsys):
    for motion, name in (("closing", "a.csv"), ("opening", "open.csv")):
        (project / "own" / motion).mkdir(parents=True)
        shutil.copy(project / name, project / "own" / motion / "operation_1.csv")
    assert main(["check", "own"]) == 0
    assert re.search(r"closing +1 +1 +0 +0", capsys.readouterr().out)
    shutil.copy(project / "a.csv", project / "own" / "opening" / "operation_1.csv")
    assert main(["check", "own"]) == 1
    out, err = capsys.readouterr()
    assert "which is no opening" in out
    assert err == ""


# ---- what fails ---------------------------------------------------------------------------------


def test_a_model_that_is_not_there(capsys):
    assert "there is no model file opening.safetensors" in failed(
        capsys, "opening.safetensors", "a.csv"
    )


def test_a_file_that_is_no_model(project, capsys):
    message = failed(capsys, "a.csv", "a.csv")
    assert re.match(r"breaker: a\.csv:? is not a model file of breaker.*; train it anew", message)
    content = (project / "closing.safetensors").read_bytes()
    (project / "cut.safetensors").write_bytes(content[:-100])
    assert "cut.safetensors is not a model file" in failed(capsys, "cut.safetensors", "a.csv")


def test_files_that_are_none_do_not_stop_the_others(project, capsys):
    os.mkfifo(project / "pipe.csv")
    assert main(["infer", "closing.safetensors", "a.csv", "c.csv", "pipe.csv", "."]) == 0
    told = capsys.readouterr().out
    assert told.count("rejected: ") == 3
    assert "c.csv: is not there" in told
    assert "pipe.csv: is a pipe" in told
    assert "mu" in told


def test_a_curve_file_that_is_not_there(capsys):
    assert "c.csv: is not there" in failed(capsys, "closing.safetensors", "c.csv")


def test_a_folder_for_the_output_that_is_not_there(capsys):
    assert few("closing.safetensors", "a.csv", "--output", "results/out.csv") == 1
    last = capsys.readouterr().err.splitlines()[-1]  # after the progress bar
    assert last.startswith("breaker: ")
    assert "'results'" in last


def test_no_configuration(project, capsys, monkeypatch):
    (project / "elsewhere").mkdir()
    monkeypatch.chdir(project / "elsewhere")
    message = failed(capsys, "../closing.safetensors", "../a.csv")
    assert "there is no config/config.yaml here" in message
    assert "--config" in message


def test_elsewhere_the_configuration_can_be_named(project, capsys, monkeypatch):
    (project / "elsewhere").mkdir()
    monkeypatch.chdir(project / "elsewhere")
    arguments = ("../closing.safetensors", "../a.csv", "--config")
    assert call(*arguments, "../config/config.yaml", "../few.yaml") == 0
    assert "../a.csv" in capsys.readouterr().out
    message = failed(capsys, *arguments, "../few.yaml")
    assert "../few.yaml: seed, correction, endurance.format, " in message
    overlay = {"endurance": {"format": {"travel_unit": "foot"}}}
    Path("foot.yaml").write_text(yaml.safe_dump(overlay), encoding="utf-8")
    message = failed(capsys, *arguments, "../config/config.yaml", "foot.yaml")
    assert "endurance.format.travel_unit is 'foot', not one of mm" in message


@pytest.mark.parametrize(
    ("overlay", "reason"),
    [
        ("endurance:\n  format:\n    travel_unit: foot\n", "wrong.yaml, line 3: endurance.format"),
        ("endurance:\n  formatt:\n    zero: 1.0\n", "wrong.yaml, line 2: endurance.formatt"),
        ("endurance: [", "wrong.yaml: is not valid YAML"),
        ("endurance:\n", "endurance"),
        ("", "wrong.yaml: must hold keys and values"),
    ],
)
def test_a_wrong_configuration(project, capsys, overlay, reason):
    (project / "wrong.yaml").write_text(overlay, encoding="utf-8")
    message = failed(capsys, "closing.safetensors", "a.csv", "--config", "wrong.yaml")
    assert reason in message


def test_a_configuration_that_is_not_there(capsys):
    message = failed(capsys, "closing.safetensors", "a.csv", "--config", "mine.yaml")
    assert "mine.yaml: is not there" in message


@pytest.mark.parametrize("arguments", [[], ["infer"], ["infer", "closing.safetensors"], ["learn"]])
def test_wrong_options_show_the_usage(capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "usage: breaker" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--help"], ["infer", "--help"]])
def test_help_answers_without_what_infers(arguments):
    script = (
        "import atexit, sys; from breaker.cli import main\n"
        "heavy = {'torch', 'pandas', 'xarray', 'numba'}\n"
        "atexit.register(lambda: print('imported:', sorted(heavy & set(sys.modules))))\n"
        f"main({arguments})"
    )
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0
    assert done.stdout.startswith("usage: breaker")
    assert done.stdout.endswith("imported: []\n")
