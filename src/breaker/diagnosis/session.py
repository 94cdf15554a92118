"""The assessment of a drive under one configuration: its records read, inferred, judged, compared.

Every command and the fleet ask here. So a record is prepared in one way, whoever asks: its columns
of contact and coil, the family of drives, the zone of each speed, what is given, and the limits.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from breaker.configuration.definitions import advice_of
from breaker.configuration.loading import defaults
from breaker.diagnosis.drive_records import read_operations
from breaker.diagnosis.estimate import KNOWN_VALUES, DriveRecord, Estimate, EstimateSettings, Given
from breaker.diagnosis.inference import infer_drive
from breaker.diagnosis.limits import Verdict, judged
from breaker.family.network_files import shipped_levels
from breaker.family.networks import StateNetwork
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, Size
from breaker.model.quantities import OF_STROKE, Speed, speeds_at
from breaker.records.files import Files
from breaker.records.operations import Operation

if TYPE_CHECKING:
    from breaker.diagnosis.inspection_change import InspectionChange

BEYOND = 0.05
"""Share of a change between two visits that matters."""


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is asked of the records of a drive.

    Attributes:
        config: The configuration.
        limits: Entries of the section ``limits``, on which to judge.
        given: What is given beside the records.
        families: Opens the networks of levels, in the order in which families are tried.
    """

    config: Mapping
    limits: Sequence[Mapping] = ()
    given: Given = field(default_factory=Given)
    families: Callable[[], Iterable[StateNetwork]] = shipped_levels

    @property
    def settings(self) -> EstimateSettings:
        """How answers are drawn."""
        some = self.config["endurance"]
        return EstimateSettings(some["draws"], some["misfit_p_value"], self.config["seed"])

    def read(
        self,
        operations: Mapping[str, Sequence[Operation]],
        *,
        loose: bool = False,
        files: Files | None = None,
    ) -> list[DriveRecord]:
        """Read records: see ``read_operations``."""
        form = self.config["endurance"]["format"]
        return read_operations(operations, form, loose=loose, files=files)

    def infer(self, records: Sequence[DriveRecord]) -> list[Estimate]:
        """Infer records, in their order: see ``infer_drive``."""
        speeds = self.speeds_of(records)
        return infer_drive(records, self.families(), self.given, speeds, self.settings)

    def speeds_of(self, records: Iterable[DriveRecord]) -> tuple[Speed, ...]:
        """Return the speeds of a drive: those that any record shows (``OF_STROKE``), and between
        points of the configuration, or else those that its files state; where there are none, over
        a way that goes with its stroke. None of a drive without a usable record.
        """
        usable = [each for each in records if not each.reason]
        if not usable:
            return ()
        points = {**OF_STROKE, **self.config["speeds"]}
        if any(each.stated.speed_points for each in usable):
            from breaker.records.printed import stated_speeds

            stated = [stated_speeds(each.stated) for each in usable]
            for motion in MOTIONS:
                own = {tuple(each[motion].points) for each in stated if motion in each}
                if len(own) == 1 and points.get(f"{motion}_speed") is None:
                    points[f"{motion}_speed"] = own.pop()
        return speeds_at(points, float(np.median([each.shape.stroke for each in usable])))

    def limits_on(
        self, answers: Sequence[Estimate], motions: Iterable[str] = MOTIONS
    ) -> list[Limit]:
        """Return the limits on motions of a drive; none where no record of it can be used."""
        speeds = next((each.speeds for each in answers if each.speeds), ())
        return from_list(self.limits, [*motions], speeds) if speeds else []

    def judge(self, answers: Sequence[Estimate]) -> list[list[Verdict]]:
        """Return the verdicts of each answer: see ``judged``."""
        limits = self.limits_on(answers)
        return [judged(each, limits, seed=self.settings.seed) for each in answers]

    def compare(
        self,
        visits: Mapping[str, Sequence[DriveRecord]],
        beyond: float = BEYOND,
        *,
        same_transducer: bool = False,
    ) -> "InspectionChange":
        """Compare records "before" and "today": see ``visit_comparison.compared``."""
        from breaker.diagnosis.visit_comparison import compared

        speeds = self.speeds_of(each for records in visits.values() for each in records)
        about = {
            "beyond": beyond,
            "limits": self.limits,
            "advice": advice_of(self.config["advice"]),
            "same_transducer": same_transducer,
        }
        return compared(visits, speeds, self.settings, **about)


def given_by(
    config: Mapping, facts: Mapping[str, Sequence[float]] | None = None
) -> tuple[Given, list[str]]:
    """Return what a configuration gives beside records, and what to say of it.

    Args:
        config: The configuration.
        facts: Those that a command gives go before those of the configuration.

    Raises:
        ValueError: If a fact is of nothing that is inferred.
    """
    known = {**config["known"], **(facts or {})}
    if wrong := [name for name in known if name not in KNOWN_VALUES]:
        raise ValueError(
            f"known: {wrong[0]} is not inferred, so no fact narrows it. Known can be: "
            f"{', '.join(KNOWN_VALUES)}"
        )
    usual = defaults()
    if all(config[key] == usual[key] for key in ("prior", "size")):
        return Given(known=known), []
    from breaker.model.prior import Prior

    prior = Prior.from_settings(config["prior"])
    words = ["prior and size are the configuration's"]
    return Given(Size(**config["size"]), prior, known), words
