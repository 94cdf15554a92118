"""Files of a configuration that are no configuration are refused before Snakemake reads them."""

import os
from pathlib import Path

import pytest

from breaker.configuration.yaml_sources import ConfigurationError, parse, refuse
from tests.workflow.conftest import snakemake

BOMB = "a0: &a0 {x: 1}\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 30)
)
REFUSED = {
    "a list in itself": ("a: &a [*a]", "line 1: contains an alias of itself"),
    "a section in itself": ("seed: 1\nb: &b\n  c: {d: *b}", "line 2: contains an alias of itself"),
    "a bomb": (BOMB, "has more than 20000 entries, aliases"),
    "many entries": (f"a: [{'1, ' * 30_000}]", "has more than 20000 entries"),
    "deep lists": ("a: " + "[" * 100_000, "line 1: has more than 20 sections or lists"),
    "deep sections": ("{a: " * 100_000, "line 1: has more than 20 sections or lists"),
    "a template": ("__use_yte__: true\nseed: ?1 + 1", "is a template"),
    "a template by a merge": ("<<: {__use_yte__: true}\nseed: ?1 + 1", "is a template"),
    "a pipe": (os.mkfifo, "is a pipe, not a file"),
    "a folder": (os.mkdir, "is a folder, not a file"),
    "two files in one": ("seed: 1\n---\nseed: 2", "is not valid YAML"),
}


def write(path: Path, content) -> Path:
    content(path) if callable(content) else path.write_text(content, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_endless_or_code_is_refused(tmp_path, name):
    content, reason = REFUSED[name]
    file = write(tmp_path / "mine.yaml", content)
    with pytest.raises(ConfigurationError, match=reason) as caught:
        parse(file)
    assert str(caught.value).startswith(str(file))


def test_aliases_and_merges_as_they_are_meant_are_read(tmp_path):
    text = "a: &a {x: 1}\nb: *a\nc: {<<: *a, y: 2}"
    content, _ = parse(write(tmp_path / "mine.yaml", text))
    assert content == {"a": {"x": 1}, "b": {"x": 1}, "c": {"x": 1, "y": 2}}


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("-n all --configfile evil.yaml", "evil.yaml: is a template"),
        ("--configfiles fine.yaml evil.yaml -- all", "evil.yaml: is a template"),
        ("--configfile=evil.yaml all", "evil.yaml: is a template"),
        ("--profil mine -- all", "evil.yaml: is a template"),
        ("-n all --profile mine/profile.yaml", "evil.yaml: is a template"),
        ("--profile code", "code/config.yaml: is a template"),
        ("all --configfile fine.yaml --configfile=fine.yaml", "--configfile is given twice"),
        ("-C seed=2 --config seed=3 -- all", "--config is given twice, and Snakemake takes the l"),
        (
            "--configfile fine.yaml all",
            "Put what is to be made before it: snakemake -c2 all --conf",
        ),
    ],
)
def test_the_files_of_a_command_are_looked_at(folder, command, words):
    with pytest.raises(SystemExit, match=words):
        refuse(command.split())
    refuse(["-c2", "all", "--configfile", "fine.yaml"])
    refuse(["-n", "--config", "seed=2", "--", "all"])


def test_a_profile_of_the_environment_is_looked_at(folder, monkeypatch):
    monkeypatch.setenv("SNAKEMAKE_PROFILE", "mine")
    with pytest.raises(SystemExit, match=r"evil.yaml: is a template"):
        refuse(["all"])
    refuse(["all", "--profile", "none"])
    refuse(["all", "--profile", "profiles/default"])
    refuse(["all", "--configfile", "fine.yaml"])  # this is taken in place of the profile's


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with configuration files and profiles, some with code."""
    monkeypatch.chdir(tmp_path)
    for path, text in {
        "fine.yaml": "seed: 2",
        "evil.yaml": "__use_yte__: true",
        "mine/profile.yaml": "configfiles: [fine.yaml, evil.yaml]",
        "code/config.yaml": "__use_yte__: true\ncores: ?1 + 1",
        "profiles/default/config.yaml": "__use_yte__: true",
    }.items():
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "runs"),
    [
        ("--configfile {0}/config/config.yaml", False),
        ("--directory {0}", False),
        ("--workflow-profile none --configfile {0}/config/config.yaml", True),
    ],
)
def test_snakemake_stops_at_code_in_a_configuration(tmp_path, options, runs):
    """Before it is run, but without the profile: Snakemake reads the files of a command first."""
    ran, file = tmp_path / "ran", tmp_path / "config/config.yaml"
    file.parent.mkdir()
    write(file, f"__use_yte__: true\nseed: ?open({str(ran)!r}, 'w') and 1")
    output = snakemake("-n", "all", *options.format(tmp_path).split(), fails=True)
    assert "config/config.yaml: is a template" in output
    assert "Traceback" not in output
    assert ran.exists() == runs
