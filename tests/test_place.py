"""`make` has its environment where Snakemake works, whatever the path of the project."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NAMES = ["My Documents", "a (1)", "a'b", "a&b", "a$b", "a;b", "{x}", "a:b"]
WORST = "My Documents (1) 'a' & $b; {x}"
SNAKEFILE = "rule one:\n    output:\n        'out.txt',\n    script:\n        'one.py'\n"


def project(folder, *, cache):
    """Make a folder with what places the environment; variables of its commands."""
    (folder / "envs").mkdir(parents=True)
    for name in ("Makefile", "pyproject.toml", "envs/place.sh", "envs/requirements.lock"):
        shutil.copy(ROOT / name, folder / name)
    # Nor what the make of `make test` tells a make within it.
    others = {"BREAKER_ENV", "MAKEFLAGS", "MAKELEVEL", "MFLAGS"}
    own = {key: value for key, value in os.environ.items() if key not in others}
    return own | {"XDG_CACHE_HOME": str(cache)}


def said(command, folder, variables):
    """Run a command in a folder; what it prints."""
    done = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


PLACE = ["sh", "envs/place.sh", ".venv"]


@pytest.mark.parametrize("name", NAMES)
def test_a_path_that_needs_quotes_has_its_environment_in_the_cache(name, tmp_path):
    variables = project(tmp_path / name, cache=tmp_path / "cache")
    place = said(PLACE, tmp_path / name, variables).strip()
    assert place.startswith(f"{tmp_path}/cache/breaker-")
    variables["BREAKER_ENV"] = "/var/own"
    assert said(PLACE, tmp_path / name, variables).strip() == "/var/own"


@pytest.mark.parametrize("name", ["breaker", "a-b_c.d", "Prüfstand", "a%b", "a=b,c"])
def test_any_other_path_has_it_within(name, tmp_path):
    variables = project(tmp_path / name, cache=tmp_path) | {"BREAKER_ENV": "/var/own"}
    assert said(PLACE, tmp_path / name, variables).strip() == str(tmp_path / name / ".venv")


def test_a_place_that_needs_quotes_too_is_refused(tmp_path):
    variables = project(tmp_path / WORST, cache=tmp_path / "my cache")
    assert said(PLACE, tmp_path / WORST, variables).split() == ["refused", "moved"]
    done = subprocess.run(
        ["make", "environment"], cwd=tmp_path / WORST, env=variables, capture_output=True, text=True
    )
    assert done.returncode
    assert "BREAKER_ENV" in done.stderr
    assert not (tmp_path / WORST / ".venv").exists()


def test_an_environment_of_a_moved_folder_is_made_anew(tmp_path):
    variables = project(tmp_path / "new", cache=tmp_path)
    made = tmp_path / "new" / ".venv"
    made.mkdir()
    for folder, moved in (("new", []), ("old", ["moved"])):
        command = f"command = python -m venv --clear {tmp_path / folder}/.venv\n"
        (made / "pyvenv.cfg").write_text(command, encoding="utf-8")
        assert said(PLACE, tmp_path / "new", variables).split()[1:] == moved


def test_make_links_the_folder_to_its_environment(tmp_path):
    variables = project(tmp_path / WORST, cache=tmp_path / "cache")
    commands = said(["make", "--dry-run", "all"], tmp_path / WORST, variables)
    place = said(PLACE, tmp_path / WORST, variables).strip()
    assert f"-m venv --clear {place}\n" in commands
    assert f"ln -s {place} .venv" in commands
    assert f"\n{place}/bin/snakemake " in commands
    assert WORST not in commands


def test_a_job_runs_in_such_a_folder(tmp_path):
    folder = tmp_path / WORST
    folder.mkdir()
    (folder / ".venv").symlink_to(Path(sys.prefix).resolve())
    (folder / "Snakefile").write_text(SNAKEFILE, encoding="utf-8")
    script = "from pathlib import Path\nPath(snakemake.output[0]).write_text('done')\n"
    (folder / "one.py").write_text(script, encoding="utf-8")
    variables = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    said([".venv/bin/snakemake", "--cores", "1"], folder, variables)
    assert (folder / "out.txt").read_text(encoding="utf-8") == "done"
