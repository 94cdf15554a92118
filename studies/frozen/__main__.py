"""Compare the numbers of the present code with frozen ones.

    snakemake -c2 all --configfile config/test.yaml     # in a clone of its own
    python -m studies.frozen --cores 2                  # compares; some 15 minutes of two cores
    python -m studies.frozen --part answers damaged     # compares these parts alone
    python -m studies.frozen --write studies/frozen/start.json.xz   # freezes the present numbers

Only numbers are compared. ``names.csv`` maps the names of frozen numbers to those of now: each
number takes the first row whose pattern ``old`` (a regular expression) matches its whole name;
``new`` is its replacement, empty where the number is gone; ``tolerance`` is relative. The status is
1 where a number differs or is missing.
"""

import argparse
import csv
import json
import lzma
import math
import os
import platform
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from multiprocessing import get_context
from pathlib import Path

from studies.frozen.parts import PARTS, Numbers

_HERE = Path(__file__).parent
_ABSOLUTE = 1e-9  # numbers below are noise of rounding: 1e-9 mm, ms and probabilities are nothing
_SHOWN = 20  # lines of each kind of difference that are printed


def origin(seed: int) -> dict[str, object]:
    """Return what numbers depend on besides the code."""
    packages = ("numba", "numpy", "scipy", "torch", "zuko")
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    processor = next((line.partition(": ")[2] for line in lines if "model name" in line), "")
    flags = next((line for line in lines if line.startswith("flags")), "").split()
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True)
    return {
        "seed": seed,
        "commit": commit.stdout.strip(),
        "python": platform.python_version(),
        "processor": processor,
        "vector extensions": [f for f in flags if f.startswith(("avx", "amx"))],
        "versions": {name: version(name) for name in packages if _installed(name)},
    }


def _installed(name: str) -> bool:
    try:
        return bool(version(name))
    except ImportError:
        return False


def renamed(name: str, rows: list[tuple[re.Pattern, str, float]]) -> tuple[str, float]:
    """Return the present name of a frozen number, empty if it is gone, and its tolerance."""
    for old, new, tolerance in rows:
        if match := old.fullmatch(name):
            return match.expand(new), tolerance
    return name, 0.0


def compare(frozen: Numbers, now: Numbers, rows: list[tuple[re.Pattern, str, float]]) -> bool:
    """Print what differs, and return whether nothing does."""
    counts: Counter[str] = Counter()
    lines_of: dict[str, list[str]] = {"missing": [], "different": []}
    seen = set()
    for name, before in frozen.items():
        present, tolerance = renamed(name, rows)
        if not present:
            counts["removed"] += 1
            continue
        seen.add(present)
        if present not in now:
            lines_of["missing"].append(present)
        elif not _agree(before, now[present], tolerance):
            lines_of["different"].append(f"{present}: {before} before, {now[present]} now")
        else:
            counts["same"] += 1
    for kind, lines in lines_of.items():
        counts[kind] = len(lines)
        for line in lines[:_SHOWN]:
            print(f"{kind}: {line}")
        if len(lines) > _SHOWN:
            groups = Counter(re.split(r"[/:]", line, maxsplit=2)[0] for line in lines)
            print(f"{kind}: {len(lines)} in all, by part {dict(groups)}")
    counts["new"] = len(now.keys() - seen)
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return not counts["missing"] and not counts["different"]


def _agree(before: float | None, now: float | None, tolerance: float) -> bool:
    if before is None or now is None:
        return before is now
    return math.isclose(before, now, rel_tol=tolerance, abs_tol=_ABSOLUTE)


def read_names(file: Path) -> list[tuple[re.Pattern, str, float]]:
    """Return the rows of ``names.csv``."""
    with file.open(encoding="utf-8", newline="") as lines:
        return [
            (re.compile(row["old"]), row["new"], float(row["tolerance"] or 0))
            for row in csv.DictReader(lines)
        ]


def _read(file: Path) -> dict:
    with lzma.open(file, "rt", encoding="utf-8") as text:
        return json.load(text)


def _of_parts(numbers: Mapping[str, float | None], parts: list[str]) -> Numbers:
    return {name: value for name, value in numbers.items() if name.split("/")[0] in parts}


def main() -> int:
    """Make the numbers of now; write them, or compare them with the frozen ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--part", nargs="+", choices=PARTS, default=[*PARTS])
    parser.add_argument("--cores", type=int, default=1)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--write", type=Path, metavar="FILE")
    parser.add_argument("--numbers", type=Path, metavar="FILE", help="numbers of now, made before")
    options = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = "1"
    if options.numbers:
        now = _of_parts(_read(options.numbers)["numbers"], options.part)
    else:
        now = {}
        for part in options.part:
            print(f"making: {part}", file=sys.stderr, flush=True)
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
                found = fresh.submit(PARTS[part], options.seed, options.cores).result()
            now |= {f"{part}/{name}": value for name, value in found.items()}
    if options.write:
        document = {"origin": origin(options.seed), "numbers": now}
        with lzma.open(options.write, "wt", preset=9) as file:
            json.dump(document, file, separators=(",", ":"))
        print(f"{len(now)} numbers, {options.write.stat().st_size / 1000:.0f} kB")
        return 0
    frozen = _read(_HERE / "start.json.xz")
    print("frozen:", frozen["origin"])
    rows = read_names(_HERE / "names.csv")
    return 0 if compare(_of_parts(frozen["numbers"], options.part), now, rows) else 1


if __name__ == "__main__":
    sys.exit(main())
