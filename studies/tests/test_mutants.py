"""The areas of planted faults are those of the project."""

from pathlib import Path

import pytest

from studies.mutants import AREAS, candidates

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("area", AREAS)
def test_an_area_has_modules_with_faults_and_tests(area):
    modules, tests = (names.split() for names in AREAS[area])
    changed = {file for file, *_ in candidates(area, ROOT)}
    assert changed == {f"src/breaker/{name}.py" for name in modules}
    assert all((ROOT / "tests" / f"{name}.py").exists() for name in tests)
