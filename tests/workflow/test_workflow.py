"""The whole workflow at a small size, and which of its steps an edit runs again."""

import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
import xarray as xr
import yaml

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("Snakefile", "config", "envs", "profiles", "src", "workflow", "README.md")
SNAKEMAKE = (sys.executable, "-m", "snakemake", "--configfile", "config/test.yaml")

# Rules by what they need, as they follow each other for one motion.
VALIDATION_FIGURES = [
    "figure_sbc",
    "figure_contraction",
    "figure_recovery",
    "figure_pairs",
    "posterior_predictive",
    "figure_posterior_predictive",
]
FROM_CORRECTION = ["judge", "quality", "figure_exactness", "figure_identifiability", "numbers"]
VALIDATION = [
    "validate",
    "validate_reader",
    "figure_sbc_reader",
    "correct_validation",
    *FROM_CORRECTION,
    *VALIDATION_FIGURES,
]
ENDURANCE_FIGURES = [
    "endurance_predictive",
    "figure_endurance_predictive",
    "figure_evolution",
    "numbers",
]
PAGES = ["figure_verdict", "figure_health", "figure_remaining_life"]
DECISIONS = ["condition", "trend", "whole_trend", "decide", *PAGES, "figure_changepoint"]
FROM_INFERENCE = ["correct_operations", "gather", *ENDURANCE_FIGURES, *DECISIONS]
TRAINING = ["train", "figure_loss", *VALIDATION, "infer", *FROM_INFERENCE]
PRIOR_PREDICTIVE = ["prior_predictive", "figure_prior_predictive"]
LIMIT = ["identifiability", "rig_effective"]
ONCE = {"decide", "numbers", *PAGES}  # for both motions together
READING = ["read_curves", "figure_prior_predictive", "infer", *FROM_INFERENCE]


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    environment = {**os.environ, "PYTHONPATH": str(folder / "src")}
    return subprocess.run(
        [*SNAKEMAKE, *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def workflow(tmp_path_factory) -> Path:
    """A copy of the project in which the whole workflow has run at a small size."""
    folder = tmp_path_factory.mktemp("workflow") / "breaker"
    folder.mkdir()
    for part in PARTS:
        copy = shutil.copytree if (ROOT / part).is_dir() else shutil.copy2
        copy(ROOT / part, folder / part)
    result = run(folder, "-c2", "all")
    assert result.returncode == 0, result.stderr[-5000:]
    return folder


def planned(folder: Path) -> Counter:
    """How many jobs of each rule a dry run would start."""
    result = run(folder, "-n", "all")
    assert result.returncode == 0, result.stderr[-5000:]
    text = result.stdout + result.stderr
    if "Nothing to be done" in text:
        return Counter()
    table = text.split("Job stats:")[1].split("total")[0]
    jobs = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+) *$", table, re.M)}
    return Counter({name: count for name, count in jobs.items() if name != "all"})


def edit_config(folder: Path, **sections: dict) -> None:
    path = folder / "config/test.yaml"
    overlay = yaml.safe_load(path.read_text())
    for name, section in sections.items():
        overlay.setdefault(name, {}).update(section)
    path.write_text(yaml.safe_dump(overlay))


def append(folder: Path, file: str, line: str = "# an edit") -> None:
    path = folder / file
    path.write_text(f"{path.read_text()}\n{line}\n")


def edit_closing_training(folder: Path) -> None:
    path = folder / "config/test.yaml"
    overlay = yaml.safe_load(path.read_text())
    closing = overlay["training"]["closing"]  # the file may say that opening is the same
    overlay["training"]["closing"] = {**closing, "steps": closing["steps"] + 20}
    path.write_text(yaml.safe_dump(overlay))


def edit_limits(folder: Path) -> None:
    path = folder / "config/test.yaml"
    overlay = yaml.safe_load(path.read_text())
    overlay["limits"] = [{"name": "late", "motion": "closing", "upper": {"touch_time": 11.0}}]
    path.write_text(yaml.safe_dump(overlay))


def put_own_curves(folder: Path) -> None:
    own = folder / "own"
    if not own.exists():
        shutil.copytree(folder / "results/rig/curves", own)
    edit_config(folder, endurance={"curves": "own"})


# Edit, rules that run again, and for how many motions. The same table stands in docs/workflow.md.
EDITS = {
    "style of one figure": (
        lambda folder: append(folder, "src/breaker/figures/pairs.py"),
        ["figure_pairs"],
        2,
    ),
    "validation.seed": (
        lambda folder: edit_config(folder, validation={"seed": 21}),
        VALIDATION,
        2,
    ),
    "training.closing": (edit_closing_training, TRAINING, 1),
    "sensor.noise_sd": (
        lambda folder: edit_config(folder, sensor={"noise_sd": 0.12}),
        [*TRAINING, *LIMIT],
        2,
    ),
    "sensor.zero_sd": (
        lambda folder: edit_config(folder, sensor={"zero_sd": 0.05}),
        [*TRAINING, *LIMIT],
        2,
    ),
    "sensor.onset_sd": (
        lambda folder: edit_config(folder, sensor={"onset_sd": 0.2}),
        ["bank_shard", *PRIOR_PREDICTIVE, *TRAINING, *LIMIT],
        2,
    ),
    "prior": (
        lambda folder: edit_config(folder, prior={"f": {"median": 0.8, "log_sd": 0.1}}),
        ["bank_shard", *PRIOR_PREDICTIVE, *TRAINING, *LIMIT],
        2,
    ),
    "validation.posterior": (
        lambda folder: edit_config(folder, validation={"posterior": "corrected"}),
        VALIDATION_FIGURES,
        2,
    ),
    "endurance.posterior": (
        lambda folder: edit_config(folder, endurance={"posterior": "amortised"}),
        ENDURANCE_FIGURES,
        2,
    ),
    "correction": (
        lambda folder: edit_config(folder, correction={"largest_k": 0.6}),
        ["correct_validation", *FROM_CORRECTION, *FROM_INFERENCE],
        2,
    ),
    "endurance.curves": (put_own_curves, READING, 2),
    "limits": (
        lambda folder: edit_limits(folder),
        [*DECISIONS, "numbers"],
        2,
    ),
    "alarm": (
        lambda folder: edit_config(folder, alarm={"after": 2}),
        ["decide", *PAGES],
        2,
    ),
    "wear_model": (
        lambda folder: edit_config(folder, wear_model={"horizon": 5000}),
        ["trend", "whole_trend", "decide", *PAGES, "figure_changepoint", "numbers"],
        2,
    ),
    "mechanism.py": (
        lambda folder: append(folder, "src/breaker/mechanism/curves.py"),
        ["bank_shard", *PRIOR_PREDICTIVE, *TRAINING, *LIMIT],
        2,
    ),
    "README.md": (lambda folder: append(folder, "README.md", "A comment."), [], 2),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_runs_just_what_depends_on_it(workflow, name):
    edit, rules, motions = EDITS[name]
    kept = {
        path: (path.read_bytes(), path.stat())
        for top in ("config", "src", "README.md")
        for path in (
            [workflow / top] if (workflow / top).is_file() else (workflow / top).rglob("*")
        )
        if path.is_file()
    }
    try:
        edit(workflow)
        jobs = planned(workflow)
    finally:
        for path, (content, stat) in kept.items():
            path.write_bytes(content)
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert set(jobs) == set(rules)
    # Shards, chunks and sources are several jobs; everything else is one a motion, or one.
    several = {"bank_shard", "read_curves", "infer", "correct_operations"}
    several |= {"condition", "trend", "whole_trend", "figure_changepoint"}
    assert {name: n for name, n in jobs.items() if name not in several} == {
        rule: 1 if rule in ONCE else motions for rule in rules if rule not in several
    }


def test_nothing_is_left_to_do_after_a_run(workflow):
    assert planned(workflow) == Counter()


def test_every_figure_is_there(workflow):
    figures = sorted(path.name for path in (workflow / "figures").glob("*.png"))
    assert len(figures) == 30
    assert all((workflow / "figures" / name).stat().st_size > 10_000 for name in figures)


def test_one_figure_can_be_asked_for_as_typed(workflow):
    result = run(workflow, "-n", "figures/sbc_closing.png")
    assert result.returncode == 0, result.stderr
    assert "Nothing to be done" in result.stdout + result.stderr


@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_stores_open_with_one_call_and_say_what_made_them(workflow, motion):
    results = workflow / "results"
    stores = [
        *results.glob(f"bank/{motion}/*.zarr"),
        results / f"prior_predictive/{motion}.zarr",
        *results.glob(f"validation/{motion}*.zarr"),
        *results.glob(f"training/{motion}*.zarr"),
        *results.glob(f"endurance/{motion}*.zarr"),
        *results.glob(f"exactness/{motion}*.zarr"),
        results / f"rig/{motion}_effective.zarr",
        results / f"identifiability/{motion}.zarr",
    ]
    assert len(stores) == 2 + 1 + 4 + 2 + 2 + 1 + 1 + 1
    for store in stores:
        data = xr.open_zarr(store)
        assert {"title", "settings", "breaker_version"} <= set(data.attrs), store


def test_more_shards_simulate_only_the_new_ones(workflow):
    path = workflow / "config/test.yaml"
    content, stat = path.read_bytes(), path.stat()
    try:
        edit_config(workflow, bank={"shards": 3})
        jobs = planned(workflow)
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert jobs["bank_shard"] == 2  # one a motion
    assert set(jobs) == {"bank_shard", *TRAINING}


def test_a_report_is_made_that_opens_offline(workflow):
    result = run(workflow, "--report", "report.html")
    assert result.returncode == 0, result.stderr[-3000:]
    report = (workflow / "report.html").read_text()
    assert not re.findall(r"<(?:script|link)[^>]+(?:src|href)=[\"']https?:", report)


def test_appended_operations_run_their_own_chunk_and_what_follows(workflow):
    own, path = workflow / "own", workflow / "config/test.yaml"
    content, stat = path.read_bytes(), path.stat()
    try:
        shutil.rmtree(own, ignore_errors=True)
        put_own_curves(workflow)
        done = run(workflow, "-c2", "results/trend/closing.zarr")
        assert done.returncode == 0, done.stderr[-3000:]
        for motion in ("closing", "opening"):
            last = own / motion / f"{motion}_00030.csv"
            for number in range(31, 36):
                shutil.copy(last, last.with_name(f"{motion}_{number:05d}.csv"))
        result = run(workflow, "-n", "results/trend/closing.zarr")
        table = (result.stdout + result.stderr).split("Job stats:")[1].split("total")[0]
    finally:
        path.write_bytes(content)
        os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    jobs = {name: int(n) for name, n in re.findall(r"^(\w+) +(\d+) *$", table, re.M)}
    # Two chunks of 20 and 10 operations: the second one alone, from the state after the first.
    rules = ("read_curves", "infer", "correct_operations", "gather", "trend", "whole_trend")
    assert jobs == dict.fromkeys(rules, 1)


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("sensor={noise: 0.1}", ["sensor.noise", "noise_sd"]),
        ("seed=one", ["seed", "one"]),
        ("validation={draws: -5}", ["validation.draws", "-5"]),
    ],
)
def test_a_wrong_configuration_is_explained(key, words):
    result = run(ROOT, "-n", "all", "--config", key)
    text = result.stdout + result.stderr
    assert result.returncode != 0
    assert "Traceback" not in text
    for word in words:
        assert word in text
