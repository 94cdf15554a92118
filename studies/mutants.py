"""Plant one fault at a time in a copy of the project, and run the tests of its folder.

    python -m studies.mutants [--areas limits] [--faults 40] [--seed 1]

Faults are drawn from the syntax trees of the modules of an area: another operator, an inverted
comparison, a changed number, a dropped sign or term, *and* for *or*, the largest for the smallest.
A fault is caught if a test of its area fails or hangs. Some survivors change nothing observable.
"""

import argparse
import ast
import multiprocessing
import os
import random
import shutil
import sys
import tempfile
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path

import numba
import pytest
import scipy.stats  # noqa: F401  imported once, for all runs of the tests
import torch  # noqa: F401
import xarray  # noqa: F401

AREAS = {
    "curves": ("model/curves model/kernels model/equations",
               "model/test_curves model/test_sensitivity model/test_parameters"),
    "correction": ("paper/correction",
                   "paper/test_weights paper/test_transport paper/test_corrections "
                   "paper/test_exactness"),
    "measurements": ("records/measurements records/noisy_trace records/first_motion",
                     "records/test_readings records/test_first_motion records/test_noisy_trace "
                     "records/test_measured"),
    "forecast": ("prognosis/forecast prognosis/limit_states prognosis/service",
                 "prognosis/test_forecast prognosis/test_limit_states prognosis/test_service "
                 "prognosis/test_tables"),
    "limits": ("model/limits diagnosis/limits",
               "model/test_limits diagnosis/test_limits diagnosis/test_inferred"),
}  # fmt: skip
"""Modules of an area, whose docstrings have examples, and its test files."""
LIMIT = 120.0  # s; tests of an area take 20 s on an idle machine, and a fault may hang them
OTHER = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.And: ast.Or, ast.Or: ast.And,
    ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
PAIRS = ("min max", "minimum maximum", "argmin argmax", "any all", "low high", "lower upper")
NAMES = {a: b for pair in PAIRS for a, b in (pair.split(), pair.split()[::-1])}
SKIPPED = (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom)  # messages and names


def nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a tree in which a fault can lie: no annotation, decorator, message, and no
    check that sequences are of one length.
    """
    skipped = [getattr(tree, field, None) for field in ("annotation", "returns")]
    skipped += getattr(tree, "decorator_list", [])
    for node in ast.iter_child_nodes(tree):
        strict = isinstance(node, ast.keyword) and node.arg == "strict"
        if node not in skipped and not strict and not isinstance(node, SKIPPED):
            yield node
            yield from nodes(node)


def changes(node: ast.AST) -> Iterator[str]:
    """Yield what can stand in place of a node."""
    if isinstance(node, ast.BinOp) and type(node.op) in OTHER:
        yield ast.unparse(ast.BinOp(node.left, OTHER[type(node.op)](), node.right))
        if isinstance(node.op, ast.Add | ast.Sub):
            yield ast.unparse(node.left)
    elif isinstance(node, ast.BoolOp):
        yield ast.unparse(ast.BoolOp(OTHER[type(node.op)](), node.values))
    elif isinstance(node, ast.Compare):
        first = OTHER[type(node.ops[0])]()
        yield ast.unparse(ast.Compare(node.left, [first, *node.ops[1:]], node.comparators))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
        yield ast.unparse(node.operand)
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield str(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield str(node.value + 1) if isinstance(node.value, int) else str(2.0 * node.value or 1.0)
    elif isinstance(node, ast.Attribute) and node.attr in NAMES:
        yield f"{ast.unparse(node.value)}.{NAMES[node.attr]}"


def candidates(area: str, root: Path) -> Iterator[tuple[str, int, slice, str]]:
    """Yield all faults of an area: file, line, the bytes that are replaced, and by what."""
    for module in AREAS[area][0].split():
        text = (root / "src/breaker" / f"{module}.py").read_bytes()
        starts = [0, *accumulate(map(len, text.splitlines(keepends=True)))]
        for node in nodes(ast.parse(text)):
            for new in changes(node):
                begin = starts[node.lineno - 1] + node.col_offset
                end = starts[node.end_lineno - 1] + node.end_col_offset
                yield f"src/breaker/{module}.py", node.lineno, slice(begin, end), new


def run_tests(tree: Path, area: str) -> None:
    """Run the tests of an area, in a process of its own, which ends with their status."""
    os.chdir(tree)
    sys.path.insert(0, str(tree / "src"))
    sys.dont_write_bytecode = True
    compiled = tree / "compiled"  # that of curves may depend on the fault
    numba.config.CACHE_DIR = tempfile.mkdtemp(dir=tree) if area == "curves" else str(compiled)
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    modules, tests = (names.split() for names in AREAS[area])
    files = [*(f"src/breaker/{name}.py" for name in modules), *(f"tests/{t}.py" for t in tests)]
    sys.exit(pytest.main(["-xq", "-p", "no:cacheprovider", *files]))


def caught(tree: Path, area: str) -> bool:
    """Return whether a test of an area fails or hangs."""
    process = multiprocessing.get_context("fork").Process(target=run_tests, args=(tree, area))
    process.start()
    process.join(LIMIT)
    process.kill()
    process.join()
    return process.exitcode != 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--areas", nargs="+", choices=AREAS, default=[*AREAS], metavar="AREA")
    parser.add_argument("--faults", type=int, default=40, help="in each area")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    root, results = Path(__file__).resolve().parents[1], []
    with tempfile.TemporaryDirectory() as folder:
        skipped = shutil.ignore_patterns(".*", "__pycache__", "results", "build")
        tree = Path(shutil.copytree(root, Path(folder, "project"), ignore=skipped))
        for area in options.areas:
            if caught(tree, area):
                raise SystemExit(f"The tests of {area} fail without a fault.")
            drawn = random.Random(f"{options.seed} {area}")
            for name, line, part, new in drawn.sample([*candidates(area, root)], options.faults):
                file, text = tree / name, (tree / name).read_bytes()
                file.write_bytes(text[: part.start] + f"({new})".encode() + text[part.stop :])
                results.append(caught(tree, area))
                file.write_bytes(text)
                word = "caught" if results[-1] else "SURVIVES"
                print(f"{word} {name}:{line} {text[part].decode()} -> {new}", flush=True)
            print(f"{area}: {sum(results[-options.faults :])} of {options.faults} caught")
    print(f"{sum(results)} of {len(results)} faults caught")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
