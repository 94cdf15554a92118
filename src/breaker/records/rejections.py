"""Reasons to reject a record, and remarks on doubts about records that are used."""

from collections.abc import Sequence
from statistics import NormalDist

FALSE = 1.25e-4
"""False-alarm rate of a check by a statistic, on good records."""

MATTERS = 0.003
"""Largest error, strokes, that changes no quantity by more than its usual error."""

FEWEST = 12
"""Fewest samples from which a level or noise is estimated."""


def normal_sds(count: int) -> float:
    """Return the sds that the largest of ``count`` white values exceeds at the rate ``FALSE``."""
    return -NormalDist().inv_cdf(0.5 * FALSE / max(count, 1))


DISTURBED = {"no-drive", "range-ends", "unsteady"}
"""Codes of remarks that must accompany every value of the record."""

TEXTS = {
    "doubtful-samples": "{count} samples that no sensor of this stroke gives: {places}",
    "no-drive": "{stroke} mm in {lasts} ms, {speed} m/s, is not possible for a {motion}: check the "
    "rate or unit of the time, and the unit or ratio of the travel",
    "range-ends": "at one rest the reading is at exactly {level} mm, too often for its noise: the "
    "range of the transducer ends within the stroke",
    "unsteady": "at rest the reading moves by {way} mm: is there hum, a drift or a vibration?",
    "open-rest-unseen": "ends before the open breaker rests: its last reading stands for that rest",
    "open-rest-off": "the open breaker rests at {rest} mm, not at zero: set "
    "endurance.format.zero to its reading, or to rest, if sensor.zero_sd is less",
    "ripples": "during the motion the reading ripples by {rms} mm (rms), as on an elastic linkage: "
    "it counts as noise of the sensor",
    "few-at-rest": "too little rest before the motion to see the noise",
    "noisier": "the noise at rest is {noise} mm, more than sensor.noise_sd, {noise_sd:g} mm; raise "
    "it, or the parameters are less certain than inferred",
    "calmer": "the noise at rest is {noise} mm, far less than sensor.noise_sd, {noise_sd:g} mm: is "
    "the travel filtered? Lower it for the workflow; no command on records uses it",
    "coloured": "the noise at rest is correlated by {colour:.2f} at a step of the grid: record "
    "without a filter, or raise sensor.noise_sd",
    "uneven": "the times are off even steps of {step} ms by up to {off} ms",
    "onset-vague": "the first motion is certain to ±{sd} ms only, more than sensor.onset_sd, "
    "{assumed:g} ms: does the travel move before it, by hum or a drift?",
}


class Remark(str):
    """Doubt about a record, as a text made from a template and values.

    Attributes:
        code: Code of the remark.
        values: Values in the text, by name.
    """

    code: str
    values: dict

    def __new__(cls, code: str, **values: object) -> "Remark":
        remark = super().__new__(cls, TEXTS[code].format(**values))
        remark.code, remark.values = code, values
        return remark


class UnusableError(ValueError):
    """Record that cannot be used; ``line`` is the line of its file with the reason, if any."""

    def __init__(self, reason: str, *, line: int | None = None) -> None:
        super().__init__(reason)
        self.line = line


class SeveralMotionsError(UnusableError):
    """Record with a motion more than once, and the parts that contain these motions, ms."""

    def __init__(self, reason: str, parts: Sequence[tuple[float, float]]) -> None:
        super().__init__(reason)
        self.parts = parts


class OtherMotionError(UnusableError):
    """Record that states or shows only another motion than requested."""


class NotShownError(ValueError):
    """Value that the curve does not show."""
