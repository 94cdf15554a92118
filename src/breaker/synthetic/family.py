"""A family of drives that the model does not fit: ranges of what it lacks, and of how it wears.

A drive of the family is a draw of the prior, so that its masses, springs, frictions, force and gap
are the true values of the model's seven parameters, and on top of it every element that the model
lacks, drawn from its range. A range that contains 0 is drawn uniformly, any other one uniformly in
the logarithm of the size. A draw whose drive holds no closed position is drawn again, which favours
strong drives a little.

A worn drive has changes of a few parameters and a few elements, as a share of their values in new
condition, each drawn from its range.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np

from breaker.mechanism import NAMES, UNIT, Size
from breaker.model import Prior
from breaker.synthetic.drive import Drive, Elements, Stop

__all__ = ["Family"]

_TRIES = 10_000  # draws until a drive has to hold


@dataclass(frozen=True, eq=False)
class Family:
    """The family.

    Attributes:
        prior: Prior of the parameters.
        settings: The section ``rigs`` of the configuration: elements of drives of size 1.
        size: Size of its drives, and of the prior.

    Example:
        >>> prior = Prior([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0], [0.1] * 7)
        >>> ranges = {"drag": [0.01, 0.1], "opening_stop": {"reach": [0.0, 5.0]}}
        >>> wear = {"parameters": [1, 1], "elements": [0, 0], "change": {"f": [-0.1, -0.01]}}
        >>> family = Family(prior, {"strength": 1.0, "elements": ranges, "wear": wear})
        >>> rng = np.random.default_rng(1)
        >>> new = family.new(rng)
        >>> bool(0.01 < new.elements.drag < 0.1)
        True
        >>> bool(0.9 < family.worn(new, rng).theta[5] / new.theta[5] < 0.99)
        True
    """

    prior: Prior
    settings: Mapping
    size: Size = UNIT

    def new(self, rng: np.random.Generator) -> Drive:
        """Draw a drive in new condition.

        Raises:
            RuntimeError: If no drive of the family holds a closed position.
        """
        for _ in range(_TRIES):
            theta = tuple(self.prior.sample(1, rng)[0].tolist())
            elements = Elements.from_settings(_draw_all(self.settings["elements"], Elements, rng))
            drive = Drive(theta, elements.scaled(self.settings["strength"]), self.size)
            if drive.holds:
                return drive
        raise RuntimeError(
            f"none of {_TRIES} drives of the family holds a closed position; lower the preloads in "
            "rigs.elements, or rigs.strength"
        )

    def worn(self, drive: Drive, rng: np.random.Generator) -> Drive:
        """Draw a worn condition of a drive that is still in the prior's support.

        Raises:
            RuntimeError: If no worn condition holds a closed position.
        """
        for _ in range(_TRIES):
            wear = self.wear(rng).items()
            worn = drive.changed(**{name: drive.value(name) * (1.0 + by) for name, by in wear})
            if worn.holds and self.prior.supported(np.array(worn.theta)):
                return worn
        raise RuntimeError(
            f"in none of {_TRIES} worn conditions does a drive hold a closed position; narrow the "
            f"ranges in rigs.wear.change: {drive}"
        )

    def wear(self, rng: np.random.Generator) -> dict[str, float]:
        """Draw what wears, by name, and by which share of its value in new condition."""
        wear, chosen = self.settings["wear"], []
        for kind in ("parameters", "elements"):
            names = sorted(n for n in wear["change"] if (n in NAMES) == (kind == "parameters"))
            count = rng.integers(*wear[kind], endpoint=True)
            chosen += rng.choice(names, size=count, replace=False).tolist() if count else []
        return {name: _draw(wear["change"][name], rng) for name in chosen}


def _draw(ends: Sequence[float], rng: np.random.Generator) -> float:
    """Draw from a range: uniform where it contains 0, else uniform in the logarithm of the size."""
    low, high = ends
    if low <= 0.0 <= high:
        return float(rng.uniform(low, high))
    return float(np.sign(low) * np.exp(rng.uniform(*sorted(np.log(np.abs(ends))))))


def _draw_all(ranges: Mapping, kind: type, rng: np.random.Generator) -> dict:
    """Draw from all ranges, in the order of the fields of a class, not in that of a file."""
    there = {each.name: ranges[each.name] for each in fields(kind) if each.name in ranges}
    return {
        name: _draw_all(each, Stop, rng) if isinstance(each, Mapping) else _draw(each, rng)
        for name, each in there.items()
    }
