"""Do the tests notice? One fault at a time is planted in a copy of the project, and tests run.

    python -m studies.mutants                      all faults, this project
    python -m studies.mutants --tree ../other      the same in another copy of it
    python -m studies.mutants --room model cli     those of some rooms
    python -m studies.mutants --check              only whether each fault still has its place

The faults are in ``mutants.toml``, by room, a folder of the package: ``find``, a text that stands
once in the package, the workflow or the studies, ``put``, what stands there instead, and ``tests``,
the test files (``curves`` is ``test_curves.py``) that have to notice. A fault whose code was
written anew is written anew, too.

First the tests run without any fault: they have to pass. A fault is *caught* if a test fails or
does not end in time, and has *survived* if all pass; it is *not applicable* where its text is not
found exactly once.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGES = ("README.md", "CHANGELOG.md")
PARTS = ("Snakefile", "Makefile", "pyproject.toml", "LICENSE", "CITATION.cff", *PAGES)
FOLDERS = ("config", "docs", "envs", "profiles", "src", "studies", "tests", "workflow", ".ci")
CODE = (("src/breaker", "*.py"), ("workflow", "*.py"), ("workflow", "*.smk"), ("studies", "*.py"))
TESTS = ("tests", "studies/tests")
COMPILED = ("numba", "njit", "@compiled", "import compiled")  # such files need a cache of their own
CAUGHT, SURVIVED, NOT_APPLICABLE = "caught", "survived", "not applicable"


@dataclass(frozen=True)
class Mutant:
    """A fault: a text of the code, what stands there instead, and the tests that should notice."""

    room: str
    name: str
    find: str
    put: str
    tests: str

    def place(self, tree: Path) -> tuple[Path, str] | None:
        """The file in which the fault goes and its text with the fault; None if it has no place."""
        texts = {
            file: file.read_text(encoding="utf-8")
            for folder, pattern in CODE
            for file in (tree / folder).rglob(pattern)
        }
        found = [file for file, text in texts.items() if self.find in text]
        if len(found) != 1 or texts[found[0]].count(self.find) != 1:
            return None
        text = texts[found[0]].replace(self.find, self.put)
        if found[0].suffix == ".py":
            compile(text, self.name, "exec")  # a fault, not a slip of the pen
        return found[0], text

    def test_files(self, tree: Path) -> list[str]:
        """Test files that are to notice, those that this tree has."""
        files = [
            file
            for stem in self.tests.split()
            for folder in TESTS
            for file in (tree / folder).rglob(f"test_{stem}.py")
        ]
        return [str(file.relative_to(tree)) for file in dict.fromkeys(files)]


def mutants(rooms: list[str] | None) -> Iterator[Mutant]:
    """The faults of some rooms, or of all."""
    listed = tomllib.loads((HERE / "mutants.toml").read_text(encoding="utf-8"))
    for room, entries in listed.items():
        if not rooms or room in rooms:
            yield from (Mutant(room, **entry) for entry in entries)


def copy(tree: Path, folder: Path) -> Path:
    """Copy what the tests need of a project."""
    for part in PARTS:
        if (tree / part).exists():
            shutil.copy2(tree / part, folder / part)
    for part in FOLDERS:
        if (tree / part).exists():
            skipped = shutil.ignore_patterns("__pycache__", "results")
            shutil.copytree(tree / part, folder / part, ignore=skipped)
    return folder


def run_tests(tree: Path, files: list[str], cache: Path, limit: float) -> str:
    """Run test files; return what failed, or nothing."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(tree / "src"),
        "NUMBA_CACHE_DIR": str(cache),
        "OMP_NUM_THREADS": "1",
        "NUMBA_NUM_THREADS": "1",
    }
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *files]
    try:
        done = subprocess.run(
            command, cwd=tree, env=environment, capture_output=True, text=True, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return "no end"
    if done.returncode not in (0, 1, 2):
        raise RuntimeError(f"pytest {files}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return (failed[0].split(" - ")[0] if failed else "error") if done.returncode else ""


def plant(mutant: Mutant, tree: Path, caches: Path, limit: float) -> tuple[str, str]:
    """Plant one fault, run its tests, take it out again; return outcome and test."""
    place, files = mutant.place(tree), mutant.test_files(tree)
    if place is None or not files:
        return NOT_APPLICABLE, ""
    file, text = place
    content, stat = file.read_bytes(), file.stat()
    own = any(word in text for word in COMPILED)
    cache = Path(tempfile.mkdtemp(dir=caches)) if own else caches / "shared"
    try:
        file.write_text(text, encoding="utf-8")
        failed = run_tests(tree, files, cache, limit)
    finally:
        file.write_bytes(content)
        os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns))
        if own:
            shutil.rmtree(cache)
    return (CAUGHT if failed else SURVIVED), failed


def check(chosen: list[Mutant], tree: Path) -> int:
    """Say which faults have no place or no test in a tree."""
    lost = []
    for mutant in chosen:
        few = len(mutant.test_files(tree)) < len(mutant.tests.split())
        lost += [mutant] if few or mutant.place(tree) is None else []
    for mutant in lost:
        print(f"{mutant.room:12s} {mutant.name}")
    print(f"{len(chosen) - len(lost)} of {len(chosen)} faults have a place and tests in {tree}")
    return bool(lost)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--tree", type=Path, default=HERE.parent, help="project to be tested")
    parser.add_argument("--room", nargs="+", help="rooms, all by default")
    parser.add_argument("--check", action="store_true", help="only look for the places")
    parser.add_argument("--limit", type=float, default=900.0, help="seconds that tests may take")
    options = parser.parse_args()
    chosen, counts = list(mutants(options.room)), Counter()
    if options.check:
        return check(chosen, options.tree.resolve())
    with tempfile.TemporaryDirectory() as folder:
        (caches := Path(folder, "caches")).mkdir()
        (project := Path(folder, "project")).mkdir()
        tree = copy(options.tree.resolve(), project)
        files = sorted({file for mutant in chosen for file in mutant.test_files(tree)})
        if failed := run_tests(tree, files, caches / "shared", 3600.0):
            raise SystemExit(f"without any fault the tests fail already: {failed}")
        for mutant in chosen:
            outcome, failed = plant(mutant, tree, caches, options.limit)
            counts[outcome] += 1
            print(f"{mutant.room:12s} {outcome:15s} {mutant.name}  {failed}", flush=True)
    print(", ".join(f"{counts[each]} {each}" for each in (CAUGHT, SURVIVED, NOT_APPLICABLE)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
