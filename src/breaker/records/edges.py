"""Edges of channels beside the travel: when a main contact touched or parted, and the trigger came.

The channels may be of any kind and unit: a voltage over or a current through the contact, its
resistance, a binary input, a coil's current. So an edge is told by the channel's own levels alone,
and a state counts once it lasts 0.2 ms: shorter is a disturbance. Of contacts that bounce, it is
the first touch that counts.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from breaker.files import SWITCHING, Operation, label_of
from breaker.records.errors import UnusableError
from breaker.records.located import LocatedMotion

_EARLY = 1.0  # ms, by which the first motion may be read late
_LASTS = 0.2  # ms
_CLEAR = 6.0  # sd of the noise, by which levels must differ
_FEWEST = 3  # samples of a level
_RISES = 0.1, 0.2  # of a trigger, between which its rise is straight


class Contact(NamedTuple):
    """When the contact touched or parted, and what started the motion.

    Attributes:
        time: Of the contact in the record, ms; nan if unknown.
        sd: Standard deviation of its error, ms.
        trigger: When the coil was energised, ms; nan if unknown.
        settles: When the contact changes its state for the last time, ms; nan if unknown.
    """

    time: float = np.nan
    sd: float = np.nan
    trigger: float = np.nan
    settles: float = np.nan


def events_of(
    operation: Operation,
    settings: Mapping,
    located: LocatedMotion,
    channels: Mapping[str, np.ndarray],
) -> tuple[Contact, list[str]]:
    """Return contact's time and trigger of a motion: as the operation states, or by channels.

    Args:
        operation: What the table of operations says.
        settings: The section ``endurance.format``, complete.
        located: The motion.
        channels: Those of ``"contact"`` and ``"trigger"`` that the record has, ``(n,)``.

    Returns:
        Contact and trigger, and what is doubtful about channels, in words.

    Raises:
        UnusableError: If a time that the table states cannot be one of this motion.
    """
    motion, time, inside, moves = located.motion, located.time, located.inside, located.moves
    said = []
    switching, trigger, settles = operation.switching, operation.trigger, np.nan
    sd = settings["timing_sd"]
    if not np.isnan(switching):
        _check_stated(SWITCHING[motion], switching, moves - _EARLY, time[inside][-1], moves)
    elif "contact" in channels:
        switching, settles = switching_of(time[inside], channels["contact"][inside], moves)
        sd = float(np.hypot(sd, located.step / np.sqrt(12.0)))  # it is between two samples
        if not switching >= moves - _EARLY:
            said.append(_not_seen("contact", settings, f"switch during the {motion}"))
            switching = settles = np.nan
    if not np.isnan(trigger):
        _check_stated("trigger", trigger, -np.inf, moves, moves)
    elif "trigger" in channels:
        trigger = trigger_of(time[inside], channels["trigger"][inside], moves)
        if np.isnan(trigger):
            said.append(_not_seen("trigger", settings, f"rise before the {motion}"))
    elif settings["trigger_column"] == 0 and inside.start == 0 and moves >= 0.0:
        trigger = 0.0
    return Contact(switching, np.nan if np.isnan(switching) else sd, trigger, settles), said


def _check_stated(name: str, stated: float, least: float, most: float, moves: float) -> None:
    """Refuse a time in the table that is not where it must be in the record."""
    if not least <= stated <= most:
        raise UnusableError(
            f"{name} is {stated:g} ms in operations.csv, but the first motion is at {moves:.1f} ms "
            "of the file's time; state it in that time, or leave it empty"
        )


def _not_seen(kind: str, settings: Mapping, does: str) -> str:
    column = label_of(settings[f"{kind}_column"])
    return f"{column} does not {does}: see endurance.format.{kind}_column"


def switching_of(time: np.ndarray, contact: np.ndarray, moves: float) -> tuple[float, float]:
    """Return when the contact of a motion first leaves its state, and when it does so for the last
    time, ms; nan if that is not seen.

    The contact keeps its state of before the first motion up to the switching, and has another one
    in the last quarter of the time after the first motion. Long before it may bounce from the
    motion before.

    Args:
        time: Times of the motion, ``(n,)``, ms, evenly spaced.
        contact: Channel of the contact, ``(n,)``; nan where a sample is missing.
        moves: Time of the first motion, ms.
    """
    before = contact[time < moves]
    after = contact[time > moves + 0.75 * (time[-1] - moves)]
    (first, noise), (last, other) = _level(before), _level(after)
    if not abs(last - first) > _CLEAR * max(noise, other):
        return np.nan, np.nan
    own = time >= moves - _EARLY - _LASTS
    time, share = time[own], (contact[own] - first) / (last - first)
    # Backwards, the channel leaves its last state where it last came to it.
    return _reaches(time, share, 0.5), _reaches(time[::-1], 1.0 - share[::-1], 0.5)


def trigger_of(time: np.ndarray, trigger: np.ndarray, moves: float) -> float:
    """Return when a trigger's channel begins to leave its rest before a motion, ms; nan if never.

    Its rest is that in the first tenth of the time before the first motion, at least 1 ms. A
    coil's current rises slowly: the line through 10 and 20 % of its rise leads back to the rest.

    Args:
        time, moves: As for ``switching_of``.
        trigger: Channel of the trigger or of the coil's current, ``(n,)``; nan where missing.
    """
    lead = time < moves
    time, trigger = time[lead], trigger[lead]
    if time.size < _FEWEST:
        return np.nan
    rest, noise = _level(trigger[time <= time[0] + max(1.0, 0.1 * (moves - time[0]))])
    away = np.abs(trigger - rest)
    most = np.nanmax(away) if np.isfinite(away).any() else np.nan
    if not most > 2 * _CLEAR * noise:
        return np.nan
    # At first the current of the motion before may end.
    own = slice(int((away <= _RISES[0] * most).argmax()), None)
    low, high = (_reaches(time[own], away[own] / most, level) for level in _RISES)
    return low - (high - low) * _RISES[0] / (_RISES[1] - _RISES[0])


def _level(samples: np.ndarray) -> tuple[float, float]:
    """Median and sd of the noise of a level; nan if there are too few samples."""
    samples = samples[~np.isnan(samples)]
    if samples.size < _FEWEST:
        return np.nan, np.nan
    middle = np.median(samples)
    return float(middle), float(np.median(np.abs(samples - middle)) / 0.6745)


def _reaches(time: np.ndarray, share: np.ndarray, level: float) -> float:
    """First time at which a share ``(n,)`` reaches a level for as long as it has to last.

    Between two samples by a straight line; nan if it is there from the beginning, or never is.
    """
    there = ~np.isnan(share)
    time, share = time[there], share[there]
    step = float(np.median(np.abs(np.diff(time))))
    lasts = max(1, round(_LASTS / step))
    beyond = share >= level
    runs = np.lib.stride_tricks.sliding_window_view(beyond, lasts).all(axis=1)
    first = int(runs.argmax())
    if not runs.any() or first == 0:
        return np.nan
    low, high = share[first - 1], share[first]
    return float(time[first - 1] + (time[first] - time[first - 1]) * (level - low) / (high - low))
