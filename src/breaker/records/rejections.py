"""Why a record cannot be used, and what is doubtful about one that is used."""

from collections.abc import Sequence

_TEXTS = {
    "doubtful-samples": "{count} samples that no sensor of this stroke gives: {places}",
    "no-drive": "{stroke} mm in {lasts} ms, {speed} m/s, is no {motion} of a breaker's drive: "
    "check the rate or unit of the time, and the unit or ratio of the travel",
    "ends-going-back": "ends while the travel goes back, at {share} of the greatest speed",
    "open-rest-unseen": "ends before the open breaker rests: its last reading stands for that rest",
    "open-rest-off": "the open breaker rests at {rest} mm, which is no zero: set "
    "endurance.format.zero to its reading, or to rest, if sensor.zero_sd is less",
    "rest-before-off": "rests at {rest} mm before the {motion}, which is no zero: set "
    "endurance.format.zero to its reading, or to rest",
    "repeated": "the readings from {first} ms on come again from {again} ms on: were samples sent "
    "twice?",
    "noisy-there": "noise of {noise} mm at {at} ms, far more than elsewhere",
    "grows": "the reading is {way} mm off its rest at {at} ms, more than before: a drive that "
    "settles swings less and less, so was the transducer disturbed?",
    "stops-at-speed": "the travel stops at {at} ms at {share} of its greatest speed, and is flat "
    "behind it: does the range of the transducer end there? If so, the stroke is longer",
    "starts-at-speed": "the travel starts at {at} ms at {share} of its greatest speed, and is flat "
    "before it: does the range of the transducer end there? If so, the stroke is longer",
    "few-at-rest": "too little rest before the motion to see the noise",
    "noisier": "the noise at rest is {noise} mm, more than sensor.noise_sd, {noise_sd:g} mm; raise "
    "it, or the parameters are less certain than inferred",
    "calmer": "the noise at rest is {noise} mm, far less than sensor.noise_sd, {noise_sd:g} mm: "
    "lower it, or is the record filtered?",
    "coloured": "the noise at rest is correlated over {memory} ms, and at a step of the grid by "
    "{colour:.2f}: record without a filter, or raise sensor.noise_sd",
    "drifts": "the reading drifts at rest, by {drift} m/s: {way} mm over the grid",
    "odd-end": "the {which} time, {time} ms, does not follow: one even step does",
    "uneven": "the times are off even steps of {step} ms by up to {off} ms",
}


class Remark(str):
    """What is doubtful about a record, in words; made of a template by the values in it.

    Attributes:
        code: Name of the kind.
        values: The values in its text, by name.

    Example:
        >>> remark = Remark("noisy-there", noise="0.3", at="12.5")
        >>> print(remark)
        noise of 0.3 mm at 12.5 ms, far more than elsewhere
        >>> remark.code
        'noisy-there'
    """

    code: str
    values: dict

    def __new__(cls, code: str, **values: object) -> "Remark":
        remark = super().__new__(cls, _TEXTS[code].format(**values))
        remark.code, remark.values = code, values
        return remark


class UnusableError(ValueError):
    """A record that cannot be used, and the line of its file that shows it, if there is one."""

    def __init__(self, reason: str, *, line: int | None = None) -> None:
        super().__init__(reason)
        self.line = line


class SeveralMotionsError(UnusableError):
    """A record with a motion more than once, and the parts that hold each of them, ms."""

    def __init__(self, reason: str, parts: Sequence[tuple[float, float]]) -> None:
        super().__init__(reason)
        self.parts = parts


class NotShownError(ValueError):
    """A value that the curve does not show."""
