"""A family of drives that the model does not fit: ranges of additional effects, and of wear.

A drive has the seven parameters, a draw of the prior, and additional effects, drawn from their
ranges. Each effect is present or absent, with its own strength. The number of effects of a drive is
uniform, from none, as in the model, to all of them. A draw whose drive has no closed position is
repeated. A worn drive has changes of a few parameters and effects, as shares of their values in new
condition.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from breaker.family.rich_drive import CONTACTS, SIZES, Drive, Elements, Stop, Waves
from breaker.model.parameters import FORCE, GAP, NAMES
from breaker.model.prior import Prior

WEAR = ("none", "sparse", "dense")
TRIES = 10_000  # draws of a family, one of which must have a closed position and a curve


@dataclass(frozen=True, eq=False)
class Family:
    """The family: prior of its parameters, and its definition (``data_files.family_of``)."""

    prior: Prior
    settings: Mapping

    def __post_init__(self) -> None:
        known = {field.name for field in fields(Elements)}
        if unknown := sorted(self.settings["effects"].keys() - known):
            what = f"the family has unknown effects: {', '.join(unknown)}"
            raise ValueError(f"{what}. Name effects of {', '.join(sorted(known))}")

    def new(self, rng: np.random.Generator) -> Drive:
        """Draw a drive in new condition; repeat with its kind of contact until the drive works.

        Raises:
            RuntimeError: If no drive of the family has a closed position.
        """
        contact = _chosen(self.settings["contacts"], CONTACTS, rng)
        for _ in range(TRIES):
            if (drive := self._proposed(contact, rng)) is not None:
                return drive
        why = f"none of {TRIES} drives of the family holds a closed position; lower the preloads"
        raise RuntimeError(f"{why} or the strength in its file")

    def _proposed(self, contact: str, rng: np.random.Generator) -> Drive | None:
        """Draw a drive with a kind of contact; return None if it does not work."""
        theta = tuple(self.prior.sample(1, rng)[0].tolist())
        elements = _draw_all(self.settings["effects"], Elements, rng)
        (low, high), n = self.settings["strength"], len(SIZES)
        present, size = rng.random() > rng.random(n), rng.triangular(low, low, high, n)
        strength = dict(zip(SIZES, (present * size).tolist(), strict=True))  # 0: absent
        drive = Drive(theta, elements.scaled(strength)).changed(contact=contact)
        preload = float(rng.uniform(*self.settings["held_preload"]))
        if contact == "held":
            drive = drive.changed(contact_preload=preload * drive.value(FORCE.name))
        if contact == "sliding" and drive.holds:
            low, high = self.settings["touch"]
            touch = drive.value(GAP.name) / drive.travel("opening", np.zeros(1))[0]
            return drive if low <= touch <= high else None
        return drive if drive.holds else None

    def worn(self, drive: Drive, rng: np.random.Generator, kind: str) -> Drive:
        """Draw a worn condition of a drive, of a kind of ``WEAR``, still in the prior's support.

        Raises:
            RuntimeError: If no worn condition has a closed position.
        """
        for _ in range(TRIES):
            wear = self._wear(rng, kind).items()
            worn = drive.changed(**{n: drive.value(n) * (1.0 + share) for n, share in wear})
            if worn.holds and self.prior.supported(np.array(worn.theta)):
                return worn
        why = f"in none of {TRIES} worn conditions does a drive hold a closed position; narrow the"
        raise RuntimeError(f"{why} ranges of wear in the file of the family: {drive}")

    def _wear(self, rng: np.random.Generator, kind: str) -> dict[str, float]:
        """Draw wear of a kind, shares of values in new condition by name."""
        wear, chosen = self.settings["wear"], []
        for part in ("parameters", "elements"):
            names = sorted(n for n in wear["change"] if (n in NAMES) == (part == "parameters"))
            count = rng.integers(*wear["kinds"][kind][part], endpoint=True)
            chosen += rng.choice(names, size=count, replace=False).tolist() if count else []
        return {n: _small(wear["change"][n], wear["smallest"], rng) for n in chosen}

    def kind_of_wear(self, rng: np.random.Generator) -> str:
        """Draw one of ``WEAR``."""
        kinds = self.settings["wear"]["kinds"]
        return _chosen({kind: kinds[kind]["share"] for kind in WEAR}, WEAR, rng)


def _chosen(shares: Mapping[str, float], names: Sequence[str], rng: np.random.Generator) -> str:
    """Draw a name with a probability in proportion to its share."""
    weights = np.array([shares[name] for name in names])
    return names[int((rng.random() * weights.sum() > weights.cumsum()).sum())]


def _draw(ends: Sequence[float], rng: np.random.Generator) -> float:
    """Draw from a range: uniform where it contains 0, else uniform in the logarithm of the size."""
    if ends[0] <= 0.0 <= ends[1]:
        return float(rng.uniform(*ends))
    return float(np.sign(ends[0]) * np.exp(rng.uniform(*sorted(np.log(np.abs(ends))))))


def _small(ends: Sequence[float], smallest: float, rng: np.random.Generator) -> float:
    """Draw from a range, uniform in the logarithm of the size, from a share of an end to it."""
    sizes = np.abs(ends)
    one_side = ends[0] * ends[1] >= 0.0
    side = sizes.argmax() if one_side else rng.random() * sizes.sum() > sizes[0]
    return float(ends[int(side)] * smallest ** rng.random())


def _draw_all(ranges: Mapping, kind: type, rng: np.random.Generator) -> Any:
    """Draw an object of a class from ranges, in the order of its fields, not of the file."""
    drawn = {}
    for field in fields(kind):
        if (ends := ranges.get(field.name)) is None:
            continue
        if field.type is Waves:
            harmonics = rng.standard_normal(6)
            harmonics *= np.sqrt(2.0 / np.square(harmonics).sum())
            drawn[field.name] = Waves(_draw(ends, rng), tuple(harmonics.tolist()))
        elif field.type is Stop:
            drawn[field.name] = _draw_all(ends, Stop, rng)
        else:
            drawn[field.name] = _draw(ends, rng)
    return kind(**drawn)
