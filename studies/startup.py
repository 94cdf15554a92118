"""Measure how long a job of each rule takes to start: what its script imports, before any work.

Runs the imports of every script in a fresh interpreter, with what Snakemake puts in front of them
and, where the script reads or writes stores, with ``zarr``, which xarray only imports then. Prints
seconds of processor time (the least of some runs, so that other jobs of the machine count little)
and which of the large libraries were loaded. The last row is the parsing of the Snakefile, which
happens once a run, not once a job.

    python -m studies.startup [--root FOLDER] [--repeats 3]
"""

import argparse
import ast
import os
import subprocess
import sys
import tempfile
from pathlib import Path

LARGE = ("torch", "numba", "scipy.stats", "pandas", "xarray", "zarr", "matplotlib.pyplot")
PREAMBLE = "import pickle, snakemake.iocontainers, snakemake.logging, snakemake.resources\n"
CLOSING = f"""
import sys, time
print(time.process_time(), *(name for name in {LARGE} if name in sys.modules))
"""
PARSE = """
from snakemake.cli import main
try:
    main(["--list-rules"])
except SystemExit:
    pass
"""


def imports(script: Path) -> str:
    """Return the import statements of a script, as one text."""
    text = script.read_text(encoding="utf-8")
    nodes = [node for node in ast.parse(text).body if isinstance(node, ast.Import | ast.ImportFrom)]
    stores = "import zarr\n" if "open_store(" in text or "save(" in text else ""
    return "\n".join(map(ast.unparse, nodes)) + "\n" + stores


def measure(code: str, root: Path, repeats: int) -> tuple[float, list[str]]:
    """Return the least processor time of a fresh interpreter in seconds, and what it loaded."""
    environment = {**os.environ, "PYTHONPATH": str(root / "src"), "OMP_NUM_THREADS": "1"}
    found = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "job.py")
        path.write_text(code + CLOSING, encoding="utf-8")
        for _ in range(repeats):
            command = [sys.executable, str(path)]
            done = subprocess.run(
                command, cwd=root, env=environment, capture_output=True, text=True, check=True
            )
            found.append(done.stdout.strip().splitlines()[-1].split())
    return min(float(words[0]) for words in found), found[0][1:]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parents[1])
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    root = options.root.resolve()
    print(f"{'script':32s}{'seconds':>8s}  loads")
    rows = {"(nothing but Snakemake's own)": PREAMBLE}
    for script in sorted(root.glob("workflow/scripts/*.py")):
        rows[script.stem] = PREAMBLE + imports(script)
    for name, code in rows.items():
        seconds, loaded = measure(code, root, options.repeats)
        print(f"{name:32s}{seconds:8.2f}  {' '.join(loaded)}", flush=True)
    seconds, _ = measure(PARSE, root, options.repeats)
    print(f"{'(the Snakefile, once a run)':32s}{seconds:8.2f}")


if __name__ == "__main__":
    main()
