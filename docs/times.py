"""Write where the time of a run goes, by rule, into times.csv and the page on evidence.

    python docs/times.py RESULTS

Called by ``make numbers``. Processor time is that of the jobs alone, which other users of a machine
hardly change; the longest job is in wall time. Snakemake itself is not among them.
"""

import csv
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

DOCS = Path(__file__).resolve().parent
TABLE, PAGE = DOCS / "times.csv", DOCS / "evidence.md"

_WILDCARDS = re.compile(
    r"_(closing|opening|both|levels|changes|shipped|trained|seed\d+|\d+)(?=_|$)"
)
_LEAST = 0.01  # share of the processor time from which a rule has a row of its own on the page
_MARK = "<!-- times: made by `make numbers` -->\n"
_PLACE = re.compile(re.escape(_MARK) + r".*?(?=\n\n|\n*\Z)", re.DOTALL)

Row = dict[str, str]


def by_rule(files: Iterable[Path]) -> list[Row]:
    """Return a row a rule from the benchmarks of its jobs, that with most processor time first.

    Args:
        files: Tables of Snakemake, named after the logs of jobs; figures count as one rule.
    """
    taken: dict[str, list[tuple[float, float]]] = {}
    for file in files:
        with file.open(encoding="utf-8", newline="") as text:
            row = next(csv.DictReader(text, delimiter="\t"))
        rule = _WILDCARDS.sub("", file.stem)
        rule = "figures" if rule.startswith("figures") else rule
        wall, processor = float(row["s"]), row["cpu_time"]
        # A job that ended before it was looked at has none.
        known = re.fullmatch(r"[\d.]+", processor)
        taken.setdefault(rule, []).append((float(processor) if known else wall, wall))
    rows = [
        {
            "rule": rule,
            "jobs": str(len(jobs)),
            "processor_s": f"{sum(processor for processor, _ in jobs):.0f}",
            "longest_s": f"{max(wall for _, wall in jobs):.0f}",
        }
        for rule, jobs in taken.items()
    ]
    return sorted(rows, key=lambda row: (-int(row["processor_s"]), row["rule"]))


def lines(rows: Sequence[Mapping[str, str]]) -> list[str]:
    """Return the lines of the page's table."""
    total = sum(int(row["processor_s"]) for row in rows)
    large = [row for row in rows if int(row["processor_s"]) >= _LEAST * total]
    rest = [row for row in rows if row not in large]
    found = [
        "| rule | jobs | processor time, s | share | longest job, s |",
        "|---|---|---|---|---|",
    ]

    def line(name: str, of: Sequence[Mapping[str, str]]) -> str:
        seconds = sum(int(row["processor_s"]) for row in of)
        jobs = sum(int(row["jobs"]) for row in of)
        longest = max(int(row["longest_s"]) for row in of)
        return f"| {name} | {jobs} | {seconds} | {100 * seconds / total:.0f} % | {longest} |"

    found += [line(f"`{row['rule']}`", [row]) for row in large]
    found += [line(f"{len(rest)} others", rest)] if rest else []
    return [*found, line("all", rows)]


def read() -> list[Row]:
    """Return the rows of times.csv."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def placed(text: str, rows: Sequence[Mapping[str, str]]) -> str:
    """Return a page with the table where its mark is."""
    return _PLACE.sub(lambda _: _MARK + "\n".join(lines(rows)), text)


def main(results: str) -> int:
    """Write both."""
    files = sorted(Path(results, "benchmarks").glob("*.tsv"))
    if not files:
        print(f"{results} has no benchmarks: is it that of a run?")
        return 1
    rows = by_rule(files)
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [*rows[0]], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), rows), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
