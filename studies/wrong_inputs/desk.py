"""What a kind of input is made with: a drive, an instrument, and files in one way of writing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from studies.wrong_inputs.drives import Bench, Drive, Record

# Time, travel, date, serial number, phase, motion, rate; the two motions.
WORDS = [
    "Time|Travel|Date|Serial No.|Phase|Operation|Sample rate [kHz]|Closing|Opening",
    "Time|Travel|Test date|CB No.|Phase|Operation|Sampling frequency [kHz]|Close|Open",
    "Zeit|Weg|Prüfdatum|Schalter-Nr.|Phase|Schaltung|Abtastrate [kHz]|Einschaltung|Ausschaltung",
    "Temps|Course|Date d'essai|N° disjoncteur|Phase|Manoeuvre|Fréquence [kHz]|Fermeture|Ouverture",
]
KEYS = ("time", "travel", "date", "serial", "phase", "operation", "rate", "closing", "opening")


@dataclass(frozen=True)
class Style:
    """How an export is written."""

    separator: str
    decimal: str
    digits: int
    encoding: str
    words: dict

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Style":
        """Draw one that every reader of texts can tell."""
        separator, decimal = [(";", ","), (";", "."), (",", "."), ("\t", ".")][rng.integers(4)]
        words = dict(zip(KEYS, WORDS[rng.integers(len(WORDS))].split("|"), strict=True))
        return cls(separator, decimal, int(rng.integers(3, 5)), "utf-8", words)

    def lines(self, header: Sequence[tuple], columns: Mapping[str, np.ndarray]) -> list[str]:
        """Return the lines of a file."""
        found = [f"{key}{self.separator}{value}" for key, value in header]
        rows = np.column_stack([*columns.values()])
        texts = [
            self.separator.join("" if np.isnan(v) else f"{v:.{self.digits}f}" for v in row)
            for row in rows
        ]
        if self.decimal == ",":
            texts = [text.replace(".", ",") for text in texts]
        return [*found, self.separator.join(columns), *texts]


@dataclass
class Desk:
    """Draws of a case; the wrong input and its right twin are made from the same ones."""

    rng: np.random.Generator
    folder: Path
    drive: Drive
    bench: Bench
    style: Style
    count: int = field(default=0)

    @classmethod
    def draw(cls, seed: Sequence[int], folder: Path) -> "Desk":
        """Draw one from a seed."""
        rng = np.random.default_rng(seed)
        folder.mkdir(parents=True, exist_ok=True)
        drive = Drive.high(rng) if rng.random() < 0.25 else Drive.draw(rng)
        return cls(rng, folder, drive, Bench.draw(rng), Style.draw(rng))

    def pick(self, choices: Sequence):
        """Return one of some choices."""
        return choices[int(self.rng.integers(len(choices)))]

    def record(self, motion: str, drive: Drive | None = None) -> Record:
        """Record an operation, of the desk's drive if no other is named."""
        return (drive or self.drive).record(self.rng, motion, self.bench)

    def header(self, **values) -> list[tuple[str, object]]:
        """Return lines above the samples: words of the style by key."""
        return [(self.style.words[key], value) for key, value in values.items()]

    def write(self, name: str, record: Record, header: Sequence[tuple] = (), **options) -> Path:
        """Write a record; options are `travel` and `time` (names of columns), scales, `more`."""
        words = self.style.words
        columns = {
            options.get("time", f"{words['time']} [ms]"): record.time
            * options.get("time_scale", 1.0),
            options.get("travel", f"{words['travel']} [mm]"): record.travel
            * options.get("scale", 1.0),
        }
        return self.write_columns(name, columns | options.get("more", {}), header)

    def write_columns(self, name: str, columns: Mapping, header: Sequence[tuple] = ()) -> Path:
        """Write columns below a header."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        text = "\n".join(self.style.lines(header, columns)) + "\n"
        path.write_bytes(text.encode(self.style.encoding))
        return path

    def visit(self, name: str, drive: Drive | None = None, **options) -> list[Path]:
        """Write `repeats` records of each of `motions` in a folder."""
        motions = options.pop("motions", ("closing", "opening"))
        found = []
        for number in range(1, options.pop("repeats", 2) + 1):
            for motion in motions:
                record = self.record(motion, drive)
                found.append(self.write(f"{name}/{motion}_{number}.csv", record, **options))
        return found

    def worn(self) -> Drive:
        """Return the drive with more friction, with weaker springs, or with both.

        Both springs become weaker by as much as leaves the stroke, which a real drive's stops hold.
        """
        which = self.pick(["friction", "springs", "both"])
        factors = {} if which == "springs" else {"gamma_a": 1.3}
        if which != "friction":
            own, less = self.drive.drive[0], self.rng.uniform(0.85, 0.95)
            rest = (less * own["f"] + own["k_b"] * own["L"]) / own["reach"] - own["k_b"]
            factors |= {"f": less, "k_a": rest / own["k_a"]}
        return self.drive.worn(**factors)
