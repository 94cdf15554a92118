"""`make` has its environment where Snakemake works, whatever the path of the project."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WORST = "My Documents (1) 'a' & $b; {x}"
PLACE = ["sh", "envs/place.sh", ".venv"]

pytestmark = pytest.mark.slow


def project(folder, *, cache):
    """Make a folder with what places the environment; variables of its commands."""
    (folder / "envs").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "envs/place.sh", "envs/requirements.lock"):
        shutil.copy(ROOT / name, folder / name)
    # Without the variables that the make of `make test` sets for a make within it.
    others = {"BREAKER_ENV", "MAKEFLAGS", "MAKELEVEL", "MFLAGS"}
    own = {key: value for key, value in os.environ.items() if key not in others}
    return own | {"XDG_CACHE_HOME": str(cache)}


def output(command, folder, variables):
    """Run a command in a folder; what it prints."""
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", ["My Documents", "a'b", "a$b", "a;b", "{x}", "a:b"])
def test_a_path_that_needs_quotes_has_its_environment_in_the_cache(name, tmp_path):
    variables = project(tmp_path / name, cache=tmp_path / "cache")
    place = output(PLACE, tmp_path / name, variables).strip()
    assert place.startswith(f"{tmp_path}/cache/breaker-")
    variables["BREAKER_ENV"] = "/var/own"
    assert output(PLACE, tmp_path / name, variables).strip() == "/var/own"


@pytest.mark.parametrize("name", ["a-b_c.d", "Prüfstand", "a%b", "a=b,c"])
def test_any_other_path_has_it_within(name, tmp_path):
    variables = project(tmp_path / name, cache=tmp_path) | {"BREAKER_ENV": "/var/own"}
    made = tmp_path / name / ".venv"
    assert output(PLACE, tmp_path / name, variables).strip() == str(made)
    made.mkdir()
    for folder, moved in ((name, []), ("old", ["moved"])):  # a moved folder has a new one made
        command = f"command = python -m venv --clear {tmp_path / folder}/.venv\n"
        (made / "pyvenv.cfg").write_text(command, encoding="utf-8")
        assert output(PLACE, tmp_path / name, variables).split()[1:] == moved


def test_a_place_that_needs_quotes_too_is_refused(tmp_path):
    variables = project(tmp_path / WORST, cache=tmp_path / "my cache")
    assert output(PLACE, tmp_path / WORST, variables).split() == ["refused", "moved"]
    command = ["make", "environment"]
    about = {"cwd": tmp_path / WORST, "env": variables, "capture_output": True, "text": True}
    done = subprocess.run(command, **about)
    assert done.returncode
    assert "BREAKER_ENV" in done.stderr
    assert not (tmp_path / WORST / ".venv").exists()


def test_make_links_the_folder_to_its_environment(tmp_path):
    variables = project(tmp_path / WORST, cache=tmp_path / "cache")
    commands = output(["make", "--dry-run", "all"], tmp_path / WORST, variables)
    place = output(PLACE, tmp_path / WORST, variables).strip()
    for part in (f"-m venv --clear {place}\n", f"ln -s {place} .venv", f"\n{place}/bin/snakemake "):
        assert part in commands
    assert WORST not in commands


def test_a_job_runs_in_such_a_folder(tmp_path):
    folder = tmp_path / WORST
    folder.mkdir()
    (folder / ".venv").symlink_to(Path(sys.prefix).resolve())
    rule = "rule one:\n    output:\n        'out.txt',\n    script:\n        'one.py'\n"
    (folder / "Snakefile").write_text(rule, encoding="utf-8")
    script = "from pathlib import Path\nPath(snakemake.output[0]).write_text('done')\n"
    (folder / "one.py").write_text(script, encoding="utf-8")
    variables = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    output([".venv/bin/snakemake", "--cores", "1"], folder, variables)
    assert (folder / "out.txt").read_text(encoding="utf-8") == "done"
