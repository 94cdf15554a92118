"""Keys of the configuration that must fit each other: ``RULES``, which a schema cannot say.

Each complaint says in plain words what is wrong with the first of its keys, and the remedy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from breaker.mechanism import MOTIONS, complaint_of_list
from breaker.records import csv_files

__all__ = ["RULES", "Rule"]


@dataclass(frozen=True)
class Rule:
    """A condition on several keys.

    Attributes:
        keys: Keys in dotted form. A message is about the first of them.
        complaint: Takes the values of the keys; says what is wrong and the remedy, or None.
    """

    keys: tuple[str, ...]
    complaint: Callable[..., str | None]


def _same_seed(second: int, first: int) -> str | None:
    if second != first:
        return None
    return f"is {second}, which validation.seed is too. A second look needs another number."


def _bank_too_small(shards: int, curves: int, *needs: int) -> str | None:
    if shards * curves >= sum(needs):
        return None
    return (
        f"is {shards}: with bank.curves_per_shard {curves} the bank has {shards * curves} curves, "
        f"but a training needs {sum(needs)} (batch + validation_curves + held_out_curves). "
        "Raise either of the two, or lower one of the three."
    )


def _never_evaluated(every: int, steps: int) -> str | None:
    if every <= steps:
        return None
    return f"is {every}, but the training ends after {steps} steps. Lower it, or raise steps."


def _too_many_components(components: int, samples: int) -> str | None:
    if components <= samples:
        return None
    return f"is {components}, but a curve has {samples} samples (sensor.samples). Lower it."


def _uneven_layers(
    channels: Sequence, kernels: Sequence, strides: Sequence, kind: str
) -> str | None:
    lengths = [len(channels), len(kernels), len(strides)]
    if kind != "time_series" or len(set(lengths)) == 1:
        return None
    return (
        "has {} entries, kernels has {} and strides {}. All three need one entry for each "
        "convolution.".format(*lengths)
    )


def _too_short_to_skip(
    skip: int, kernels: Sequence[int], strides: Sequence[int], samples: int, kind: str
) -> str | None:
    if kind != "time_series" or len(kernels) != len(strides):
        return None  # unequal lengths are another rule's complaint
    steps = samples
    for kernel, stride in zip(kernels, strides, strict=True):
        steps = max(0, (steps - kernel) // stride + 1)
    if skip <= steps:
        return None
    return f"is {skip}, but the convolutions leave {steps} steps. Lower it, a kernel or a stride."


def _too_short_to_interpolate(samples: int, *kinds: str) -> str | None:
    if samples >= 4 or "deep_set" not in kinds:
        return None
    return f"is {samples}, but summary.kind deep_set interpolates between 4 samples. Raise it."


def _reference_too_coarse(reference: int, candidates: Sequence[int]) -> str | None:
    if reference > max(candidates):
        return None
    return f"is {reference}, but must be more than any of solver.candidates ({max(candidates)})."


def _at_most(limit: str) -> Callable[[int, int], str | None]:
    """Return the complaint of a rule that the first key must not exceed the second, ``limit``."""

    def complaint(value: int, most: int) -> str | None:
        if value <= most:
            return None
        return f"is {value}, but must not exceed {limit} ({most}). Lower it, or raise {limit}."

    return complaint


def _not_a_range(ends: Sequence[float]) -> str | None:
    low, high = ends
    return None if low < high else f"is {list(ends)}, but the first must be less than the second."


def _change_outside_life(ends: Sequence[float]) -> str | None:
    if ends[1] < 1:
        return None
    return f"is {list(ends)}, but a wear that changes has to do so within the life, below 1."


def _no_curves(curves: str | None, motions: Sequence[str]) -> str | None:
    if curves is None:
        return None
    folders = [Path(curves, motion) for motion in motions]
    empty = [f"{folder}/" for folder in folders if not csv_files(folder)]
    if not empty:
        return None
    return (
        f"is {curves}, but there is no CSV file in {' nor in '.join(empty)}. Name a folder with a "
        "subfolder of CSV files for each motion, or null for the synthetic stand-in."
    )


def _rules_of(motion: str) -> tuple[Rule, ...]:
    network, training = f"network.{motion}.summary", f"training.{motion}"
    needs = (f"{training}.{key}" for key in ("batch", "validation_curves", "held_out_curves"))
    series, kind, samples = f"{network}.time_series", f"{network}.kind", "sensor.samples"
    channels, kernels, strides = (f"{series}.{key}" for key in ("channels", "kernels", "strides"))
    return (
        Rule(("bank.shards", "bank.curves_per_shard", *needs), _bank_too_small),
        Rule((f"{training}.evaluate_every", f"{training}.steps"), _never_evaluated),
        Rule((f"{network}.components", samples), _too_many_components),
        Rule((channels, kernels, strides, kind), _uneven_layers),
        Rule((f"{series}.skip", kernels, strides, samples, kind), _too_short_to_skip),
    )


RULES = (
    *(rule for motion in MOTIONS for rule in _rules_of(motion)),
    Rule(
        ("sensor.samples", *(f"network.{motion}.summary.kind" for motion in MOTIONS)),
        _too_short_to_interpolate,
    ),
    Rule(("solver.reference", "solver.candidates"), _reference_too_coarse),
    Rule(("validation.second_seed", "validation.seed"), _same_seed),
    *(
        Rule((key, limit), _at_most(limit))
        for key, limit in (
            ("validation.judged_curves", "validation.curves"),
            ("correction.smallest_size", "correction.draws"),
            ("correction.fit_size", "correction.round_draws"),
            ("alarm.clear", "alarm.raise"),
            ("wear_model.notice", "wear_model.horizon"),
            ("wear_model.baseline", "endurance.operations_per_job"),
            ("lives.operations", "wear_model.horizon"),
        )
    ),
    Rule(("limits", "motions"), complaint_of_list),
    *(Rule((f"lives.{key}",), _not_a_range) for key in ("ratio", "change", "drift", "scatter")),
    Rule(("lives.change",), _change_outside_life),
    Rule(("endurance.curves", "motions"), _no_curves),
)
