"""The diagnosis of one drive: from its files to estimates, verdicts, changes and a report.

Commands, the page, lives and fleets all use a ``Diagnosis``. It reads records by its settings, and
returns estimates, verdicts on limits, and changes since the earlier inspection.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from breaker.configuration.data_files import entry_of_type, laid_over
from breaker.configuration.loading import defaults
from breaker.diagnosis.estimate import KNOWN_VALUES, DriveRecord, Estimate, Given
from breaker.diagnosis.identity import phase_of, phases_left_out
from breaker.diagnosis.inference import Inference
from breaker.diagnosis.limits import Verdict, judged
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.result import Result, result_of
from breaker.diagnosis.sentences import say
from breaker.family.networks import StateNetwork, shipped_levels
from breaker.model.limits import Limit, from_list
from breaker.model.parameters import MOTIONS, Size
from breaker.model.prior import Prior
from breaker.model.quantities import OF_STROKE, Speed, speeds_at
from breaker.records.files import Files
from breaker.records.named import Choice, Operations, list_named, stated_types

if TYPE_CHECKING:
    from breaker.diagnosis.curves import Overlay
    from breaker.diagnosis.inspection_change import InspectionChange


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The configuration and the records of one drive, and all that is computed from them.

    Attributes:
        config: The configuration.
        limits: Entries of the section ``limits`` by which to judge.
        given: Size, prior and known values.
        families: Function that opens the state networks, in the order in which they are tried.
        types, type: Entries of types of breaker, and the type whose entry overrides the rest.
        reference: File of a good record of the type.
        records, before: Records of the inspection, and of the earlier one.
        overlays: Records compared with a good record.
        same_transducer: Whether both inspections have the same transducer and ratio.
        doubts: Warnings about the files of the records.
    """

    config: Mapping
    limits: Sequence[Mapping] = ()
    given: Given = field(default_factory=Given)
    families: Callable[[], Iterable[StateNetwork]] = shipped_levels
    types: Mapping[str, Mapping] = field(default_factory=dict)
    type: str = ""
    reference: str = ""
    records: Sequence[DriveRecord] = ()
    before: Sequence[DriveRecord] = ()
    overlays: "Sequence[Overlay]" = ()
    same_transducer: bool = False
    doubts: Sequence[str] = ()

    @property
    def settings(self) -> dict[str, int | float]:
        """Settings of estimates: "draws", "misfit_p_value" and "seed"."""
        section = self.config["endurance"] | {"seed": self.config["seed"]}
        return {name: section[name] for name in ("draws", "misfit_p_value", "seed")}

    def of_type(self, name: str) -> "Diagnosis":
        """Return the diagnosis of a type: its entry overrides configuration and limits.

        Raises:
            ConfigurationError: If there is no entry of the type.
        """
        entry = entry_of_type(self.types, name)
        config = laid_over({**self.config, "limits": self.limits}, entry)
        fields = {"limits": config["limits"], "reference": entry.get("reference") or ""}
        return replace(self, config=config, type=name, **fields)

    def of_files(
        self, named: Sequence[str], choice: Choice, files: Files | None = None, of_type: str = ""
    ) -> "Diagnosis":
        """Return the diagnosis of the drive in files and folders, with its records.

        If there are types, the entry of ``of_type`` counts, or else of the type that the table or
        the files state.

        Raises:
            FileNotFoundError, ValueError: As of ``list_named`` and ``of_type``.
        """
        files, settings = Files() if files is None else files, self.config["endurance"]
        listed = list_named(named, settings, choice, files)
        types = [of_type] if of_type else []
        if self.types and not of_type:
            types = stated_types(listed, settings["format"], files)
        if len(types) > 1:
            raise ValueError(say("several-types", types=", ".join(types)))
        diagnosis = self.of_type(*types) if types else self
        records = diagnosis.read(listed, choice.motions, files)
        chosen = choice.every or choice.phase or choice.channels
        doubts = [] if chosen else phases_left_out(records, files)
        return replace(diagnosis, records=records, doubts=doubts)

    def read(
        self, operations: Operations, motions: Sequence[str] = MOTIONS, files: Files | None = None
    ) -> list[DriveRecord]:
        """Read records: see ``read_operations``."""
        form = self.config["endurance"]["format"]
        return read_operations(operations, form, motions=motions, files=files)

    def speeds_of(self, records: Iterable[DriveRecord]) -> tuple[Speed, ...]:
        """Return the definitions of speeds of a drive: those for any record (``OF_STROKE``), and
        speeds between points of the configuration, or else of its files, or else over a distance
        that depends on its stroke. Return none for a drive without a usable record.
        """
        usable = [record for record in records if not record.reason]
        if not usable:
            return ()
        points = {**OF_STROKE, **self.config["speeds"]}
        stated = [record.stated.speeds for record in usable]
        for motion in MOTIONS:
            of_files = {tuple(speeds[motion].points) for speeds in stated if motion in speeds}
            if len(of_files) == 1 and points.get(f"{motion}_speed") is None:
                points[f"{motion}_speed"] = of_files.pop()
        return speeds_at(points, float(np.median([record.shape.stroke for record in usable])))

    @cached_property
    def estimates(self) -> list[Estimate]:
        """Estimates of the records, in their order."""
        return self.infer(self.records)

    def infer(self, records: Sequence[DriveRecord]) -> list[Estimate]:
        """Infer records, in their order."""
        inference = Inference(self.families, self.given, **self.settings)
        return inference.infer(records, self.speeds_of(records))

    @cached_property
    def result(self) -> Result:
        """Estimates and verdicts as data: see ``result_of``."""
        return result_of(self)

    def judge(self, estimates: Sequence[Estimate]) -> list[list[Verdict]]:
        """Return the verdicts of each estimate: see ``judged``."""
        limits = self.limits_on(estimates)
        return [judged(estimate, limits, seed=self.config["seed"]) for estimate in estimates]

    def limits_on(
        self, estimates: Sequence[Estimate], motions: Iterable[str] = MOTIONS
    ) -> list[Limit]:
        """Return the limits on motions of a drive; none without a usable record."""
        speeds = next((estimate.speeds for estimate in estimates if estimate.speeds), ())
        return from_list(self.limits, [*motions], speeds) if speeds else []

    @cached_property
    def changes(self) -> "dict[str, InspectionChange | str]":
        """Comparisons with the earlier inspection, by phase or channel, without limits. A phase
        that cannot be compared has a text with the reason.
        """
        from breaker.diagnosis.inspection_change import compare_inspections

        by_phase: dict[str, list[DriveRecord]] = {}
        for record in self.records if self.before else ():
            by_phase.setdefault(record.operation.phase, []).append(record)
        rejected = [record.reason for record in self.before if record.reason]
        unjudged, compared = replace(self, limits=()), {}
        for name, today in by_phase.items():
            phase = phase_of(today[0])
            before = [e for e in self.before if phase_of(e) == phase] or self.before
            try:
                if len(by_phase) > 1 and not phase:
                    raise ValueError(say("phases-needed"))
                compared[name] = compare_inspections(unjudged, {"before": before, "today": today})
            except ValueError as error:
                compared[name] = "; ".join([*rejected, str(error).splitlines()[0]])
        return compared


def given_by(config: Mapping, known: Mapping[str, Sequence[float]] | None = None) -> Given:
    """Return the size and prior of a configuration, with known values, ``{name: [value, sd]}``.

    Raises:
        ValueError: If the quantity of a known value is not inferred.
    """
    usual, known = defaults(), known or {}
    if wrong := [name for name in known if name not in KNOWN_VALUES]:
        raise ValueError(say("known-of-nothing", name=wrong[0], known=", ".join(KNOWN_VALUES)))
    if all(config[key] == usual[key] for key in ("prior", "size")):
        return Given(known=known)
    return Given(Size(**config["size"]), Prior.from_settings(config["prior"]), known)
