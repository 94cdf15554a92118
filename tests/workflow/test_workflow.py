"""The whole workflow at a small size, and which of its steps an edit runs again."""

import json
import os
import re
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from matplotlib.image import imread

from tests.workflow.conftest import ROOT, snakemake

PARTS = ("Snakefile", "config", "envs", "profiles", "src", "workflow", "README.md")
MOTIONS = ("closing", "opening")
ALL = ("all", "validate_shipped")
COMPILED = "__pycache__"

# Rules by what they need, as they follow each other for one motion.
VALIDATION_FIGURES = [
    "figure_validation",
    "posterior_predictive",
    "figure_posterior_predictive",
]
NUMBERS = ["numbers"]
FROM_CORRECTION = ["judge", "quality", "figures_exactness", *NUMBERS]
VALIDATION = [
    "validate",
    "validate_reader",
    "figure_validation_reader",
    "correct_validation",
    *FROM_CORRECTION,
    *VALIDATION_FIGURES,
]
FROM_INFERENCE = ["gather", "endurance_predictive", "figures_endurance", *NUMBERS]
DECISIONS = ["decide", "figures_life", "first_page"]
LIFE = ["life", *DECISIONS, *NUMBERS]
MEASURING = ["read_curves", *LIFE]
TRAINING = ["train", "figure_loss", *VALIDATION, "infer", *FROM_INFERENCE]
PRIOR_PREDICTIVE = ["prior_predictive", "figure_prior_predictive"]
FAMILY = ["family_quality", "figure_validation_family"]
# For both motions together.
ONCE = {*LIFE, "rig", "rig_truth", *FAMILY}
READING = [*MEASURING, "figure_prior_predictive", "infer", "infer_family", *FROM_INFERENCE]
BY_MODEL = [item for item in READING if item not in ("read_curves", "infer_family")]


def run(folder: Path, *arguments: str, fails: bool = False) -> str:
    """Run Snakemake in a folder at a small size; return what it says."""
    options = ("--scheduler", "greedy", "--configfile", "config/test.yaml")  # small jobs: no solver
    return snakemake(*options, *arguments, folder=folder, fails=fails)


def share_what_is_compiled(folder: Path) -> None:
    """Let a copy of the package keep machine code where the project does: it takes 20 s to make."""
    for room in {file.parent for file in (ROOT / "src").rglob("*.py")}:
        (room / COMPILED).mkdir(exist_ok=True)
        (folder / room.relative_to(ROOT) / COMPILED).symlink_to(room / COMPILED)


@pytest.fixture(scope="module")
def workflow(tmp_path_factory) -> Path:
    """A copy of the project in which the whole workflow has run at a small size."""
    folder = tmp_path_factory.mktemp("workflow") / "breaker"
    folder.mkdir()
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns(COMPILED))
        else:
            shutil.copy2(ROOT / part, folder / part)
    share_what_is_compiled(folder)
    # Of networks trained here, a part of `family`: the rest is made as that of those that ship.
    trained = [f"results/family/trained/{name}.zarr" for name in ("levels_closing", "changes_both")]
    run(folder, "-c2", *ALL, *trained)
    return folder


def planned(folder: Path, *targets: str) -> Counter:
    """How many jobs of each rule a dry run would start."""
    text = run(folder, "-n", *(targets or ALL))
    if "Nothing to be done" in text:
        return Counter()
    table = text.split("Job stats:")[1].split("total")[0]
    jobs = {name: int(count) for name, count in re.findall(r"^(\w+) +(\d+) *$", table, re.M)}
    return Counter({name: count for name, count in jobs.items() if name not in ALL})


@contextmanager
def edited(folder: Path) -> Iterator[None]:
    """Let files be edited, and put them back as they were, with their times."""
    files = [file for top in ("config", "src") for file in (folder / top).rglob("*.*")]
    files = [file for file in (*files, folder / "README.md") if file.is_file()]
    kept = {file: (file.read_bytes(), file.stat()) for file in files}
    try:
        yield
    finally:
        for file, (content, stat) in kept.items():
            file.write_bytes(content)
            os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def edit_config(folder: Path, **sections: dict | list) -> None:
    path = folder / "config/test.yaml"
    overlay = yaml.safe_load(path.read_text())
    for name, section in sections.items():
        both = isinstance(section, dict)
        overlay[name] = overlay.get(name, {}) | section if both else section
    path.write_text(yaml.safe_dump(overlay))


def append(folder: Path, file: str, line: str = "# an edit") -> None:
    path = folder / file
    path.write_text(f"{path.read_text()}\n{line}\n")


def put_own_curves(folder: Path) -> None:
    own = folder / "own"
    if not own.exists():
        shutil.copytree(folder / "results/rig/curves", own)
    edit_config(folder, endurance={"curves": "own"})


def setting(**sections: dict | list) -> Callable[[Path], None]:
    return lambda folder: edit_config(folder, **sections)


def edit_in(file: str, old: str, new: str) -> Callable[[Path], None]:
    """Put another text in the place of the first one."""

    def edit(folder: Path) -> None:
        text = (folder / file).read_text(encoding="utf-8")
        assert old in text
        (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")

    return edit


def damage(folder: Path) -> None:
    file = folder / "src/breaker/shipped/medium_voltage_changes.safetensors"
    file.write_bytes(file.read_bytes()[:-1] + b"x")


# Edit, and rules that run again. The same table stands in docs/development.md.
BANK = ["bank_shard", *TRAINING, "identifiability"]
TIRED = {"name": "tired", "of": "change", "lower": {"f": "-5 %"}}
DOCSTRING = '"""', '"""In other words: '
EDITS = {
    "style of one figure": (
        edit_in("src/breaker/figures/pairs.py", *DOCSTRING),
        ["figure_validation", "figure_validation_reader"],  # of one job
    ),
    "by_motion.closing": (
        edit_in("config/test.yaml", "flow_matching}}}", "flow_matching}}, training: {steps: 80}}"),
        TRAINING,
    ),
    "prior": (setting(prior={"f": {"median": 0.8, "log_sd": 0.1}}), [*PRIOR_PREDICTIVE, *BANK]),
    "validation.posterior": (setting(validation={"posterior": "corrected"}), VALIDATION_FIGURES),
    "endurance.draws": (
        setting(endurance={"draws": 60}),
        ["infer", "infer_family", *FROM_INFERENCE],
    ),
    "endurance.curves": (put_own_curves, READING),
    "limits": (setting(limits=[TIRED]), LIFE),
    "planning": (setting(planning={"years": 3.0}), [*DECISIONS, *NUMBERS]),
    # The reader, and the measured truth of what is simulated.
    "a word of the lexicon": (
        edit_in("src/breaker/records/words.yaml", "'travel|", "'travel|excursion|"),
        [*READING, "rig_truth", "validate_reader", "figure_validation_reader", "quality"],
    ),
    "a shipped network": (
        damage,
        ["validate_family", "family_quality", "infer_family", *FROM_INFERENCE, *LIFE],
    ),
    "a docstring of the curves": (
        edit_in("src/breaker/model/curves.py", *DOCSTRING),
        # Records are read, and families answer, without the model of the paper.
        [*PRIOR_PREDICTIVE, *BANK, "rig_truth", *BY_MODEL],
    ),
}


# A dry run takes seconds: edits that make different rules run again are tried together.
ALWAYS = [
    ("style of one figure", "endurance.draws", "planning"),
    ("by_motion.closing", "limits"),
]
OTHERS = [("validation.posterior", "a shipped network"), ("prior",), ("endurance.curves",)]
OTHERS += [("a word of the lexicon",), ("a docstring of the curves",)]
# Shards, chunks and sources are several jobs; everything else is one a motion, or one.
SEVERAL = {"bank_shard", "read_curves", "infer", "infer_family", "validate_family"}


@pytest.mark.parametrize(
    "names",
    [*ALWAYS, *(pytest.param(names, marks=pytest.mark.slow) for names in OTHERS)],
    ids=" and ".join,
)
def test_an_edit_runs_just_what_depends_on_it(workflow, names):
    expected = Counter()
    with edited(workflow):
        for name in names:
            edit, rules = EDITS[name]
            motions = 1 if name == "by_motion.closing" else 2
            assert not set(rules) & set(expected) - {*NUMBERS}, "each edit has rules of its own"
            expected |= {rule: 1 if rule in ONCE else motions for rule in rules}
            edit(workflow)
        jobs = planned(workflow, *ALL[: 2 if set(FAMILY) & set(expected) else 1])
    assert set(jobs) == set(expected)
    assert {rule: n for rule, n in jobs.items() if rule not in SEVERAL} == {
        rule: n for rule, n in expected.items() if rule not in SEVERAL
    }


def test_nothing_is_left_to_do_after_a_run_in_any_other_place(workflow, tmp_path, monkeypatch):
    """Nor after comments, another order of settings, new times, and without a home."""
    others = {"figure_validation_family": 3}
    others |= {"validate_family": 4, "family_quality": 1, "family": 1}
    assert planned(workflow, "family") == others
    copy = shutil.copytree(workflow, tmp_path / "copy", symlinks=True)
    overlay = copy / "config/test.yaml"
    settings = yaml.safe_load(overlay.read_text())
    turned = {name: dict(reversed(section.items())) for name, section in settings.items()}
    overlay.write_text("# a comment\n" + yaml.safe_dump(turned, sort_keys=False))
    append(copy, "config/config.yaml", "# a comment")
    append(copy, "README.md", "A comment.")
    for top in ("config", "src", "workflow"):
        for file in (copy / top).rglob("*.*"):
            os.utime(file)
    monkeypatch.setenv("HOME", "/proc/nowhere")  # where nobody can make a folder
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert planned(copy.rename(tmp_path / "moved")) == Counter()


def test_figures_show_something_and_stores_state_what_made_them(workflow):
    figures = sorted(path.name for path in (workflow / "figures").glob("*.png"))
    # Of both motions, of the life, and of shipped networks.
    assert len(figures) == 24 + 5 + 4
    for name in figures:
        assert np.ptp(imread(workflow / "figures" / name)) > 0.0, name
    stores = [*(workflow / "results").rglob("*.zarr")]
    kinds = {store.relative_to(workflow / "results").parts[0] for store in stores}
    assert {"bank", "endurance", "exactness", "life.zarr", "rig", "training"} < kinds
    for store in stores:
        data = xr.open_zarr(store)
        assert {"title", "settings", "breaker_version"} <= set(data.attrs), store


def test_a_report_is_made_that_opens_offline(workflow):
    run(workflow, "--report", "report.html")
    report = (workflow / "report.html").read_text()
    assert not re.findall(r"<(?:script|link)[^>]+(?:src|href)=[\"']https?:", report)
    description = re.search(r"var workflow_desc = (.*);", report).group(1)
    assert "first_page.html" in json.loads(description).partition("From the travel curves")[0]


@pytest.mark.slow
def test_the_paper_is_made_in_a_folder_of_its_own(workflow):
    text = run(workflow, "-n", "all", "paper")
    rules = set(re.findall(r"^(?:local)?rule (\w+):", text, re.M))
    assert all(name.startswith("paper_") for name in rules - {"paper"})
    assert {"paper_bank_shard", "paper_train", "paper_numbers", "paper_judge"} < rules
    assert not {name for name in rules if "shipped" in name or "family_train" in name}
    made = re.findall(r"^ +(?:output|log|benchmark): (.*)$", text, re.M)
    assert all(path.startswith("paper/") for line in made for path in line.split(", "))
