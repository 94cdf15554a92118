"""Plausible wrong inputs, and whether the commands refuse them or warn of them.

    python -m studies.wrong_inputs --cases 6 --seed 1 --table docs/wrong_inputs.csv

``KINDS`` is a table of inputs, each with the words that name its trouble. A wrong input and its
right twin are made from the same draws, and the commands run as a user runs them. A wrong input is
silent if it gets an answer without such words. A twin with such words is warned of without cause.
"""

import html
import json
import re
import shutil
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd

from breaker.configuration.loading import load
from breaker.model.parameters import NAMES
from breaker.model.prior import Prior
from studies.other_code import Other
from studies.shared import call, in_pool, parser, report, sampled

LEAD, LENGTH, NOISE = 30.0, 110.0, 0.009  # ms, ms, share of the stroke
OTHER = {"closing": "opening", "opening": "closing"}
WARNS = ("warnings", "remarks", "doubts", "rejected", "differences", "reason")
# Every file gets these remarks, right or wrong, and some files those on the noise.
STANDING = (
    r"- the first motion is taken as.*\n(?: {4}.*\n)*|^.*the phase is not stated.*$|^note:.*$"
)
STANDING += r"|^.*the noise at rest is .*\n(?: {4}.*\n)*|^no (trigger|signal of the contact).*$"


class Record(NamedTuple):
    """A motion: times, ms, and travel, mm, ``(t,)``; its first motion, ms, and stroke, mm."""

    time: np.ndarray
    travel: np.ndarray
    first: float
    stroke: float

    def reached(self, share: float) -> float:
        """Return the time at which a share of the way is made."""
        way = np.abs(self.travel - np.median(self.travel[self.time < self.first]))
        return float(self.time[np.argmax(way >= share * self.stroke)])

    def kept(self, there: np.ndarray) -> "Record":
        """Return the samples that are there, counted from the first of them."""
        time = self.time[there]
        return self._replace(time=time - time[0], travel=self.travel[there])


class Case:
    """Draws of a case, the folder of its files, and files of its settings."""

    def __init__(self, seed: Sequence[int], folder: Path) -> None:
        self.rng, self.folder, self.settings = np.random.default_rng(seed), folder, []
        self.drive = Other.drawn(Prior.from_settings(load()["prior"]), self.rng)
        self.rate = self.pick([5.0, 10.0, 20.0])  # kHz

    def pick(self, choices: Sequence):
        """Draw one of some choices."""
        return choices[int(self.rng.integers(len(choices)))]

    def record(self, motion: str, damping: float = 1.0) -> Record:
        """Simulate an operation, with a factor on the damping of the drive."""
        theta = self.drive.theta * np.exp(0.003 * self.rng.standard_normal(len(NAMES)))
        theta[NAMES.index("gamma_a")] *= damping
        time = np.arange(0.0, LENGTH, 1.0 / self.rate)
        first = LEAD + 0.3 * self.rng.standard_normal()
        travel, _ = Other(theta, self.drive.more).travel(motion, time - first)
        stroke = abs(travel[-1] - travel[0])
        travel = travel + NOISE * stroke * self.rng.standard_normal(time.size)
        return Record(time, travel, first, stroke)

    def write(self, name: str, record: Record, header: dict | None = None, **form) -> Path:
        """Write a record; ``form`` has names of columns, factors, a separator and a decimal."""
        form = {"x": "Travel [mm]", "t": "Time [ms]", "times": 1.0, "scale": 1.0} | form
        columns = {form["t"]: record.time * form["times"], form["x"]: record.travel * form["scale"]}
        return self.write_columns(name, columns | form.get("more", {}), header, **form)

    def write_columns(
        self, name: str, columns: dict, header: dict | None = None, *, sep=";", decimal=".", **_
    ) -> Path:
        """Write columns below a header."""
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        table = pd.DataFrame(columns)
        text = table.to_csv(sep="|", decimal=decimal, index=False, float_format="%.4f")
        above = "".join(f"{key}{sep}{value}\n" for key, value in (header or {}).items())
        file.write_text(above + text.replace("|", sep), encoding="utf-8")
        return file

    def inspection(self, name: str, damping: float = 1.0, **options) -> list[Path]:
        """Write two records of each motion."""
        names = [(f"{name}/{m}_{n}.csv", m) for n in (1, 2) for m in OTHER]
        return [self.write(file, self.record(m, damping), **options) for file, m in names]


Commands = list[list[object]]  # the first file of the first command is inspected before
Make = Callable[[Case, bool], Commands]


def infer(*files: Path, options: Sequence[object] = ()) -> Commands:
    """Return the command that infers files."""
    return [["infer", *files, "--json", *options]]


def compare(before: Sequence[Path], today: Sequence[Path]) -> Commands:
    """Return the command that compares two inspections."""
    return [["compare", *before, "--today", *today, "--json"]]


def samples(change: Callable[[Case, Record], Record], *motions: str) -> Make:
    """Return a kind whose samples are wrong."""

    def make(case: Case, wrong: bool) -> Commands:
        record = case.record(case.pick(motions or [*OTHER]))
        return infer(case.write("a.csv", change(case, record) if wrong else record))

    return make


def form(options: Callable[[Case], dict], header: dict | None = None) -> Make:
    """Return a kind that is written in a wrong way; ``RATE`` in a header is the rate."""

    def make(case: Case, wrong: bool) -> Commands:
        record, drawn = case.record("closing"), options(case)
        above = {key: f"{case.rate:g}" if x == "RATE" else x for key, x in (header or {}).items()}
        return infer(case.write("a.csv", record, above, **(drawn if wrong else {})))

    return make


def two(today: Callable[[Case], dict], before: dict | None = None) -> Make:
    """Return a kind whose second inspection differs from the first in form or header."""

    def make(case: Case, wrong: bool) -> Commands:
        first = case.inspection("before", header=before)
        later = today(case) if wrong else {"header": before}
        return compare(first, case.inspection("today", 1.3, **later))

    return make


def cut(case: Case, record: Record) -> Record:
    """End before the drive rests."""
    end = record.first + case.rng.uniform(0.5, 1.05) * (record.reached(0.97) - record.first)
    return record.kept(record.time <= end)


def begins_in_motion(case: Case, record: Record) -> Record:
    """Begin after 5 to 60 % of the way."""
    return record.kept(record.time >= record.reached(case.rng.uniform(0.05, 0.6)))


def saturated(case: Case, record: Record) -> Record:
    """End the range of the transducer at 70 to 95 % of the stroke."""
    low, high = np.quantile(record.travel, [0.02, 0.98])
    most = low + case.rng.uniform(0.7, 0.95) * (high - low)
    return record._replace(travel=np.minimum(record.travel, most))


def missing_lines(case: Case, record: Record) -> Record:
    """Leave out 30 to 60 % of the motion, so that the times have a step."""
    begin, end = record.reached(0.05), record.reached(0.9)
    lost = (record.time > begin) & (
        record.time < begin + case.rng.uniform(0.3, 0.6) * (end - begin)
    )
    return record._replace(time=record.time[~lost], travel=record.travel[~lost])


def never_moves(case: Case, record: Record) -> Record:
    """Show a dead channel, a drift or hum."""
    drift, hum = case.pick([(0.0, 0.0), (4.0, 0.0), (0.0, 2.0)])
    way = drift * record.time / LENGTH + hum * np.sin(2 * np.pi * record.time / 20.0)
    return record._replace(travel=way + 0.03 * case.rng.standard_normal(way.size))


def lost_samples(case: Case, wrong: bool) -> Commands:
    """Lose samples in the motion of a file without times."""
    record = case.record("closing")
    lost = missing_lines(case, record)
    travel = lost.travel if wrong else record.travel
    columns = {"Travel [mm]": travel, "I [A]": np.zeros(travel.size)}
    return infer(case.write_columns("a.csv", columns, {"Sample rate [kHz]": f"{case.rate:g}"}))


def wrong_column(case: Case, wrong: bool) -> Commands:
    """Read the current of the coil as travel."""
    record = case.record("closing")
    since = np.maximum(record.time - record.first + 10.0, 0.0)
    current = 5.0 * (1.0 - np.exp(-since / 4.0)) * (since < 40.0)
    file = case.write("a.csv", record, more={"Coil current [A]": current})
    return infer(file, options=["--channel", "Coil current" if wrong else "Travel"])


def other_motion(case: Case, wrong: bool) -> Commands:
    """State another motion than the header of the file."""
    record = case.record("closing")
    file = case.write("a.csv", record, {"Operation": "Closing"})
    return infer(file, options=["--motion", "opening" if wrong else "closing"])


def printed_stroke(case: Case, wrong: bool) -> Commands:
    """Print a stroke that is 10 to 20 % off that of the samples."""
    record, factor = case.record("closing"), case.pick([0.8, 0.9, 1.1, 1.2])
    header = {"Stroke (mm)": f"{record.stroke:.1f}"}
    return infer(case.write("a.csv", record, header, scale=factor if wrong else 1.0))


def limits(right: str, *wrong_ones: str) -> Make:
    """Return a kind with a limit that nobody means; ``STROKE`` is the stroke."""

    def make(case: Case, wrong: bool) -> Commands:
        record, line = case.record("closing"), case.pick(wrong_ones) if wrong else right
        case.settings.append(case.folder / "own.yaml")
        file, text = case.write("a.csv", record), line.replace("STROKE", f"{record.stroke:.1f}")
        case.settings[0].write_text(f"limits:\n  - {text}\n")
        return infer(file)

    return make


def swapped_inspections(case: Case, wrong: bool) -> Commands:
    """Name the inspection of the later date as the one before."""
    early = case.inspection("a", header={"Date": "2015-03-02"})
    late = case.inspection("b", 1.3, header={"Date": "2024-06-03"})
    return compare(*((late, early) if wrong else (early, late)))


def own_copy(case: Case, wrong: bool) -> Commands:
    """Compare a record with its copy."""
    record = case.record("closing")
    files = [
        case.write("a.csv", record),
        case.write("b.csv", record if wrong else case.record("closing")),
    ]
    return compare(files[:1], files[1:])


def one_file_for_all(case: Case, wrong: bool) -> Commands:
    """Copy one file to all operations of a folder."""
    files = [
        case.write(f"op/closing/operation_{n}.csv", case.record("closing")) for n in range(1, 4)
    ]
    for file in files[1:] if wrong else []:
        shutil.copy(files[0], file)
    return infer(*files)


def same_phases(case: Case, wrong: bool) -> Commands:
    """Show three phases of the same samples."""
    records = [case.record("closing") for _ in "ABC"]
    travels = {f"Travel {p} [mm]": r.travel for p, r in zip("ABC", records, strict=True)}
    travels = dict.fromkeys(travels, records[0].travel) if wrong else travels
    file = case.write_columns("a.csv", {"Time [ms]": records[0].time, **travels})
    return [["report", file, "--output", case.folder / "r.html"]]


def two_serials(case: Case, wrong: bool) -> Commands:
    """Give files of two serial numbers to a command for one drive."""
    numbers = (4711, 4712) if wrong else (4711, 4711)
    return infer(*(case.write(f"{k}.csv", case.record("closing"), {"Serial No.": number})
                   for k, number in enumerate(numbers)))  # fmt: skip


def swapped_motions(case: Case, wrong: bool) -> Commands:
    """State in the table of a folder that closings are openings, and openings are closings."""
    plain = case.write("plain.csv", case.record("closing"))
    rows = ["file,motion,operation"]
    for number, motion in ((n, m) for n in (1, 2) for m in OTHER):
        file = case.write(f"op/{motion}_{number}.csv", case.record(motion))
        rows.append(f"{file.name},{OTHER[motion] if wrong else motion},{number}")
    (case.folder / "op/operations.csv").write_text("\n".join(rows), encoding="utf-8")
    return [["infer", case.folder / "op", "--json"], ["inspect", plain]][::-1]


RATE, RATES = (
    r"\brate\b|kHz|time[ _]unit|unit of the time|all times|sampl",
    {"Sample rate [kHz]": "RATE"},
)
CUT = r"\bends?\b|early|\bcut\b|too short|\brest\b|later|missing"
SAME = r"\bsame\b|cop(y|ies)|identical|duplicate|twice"
KINDS: dict[str, tuple[Make, str]] = {
    "cut closing": (samples(cut, "closing"), CUT),
    "cut opening": (samples(cut, "opening"), CUT),
    "begins in motion": (samples(begins_in_motion), r"\brest\b|begins?|before"),
    "saturated": (samples(saturated), r"clip|satur|\bflat|stuck|range of"),
    "missing lines": (samples(missing_lines), r"missing|\bgap\b|even steps|lost"),
    "lost samples": (lost_samples, r"\bjump|slip|missing|lost|gap"),
    "never moves": (samples(never_moves), r"no motion|none of|REJECT|stroke|drift|too small"),
    "wrong column": (wrong_column, r"current|unit|coil|REJECT|stroke|no closing"),
    "times x 10 or x 0.1": (form(lambda c: {"times": c.pick([0.1, 10.0])}), RATE + "|speed|slow"),
    "angle without a unit": (form(lambda c: {"x": "Angle", "scale": 3.0}), r"FILL IN|angle|degree"),
    "voltage without a unit": (form(lambda c: {"x": "Voltage", "scale": 0.4}), r"FILL IN|volt"),
    "inch, no unit": (form(lambda c: {"x": "Travel", "scale": 0.04}), r"unit|too small"),
    "s above ms": (form(lambda c: {"t": "Time [s]"}), RATE + r"|\btimes?\b"),
    "rate in header": (form(lambda c: {"times": c.pick([0.5, 2.0, 5.0])}, RATES), RATE),
    "lost decimals": (form(lambda c: {"scale": 1e3}), r"speed|too fast|unit|scale|decimal|stroke"),
    "comma in commas": (form(lambda c: {"sep": ",", "decimal": ","}), r"decimal|column|comma"),
    "printed stroke": (printed_stroke, r"stroke of|printed"),
    "states other motion": (other_motion, r"operation|states?|header|says|motion"),
    "limit off by 1,000": (
        limits("{name: a, motion: closing, upper: {stroke: 16}}",
               "{name: a, motion: closing, upper: {stroke: 16000}}",
               "{name: a, motion: closing, lower: {stroke: 0.016}}"), r"limit|unit|thousand"),
    "tolerance of 200 %": (
        limits("{quantity: stroke, motion: closing, reference: STROKE, tolerance: 20 %}",
               "{quantity: stroke, motion: closing, reference: STROKE, tolerance: 200 %}"),
        r"tolerance|limit"),
    "two inspections, times x 2": (two(lambda c: {"times": c.pick([0.5, 2.0])}), RATE),
    "two inspections, lengths x 1.3": (
        two(lambda c: {"scale": 1.3}), r"ratio|scale|alike|transducer|unit|stroke"),
    "inspections swapped": (swapped_inspections, r"\bdate[ds]?\b|older|newer|later|earlier"),
    "other serial number": (
        two(lambda c: {"header": {"Serial No.": 4712}}, {"Serial No.": 4711}), r"serial|number"),
    "other phase": (two(lambda c: {"header": {"Phase": "L3"}}, {"Phase": "L1"}), r"phase|pole"),
    "own copy": (own_copy, SAME),
    "one file for all": (one_file_for_all, SAME),
    "same phases": (same_phases, SAME),
    "two serial numbers": (two_serials, r"serial|several breakers|different breakers"),
    "motions swapped": (swapped_motions, r"which is no|wrong folder|direction|swapped|folder"),
}  # fmt: skip
"""A table of inputs, and a pattern of the words that name their trouble."""


def words_of(command: Sequence[object], text: str, err: str) -> str:
    """Return what a command says of trouble: errors, warnings, remarks and reasons."""
    with suppress(json.JSONDecodeError):
        return "\n".join([err, *warnings_of(json.loads(text))])
    if command[0] == "inspect":
        marked = re.findall(r"To look at:\n(?:.+\n)+|.*(?:REJECTED|FILL IN|<$).*", text, re.M)
        return "\n".join([err, *marked])
    if command[0] == "report" and Path(command[-1]).exists():
        page = Path(command[-1]).read_text(encoding="utf-8")
        text += re.sub(r"<(style|script|svg)\b.*?</\1>|<[^>]*>", " ", page, flags=re.S)
    return err + html.unescape(text)


def warnings_of(value: object, inside: bool = False) -> list[str]:
    """Return the texts of a JSON document below a key that warns."""
    if isinstance(value, dict):
        inside = inside or str(value.get("code", "")).endswith("-check")
        return [t for k, v in value.items() for t in warnings_of(v, inside or k in WARNS)]
    if isinstance(value, list):
        return [text for item in value for text in warnings_of(item, inside)]
    return [value] * (inside and isinstance(value, str))


def one_input(kind: str, number: int, seed: int, wrong: bool, folder: Path) -> dict:
    """Make an input, run its commands, and say whether its trouble is named."""
    make, pattern = KINDS[kind]
    case = Case([seed, number, *kind.encode()], folder)
    commands = make(case, wrong)
    layout, first = folder / "layout.yaml", commands[0][1]
    inspect = ["inspect", first, "--output", layout]
    said = [(inspect, *call(*inspect))]
    for command in commands:
        files = [*[layout] * layout.exists(), *case.settings]
        options = ["--config", *files] * (bool(files) and command[0] != "inspect")
        said.append((command, *call(*command, *options)))
    words = "\n".join(words_of(command, *texts) for command, _, *texts in said)
    words = re.sub(re.escape(str(folder)) + r"[\w./]*", "FILE", words)
    named = re.search(pattern, re.sub(STANDING, "", words, flags=re.M), re.I | re.M)
    answered = all(status == 0 for command, status, *_ in said if command[0] != "inspect")
    crashed = any("Traceback" in str(status) for _, status, *_ in said)
    row = {"kind": kind, "number": number, "wrong": wrong, "answered": answered}
    return row | {"named": bool(named), "crashed": crashed, "words": " ".join(words.split())[:300]}


def one_case(kind: str, number: int, seed: int) -> list[dict]:
    """Return the rows of a wrong input and of its right twin."""
    with TemporaryDirectory() as folder:
        sides = ((wrong, Path(folder, str(wrong))) for wrong in (True, False))
        return [one_input(kind, number, seed, wrong, place) for wrong, place in sides]


def summary(rows: pd.DataFrame) -> pd.DataFrame:
    """Count, by kind, wrong inputs that are refused, warned of and silent, and twins warned of."""
    wrong, twins = rows[rows.wrong], rows[~rows.wrong]
    counts = {
        "cases": wrong.assign(one=True).one,
        "refused": ~wrong.answered,
        "warned": wrong.named & wrong.answered,
        "silent": ~wrong.named & wrong.answered,
        "twins_warned": twins.named,
        "crashed": rows.crashed,
    }
    sums = {name: flags.groupby(rows.kind, sort=False).sum() for name, flags in counts.items()}
    return pd.DataFrame(sums).astype(int).rename_axis("kind").reset_index()


def main() -> None:
    given = sampled(parser(__doc__), cases=6, seed=1).parse_args()
    jobs = [(kind, number, given.seed) for kind in KINDS for number in range(given.cases)]
    rows = pd.DataFrame([row for pair in in_pool(one_case, jobs, given.cores) for row in pair])
    report(given, summary(rows), rows)


if __name__ == "__main__":
    main()
