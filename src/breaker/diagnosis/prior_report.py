"""A fitted prior in words: a report, and the lines of configuration that hold it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace

import numpy as np
import yaml

from breaker.common.numerals import in_digits
from breaker.common.parts import Document, Remark, Section, Table
from breaker.common.terminal import text_of
from breaker.configuration.loading import defaults
from breaker.diagnosis.prior_checks import Finding
from breaker.diagnosis.type_prior import FittedPrior
from breaker.diagnosis.type_records import Recorded, Span
from breaker.family.networks import StateNetwork
from breaker.model.parameters import MOTIONS, NAMES, PARAMETERS, Parameter
from breaker.model.sensor import Sensor

# mm of the reference drive, sd of what a model leaves out of records of little noise, at the least.
_LEFT_OUT = 0.02
_REST = 2.0  # times the longest motion, after which the rest tells no more
_WHOLE = 1e-3  # of a step, by which one may be off whole samples
_BEFORE = 0.1  # share of the usual time before the first motion, that a grid has at the least
_FORM = "  {:8}{:8}{:>8} {:>8} {:>16} {:>9} {:>9} {:>9} {:>9} {:>8}"
_ABOUT = {
    "size": ["# Size of the drive beside the default drive."],
    "prior": [
        "# Medians, and sds of the logarithms: spread between breakers, what is not known of the",
        "# type, and room for wear.",
    ],
    "contact_lag": [
        "# By how much contacts touch and part later than travels lead to expect: mean and sd, in",
        "# durations from 10 to 50 % of the way.",
    ],
    "sensor": [
        "# Time grid within the records, and errors at this size; the noise is that of the",
        "# records, and a little that no model explains.",
    ],
    "family": ["# Family of drives that the records are like."],
    "endurance": ["# How the files are read."],
}


def words_of_prior(
    recorded: Recorded, fitted: FittedPrior, checks: Mapping[str, Sequence[Finding]]
) -> Document:
    """Return what was found, in words."""
    checked = _checked(checks, recorded)
    return Document(parts=[_sources(recorded), Section(parts=[_table(fitted)]), *checked])


def overlay_of(
    recorded: Recorded, fitted: FittedPrior, sensor: Mapping, format_settings: Mapping
) -> dict:
    """Return what the configuration has to hold for the type.

    Args:
        sensor: The section ``sensor`` of drives of size 1.
        format_settings: What of the section ``endurance.format`` the records need beside defaults.
    """
    size, prior, motions = recorded.size, fitted.prior, recorded.motions
    usual = Sensor(**sensor).sized(size)
    seen = recorded.noise_sd if np.isfinite(recorded.noise_sd) else usual.noise_sd
    noise_sd = float(np.hypot(seen, _LEFT_OUT * size.lengths))
    sized = asdict(replace(grid_within(recorded.span, usual), noise_sd=noise_sd))
    pairs = zip(NAMES, prior.medians, prior.log_sds, strict=True)
    lag = {m: [_rounded(e, 4) for e in each] for m, each in fitted.contact_lag.items()}
    return {
        "size": {name: _rounded(getattr(size, name), 6) for name in ("lengths", "times")},
        "prior": {
            name: {"median": _rounded(median, 5), "log_sd": _rounded(log_sd, 3)}
            for name, median, log_sd in pairs
        },
        **({"contact_lag": lag} if lag else {}),
        "sensor": {name: _rounded(value, 6) for name, value in sized.items()},
        **_family_settings(recorded.levels),
        **({"motions": motions} if len(motions) < len(MOTIONS) else {}),
        **({"endurance": {"format": dict(format_settings)}} if format_settings else {}),
    }


def grid_within(span: Span, usual: Sensor) -> Sensor:
    """Return a sensor with a grid that records hold, in whole samples of theirs.

    It is no longer than the usual one, nor than the longest motion with its rest.

    Example:
        >>> usual = Sensor(-8.0, 232.0, 151, noise_sd=1.0, onset_sd=1.2, zero_sd=1.0)
        >>> found = grid_within(Span(before=55.0, lasts=90.0, after=145.5, step=0.1), usual)
        >>> found.start, found.stop, found.samples, round(float(np.diff(found.times)[0]), 6)
        (-8.0, 144.9, 140, 1.1)
    """
    start = max(usual.start, min(-span.before, _BEFORE * usual.start))
    stop = min(usual.stop, _REST * span.lasts, span.after)
    finest = (stop - start) / (usual.samples - 1)
    step = span.step * np.ceil(finest / span.step - _WHOLE)
    samples = int((stop - start) / step + _WHOLE) + 1
    stop = float(f"{start + step * (samples - 1):.6g}")
    return replace(usual, start=start, stop=stop, samples=samples)


def _family_settings(levels: StateNetwork) -> dict:
    """The section ``family`` of drives that the records are like, where it is not the default."""
    name = levels.settings["family"]
    return {} if name == defaults()["family"]["name"] else {"family": {"name": name}}


def _rounded(value: float, digits: int) -> float:
    return value if isinstance(value, int) else float(f"{value:.{digits}g}")


def overlay_text(
    overlay: Mapping, recorded: Recorded, checks: Mapping[str, Sequence[Finding]]
) -> str:
    """Return the commented lines of YAML of what ``overlay_of`` returns."""
    title = "Prior of a type of breaker, fitted by `breaker fit-prior`."
    first = replace(_sources(recorded), title=title)
    said = text_of(Document(parts=[first, *_checked(checks, recorded)]))
    blocks = ["\n".join(f"# {line}".rstrip() for line in said.splitlines())]
    for section, values in overlay.items():
        lines = [_yaml({section: values})]
        if section == "prior":
            lines = ["prior:", *map(_prior_line, PARAMETERS, values.values())]
        blocks.append("\n".join([*_ABOUT.get(section, []), *lines]))
    return "\n\n".join(blocks) + "\n"


def _sources(recorded: Recorded) -> Section:
    """What the prior was made from."""
    records, size = recorded.records, recorded.size
    lines = []
    for motion in recorded.motions:
        counts = [len(each[motion]) for each in records.values() if motion in each]
        of = "one breaker" if len(counts) == 1 else f"{len(counts)} breakers"
        lines.append(f"{sum(counts)} records of {motion} of {of}")
    lines.append(
        f"lengths are about {in_digits(size.lengths, 3)} times, times {in_digits(size.times, 3)} "
        "times those of the "
        "reference drive"
    )
    if recorded.left_out:
        lines.append(
            f"{recorded.left_out} more records of these breakers were not needed: of "
            "each, some were taken, spread over all"
        )
    if np.isfinite(recorded.noise_sd):
        lines.append(f"noise of a sample {in_digits(recorded.noise_sd, 3)} mm")
    if len(recorded.types) > 1:
        lines.append(
            f"WARNING: records are of types {', '.join(recorded.types)}, and the prior is as wide "
            "as these differ: choose one with --type"
        )
    lines += [f"type: {each}" for each in recorded.types if len(recorded.types) == 1]
    return Section(parts=[*lines, "breakers: " + ", ".join(records)])


def _table(fitted: FittedPrior) -> Table:
    """Medians and log-sds, beside those of the default prior at the size, and their parts."""
    prior, reference, rows = fitted.prior, fitted.reference, []
    learned = fitted.learned
    parts = np.array([learned.spread, learned.known, learned.shared, fitted.room])
    for i, each in enumerate(PARAMETERS):
        of = (f"{value:.3f}" for value in parts[:, i])
        fit = f"{prior.medians[i]:.4g}", f"{prior.log_sds[i]:.3f}"
        default = f"{reference.medians[i]:.4g}", f"{reference.log_sds[i]:.3f}"
        rows.append((each.name, each.unit, *fit, *of, *default))
    of = ("of it: between", "not known", "shared", "wear")
    return Table(("", "", "median", "log_sd", *of, "default", "log_sd"), rows, form=_FORM)


def _checked(checks: Mapping[str, Sequence[Finding]], recorded: Recorded) -> list[Section]:
    """What checks found, and which records were rejected."""
    parts: list = []
    for name, findings in checks.items():
        parts.append(f"{name}:")
        parts += [Remark(text, "  " if good else "  WARNING: ") for text, good in findings]
    rejected = [f"  {each}" for each in recorded.rejected]
    title = f"rejected records: {len(rejected)}"
    return [Section(parts=parts), *([Section(title, rejected)] if rejected else [])]


def _prior_line(parameter: Parameter, values: Mapping[str, float]) -> str:
    pair = f"  {parameter.name}: {_yaml(values)}"
    return f"{pair:45s}# {parameter.unit.replace('²', '^2'):9s} {parameter.meaning}"


def _yaml(value: object) -> str:
    """Keys and values, a section in braces on its line."""
    text = yaml.safe_dump(value, default_flow_style=None, allow_unicode=True, sort_keys=False)
    return text.strip()
