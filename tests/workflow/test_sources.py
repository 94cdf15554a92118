"""Files of a configuration that are no configuration are refused before Snakemake reads them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from breaker.workflow.sources import ConfigurationError, parse, refuse

ROOT = Path(__file__).resolve().parents[2]
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
        ("-n all --configfile {0}", "is a template"),
        ("--configfiles fine.yaml {0} -- all", "is a template"),
        ("--configfile={0} all", "is a template"),
        (
            "--configfile fine.yaml all",
            "Put what is to be made before it: snakemake -c2 all --conf",
        ),
    ],
)
def test_the_files_of_a_command_are_looked_at(tmp_path, monkeypatch, command, words):
    monkeypatch.chdir(tmp_path)
    write(Path("fine.yaml"), "seed: 2")
    write(Path("evil.yaml"), "__use_yte__: true")
    with pytest.raises(SystemExit, match=words):
        refuse(command.format("evil.yaml").split())
    refuse(["-c2", "all", "--configfile", "fine.yaml"])
    refuse(["-n", "--config", "seed=2", "--", "all"])


def test_the_defaults_are_looked_at(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("config").mkdir()
    write(Path("config/config.yaml"), "__use_yte__: true")
    with pytest.raises(SystemExit, match="is a template"):
        refuse(["all"])


def test_snakemake_runs_no_code_of_a_configuration(tmp_path):
    """The profile is read first: Snakemake would run the code before any line of the Snakefile."""
    ran = tmp_path / "ran"
    file = write(tmp_path / "evil.yaml", f"__use_yte__: true\nseed: ?open({str(ran)!r}, 'w')")
    done = subprocess.run(
        [sys.executable, "-m", "snakemake", "-n", "all", "--configfile", file],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert f"{file}: is a template" in done.stderr
    assert "Traceback" not in done.stderr
    assert not ran.exists()
