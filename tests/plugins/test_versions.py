"""Results that were made with a plugin are made anew by another version of it."""

import re

import pytest
import yaml

from tests.plugins.distribution import install_example, set_version
from tests.plugins.test_example import acme
from tests.workflow.conftest import ROOT, snakemake

SETTINGS = {
    "motions": ["closing"],
    "endurance": {"curves": "own", "operations_per_job": 2, "format": {"travel_column": "travel"}},
    "family": {"name": "acme_coil", "simulator": "acme-coil"},
    "family_networks": {"training": {"held_out_curves": 20}},
}
TARGETS = [
    *(f"results/endurance/closing/curves_{chunk}.zarr" for chunk in ("000", "001")),
    "results/family/held_out.zarr",
]


@pytest.fixture
def folder(tmp_path):
    """A folder of records, of which those of one chunk alone are of the format of the page."""
    source = install_example(tmp_path / "src")
    (source / "breaker").symlink_to(ROOT / "src/breaker")
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text(yaml.safe_dump(SETTINGS), encoding="utf-8")
    (tmp_path / "own/closing").mkdir(parents=True)
    acme(tmp_path / "own/closing/closing_1.acme")
    text = "time [ms],travel [mm]\n" + "".join(f"{0.1 * i},0\n" for i in range(900))
    (tmp_path / "own/closing/closing_3.csv").write_text(text, encoding="utf-8")
    return tmp_path


def test_another_version_makes_its_results_anew(folder):
    where = ["--snakefile", ROOT / "workflow/Snakefile", "--workflow-profile", "none"]

    def planned():
        plan = snakemake(*where, "-n", *TARGETS, folder=folder)
        return set(re.findall(r"^    output: (\S+)", plan, flags=re.MULTILINE))

    snakemake(*where, "-c1", *TARGETS, folder=folder)
    assert planned() == set()
    set_version(folder / "src/acme_breaker-1.0.dist-info", "acme-breaker", "1.1")
    assert planned() == {TARGETS[0], TARGETS[2]}
