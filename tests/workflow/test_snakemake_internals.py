"""What the workflow uses of Snakemake without its documentation is there, or said to be gone."""

import importlib.util
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from breaker.workflow import snakemake_internals
from breaker.workflow.snakemake_internals import configuration_files, lacking
from tests.workflow.conftest import ROOT, snakemake

TABLES = {
    "workflow": snakemake_internals._OF_WORKFLOW,
    "modifier": snakemake_internals._OF_MODIFIER,
    "rule": snakemake_internals._OF_RULE,
}
USED = [(kind, name) for kind, names in TABLES.items() for name in names]


@pytest.mark.parametrize(("kind", "name"), USED)
def test_what_is_renamed_is_named_with_what_depends_on_it(kind, name):
    workflow = SimpleNamespace(**dict.fromkeys(TABLES["workflow"]))
    rule = SimpleNamespace(**dict.fromkeys(TABLES["rule"]))
    proxies = SimpleNamespace(_rules={"train": SimpleNamespace(rule=rule)})
    workflow.modifier = SimpleNamespace(path_modifier=None, rule_proxies=proxies)
    assert lacking(workflow) == ""
    delattr({"workflow": workflow, "modifier": workflow.modifier, "rule": rule}[kind], name)
    said = lacking(workflow)
    assert f"  {kind}.{name}, by which {TABLES[kind][name]}" in said
    assert "envs/requirements.lock" in said


def test_a_workflow_stops_where_something_is_gone(tmp_path):
    """As the Snakefile asks, with the real objects, before the first job."""
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    for each in ("config", "profiles", "workflow", "envs"):
        shutil.copytree(ROOT / each, tmp_path / each)
    shutil.copy(ROOT / "Snakefile", tmp_path)
    file = tmp_path / "src/breaker/workflow/snakemake_internals.py"
    text = file.read_text(encoding="utf-8")
    # Of other lengths: a file of the same length, written within a second, is not compiled again.
    for name, gone in (("get_rule", "get_rule_of_old"), ("set_input", "set_input_gone")):
        file.write_text(text.replace(f'    "{name}":', f'    "{gone}":'), encoding="utf-8")
        said = snakemake("-n", "all", folder=tmp_path, fails=True)
        assert f"{gone}, by which" in said
        assert "Traceback" not in said


def test_nothing_else_is_used_outside_the_module():
    """Other files leave the object of the workflow, and its rules, to the module."""
    files = [ROOT / "workflow/Snakefile", *(ROOT / "workflow").rglob("*.smk")]
    files += [ROOT / "studies/Snakefile", *(ROOT / "studies").rglob("*.smk")]
    found = {
        use
        for file in files
        for use in re.findall(r"(?<![\w./])workflow\.\w+", file.read_text(encoding="utf-8"))
    }
    assert found <= {"workflow.basedir", "workflow.source_path"}


def test_a_job_can_be_asked_for_again():
    source = Path(importlib.util.find_spec("snakemake.dag").origin).read_text(encoding="utf-8")
    assert "self.forcefiles = set()" in source, "make_again adds to it"


def test_the_last_overlay_is_the_first_file():
    workflow = SimpleNamespace(
        overwrite_configfiles=["a.yaml", "b.yaml"],
        configfiles=["a.yaml", "b.yaml", "advanced.yaml", "config.yaml"],
    )
    found = configuration_files(workflow)
    assert found == ["b.yaml", "a.yaml", "config.yaml", "advanced.yaml"]
