"""Edges of channels beside the travel: when a main contact touched or parted, and the trigger came.

The channels may be of any kind and unit: a voltage over or a current through the contact, its
resistance, a binary input, a coil's current. So an edge is told by the channel's own levels alone,
and a state counts once it lasts 0.2 ms: shorter is a disturbance. Of contacts that bounce, it is
the first touch that counts.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from breaker.records.fits import running_median
from breaker.records.motion import LocatedMotion
from breaker.records.words import label_of

_EARLY = 1.0  # ms, by which the first motion may be read late
_LASTS = 0.2  # ms
_CLEAR = 6.0  # sd of the noise, by which levels must differ
_FEWEST = 3  # samples of a level
_RESISTS = 5.0  # ratio of the levels of a resistance, of which the logarithm counts
_NEAR, _FLAT = 0.1, 0.05  # of an edge: ends of it, and what a level between them keeps
_NOT_OPEN, _NOT_CLOSED = 0.02, 0.85  # shares of the change of a resistance, where contacts arc
_BESIDE, _SOON = 1.0, 0.5  # ms beside an edge that tell that resistance; contacts as one
_RISES = 0.1, 0.25  # of a trigger: below which it rests, and up to which its rise is straight
_HIDDEN, _WINDOW = 0.02, 4.0  # share of a rise that is rest; rises, of the window that is fitted
_UNSEEN = 1.0  # ms, sd of a trigger that came with the first sample
_SLOWEST = 100.0  # ms, from trigger to the first motion: no breaker takes longer


class ContactTimes(NamedTuple):
    """Times of the contact in a record, in ms; nan where unknown or withheld.

    Attributes:
        time, sd: Counted touch or separation, at which the current starts or stops, and the
            standard deviation of its error.
        main, main_sd: Touch or separation of the main contact, where an arcing contact differs.
        arcing, arcing_sd: Touch or separation of the arcing contact.
        trigger, trigger_sd: When the coil was energised.
        bounces: Number of interruptions after the first touch.
        bounce_time: Time from the first touch to the last.
        why: Reason for which the contact times are withheld; empty otherwise.
    """

    time: float = np.nan
    sd: float = np.nan
    main: float = np.nan
    main_sd: float = np.nan
    arcing: float = np.nan
    arcing_sd: float = np.nan
    trigger: float = np.nan
    trigger_sd: float = 0.0
    bounces: float = np.nan
    bounce_time: float = np.nan
    why: str = ""


def events_of(
    settings: Mapping, located: LocatedMotion, channels: Mapping[str, np.ndarray]
) -> tuple[ContactTimes, list[str]]:
    """Return contact's time and trigger of a motion, by channels.

    Args:
        settings: The section ``endurance.format``, complete.
        located: The motion.
        channels: Those of ``"contact"`` and ``"trigger"`` that the record has, ``(n,)``.

    Returns:
        Contact and trigger, and what is doubtful about channels, in words.
    """
    motion, time, inside, moves = located.motion, located.time, located.inside, located.moves
    said = []
    switching = trigger = settles = main = np.nan
    trigger_sd, sd = 0.0, settings["timing_sd"]
    if "contact" in channels:
        switching, settles, main = switching_of(
            time[inside], channels["contact"][inside], moves, motion
        )
        sd = float(np.hypot(sd, located.step / np.sqrt(12.0)))  # it is between two samples
        if not switching >= moves - _EARLY:
            said.append(_not_seen("contact", settings, f"switch during the {motion}"))
            switching = settles = main = np.nan
    if "trigger" in channels:
        trigger, trigger_sd = trigger_of(time[inside], channels["trigger"][inside], moves)
        if np.isnan(trigger):
            said.append(_not_seen("trigger", settings, f"rise before the {motion}"))
        elif moves - trigger > _SLOWEST:
            said.append(
                f"{label_of(settings['trigger_column'])} rises {moves - trigger:.0f} ms before the "
                f"first motion, which no breaker takes: it is no trigger of this {motion}"
            )
            trigger = np.nan
    elif settings["trigger_column"] == 0 and inside.start == 0 and moves >= 0.0:
        trigger = 0.0
    sd = np.nan if np.isnan(switching) else sd
    parts = (np.nan, np.nan) if np.isnan(main) else (switching, sd)
    bounce = settles - switching
    bounces = np.nan if np.isnan(bounce) else float(bounce > 0.0)
    main_sd = sd if np.isfinite(main) else np.nan
    times = switching, sd, main, main_sd, *parts, trigger, trigger_sd, bounces, bounce
    return ContactTimes(*times), said


def _not_seen(kind: str, settings: Mapping, does: str) -> str:
    column = label_of(settings[f"{kind}_column"])
    return f"{column} does not {does}: see endurance.format.{kind}_column"


def switching_of(
    time: np.ndarray, contact: np.ndarray, moves: float, motion: str
) -> tuple[float, float, float]:
    """Return when the contact of a motion first leaves its state, when it does so for the last
    time, and when its main contact does, ms; nan if that is not seen.

    The contact keeps its state of before the first motion up to the switching, and has another one
    in the last quarter of the time after the first motion. Long before it may bounce from the
    motion before. A level between both is that of an arcing contact, by whose touch and parting a
    pole counts: of a few milliohm it is closed beside an open one.

    Args:
        time: Times of the motion, ``(n,)``, ms, evenly spaced.
        contact: Channel of the contact, ``(n,)``; nan where a sample is missing.
        moves: Time of the first motion, ms.
        motion: "closing" or "opening".
    """
    there = contact[~np.isnan(contact)]
    resists = there.size > 0 and 0.0 < _RESISTS * there.min() < there.max()
    if resists:
        contact = np.log(contact)
    before = contact[time < moves]
    after = contact[time > moves + 0.75 * (time[-1] - moves)]
    (first, noise), (last, other) = _level(before), _level(after)
    if not abs(last - first) > _CLEAR * max(noise, other):
        return np.nan, np.nan, np.nan
    own = time >= moves - _EARLY - _LASTS
    time, share = time[own], (contact[own] - first) / (last - first)
    # Backwards, the channel leaves its last state where it last came to it.
    at, settles = _reaches(time, share, 0.5), _reaches(time[::-1], 1.0 - share[::-1], 0.5)
    if resists and (last < first) == (motion == "closing"):
        noise = (noise if motion == "closing" else other) / abs(last - first)
        arcing, main = _both_contacts(time, share, noise, motion)
        return (at, settles, np.nan) if np.isnan(main) else (arcing, settles, main)
    ends = _reaches(time, share, _NEAR), _reaches(time, share, 1.0 - _NEAR)
    between = share[(time > ends[0]) & (time < ends[1])]
    between = between[~np.isnan(between)]
    if between.size < _FEWEST or np.mean(np.abs(between - np.median(between)) < _FLAT) <= 0.5:
        return at, settles, np.nan
    early, late = ends
    return (early, settles, late) if motion == "closing" else (late, settles, early)


def _both_contacts(
    time: np.ndarray, share: np.ndarray, noise: float, motion: str
) -> tuple[float, float]:
    """When the arcing and the main contact of a resistance touch or part, ms; nan if as one.

    An open contact reads the end of the range, so that the least departure that its noise does not
    make is an arcing contact, however near that is to the end; its resistance is that beside the
    departure, and halfway from there to the closed one the main contact switches.

    Args:
        share: Of the change of the logarithm that is done, ``(n,)``; nan where a sample is missing.
        noise: That of the open contact, in such shares.
    """
    least = float(np.clip(_CLEAR * noise, _NOT_OPEN, 0.5))
    closing, there = motion == "closing", ~np.isnan(share)
    beside = max(_BESIDE, _FEWEST * float(time[1] - time[0]))
    time, share = time[there], share[there]
    arcing = _reaches(time, share, least if closing else 1.0 - least)
    after = time - arcing if closing else arcing - time
    near = share[(after > 0.0) & (after <= beside)]
    arcs = float(np.median(near)) if near.size else np.nan
    closed = arcs if closing else 1.0 - arcs  # share of the way to the resistance when closed
    if not closed < _NOT_CLOSED:
        return arcing, np.nan
    main = _reaches(time, share, 0.5 * (arcs + closing))
    return arcing, main if abs(main - arcing) > _SOON else np.nan


def trigger_of(time: np.ndarray, trigger: np.ndarray, moves: float) -> tuple[float, float]:
    """Return when a trigger's channel begins to leave its rest before a motion, and the standard
    deviation of that, ms; nan if it never does.

    Its rest is that in the first tenth of the time before the first motion, at least 1 ms. Many
    recorders start with the trigger, so that the channel has left its rest by then, or leaves it;
    then its rest is that at the end. A coil's current rises slowly: the line that fits the first
    part of its rise best leads back to the rest.

    Args:
        time, moves: As for ``switching_of``.
        trigger: Channel of the trigger or of the coil's current, ``(n,)``; nan where missing.
    """
    there = ~np.isnan(trigger)
    time, trigger = time[there], trigger[there]
    lead = time < moves
    if lead.sum() < _FEWEST:
        return np.nan, np.nan
    at_end = trigger[time > time[-1] - 0.25 * (time[-1] - moves)]
    time, trigger = time[lead], trigger[lead]
    at_first = trigger[time <= time[0] + max(1.0, 0.1 * (moves - time[0]))]
    found = _leaves(time, trigger, *_level(at_first))
    return found if np.isfinite(found[0]) else _leaves(time, trigger, *_level(at_end), begun=True)


def _leaves(
    time: np.ndarray, values: np.ndarray, rest: float, noise: float, *, begun: bool = False
) -> tuple[float, float]:
    """When values leave a rest, and the sd of that; nan if not for sure.

    Args:
        begun: Whether they may have left it with the first sample.
    """
    step = float(np.median(np.diff(time)))
    smooth = running_median(values - rest, 2 * max(1, round(_LASTS / step)) + 1)
    largest = int(np.abs(smooth).argmax())
    most = float(smooth[largest])
    if not abs(most) > 2 * _CLEAR * noise:
        return np.nan, np.nan
    share = smooth / most
    # At first the current of the motion before may end.
    own = int((share <= _RISES[0]).argmax()) if (share <= _RISES[0]).any() else 0
    first = _reaches(time[own:], share[own:], _RISES[1])
    if np.isnan(first):
        held = begun and share[0] > _RISES[1] and abs(rest + most) > abs(rest)  # a current
        return (float(time[0]), _UNSEEN) if held else (np.nan, np.nan)
    hidden = max(_HIDDEN, 2.0 * noise / abs(most))
    before = time[(time < first) & (share <= hidden)]
    rise = first - before[-1] if before.size else first - time[0]
    near = (time >= first - _WINDOW * max(rise, _LASTS)) & (time <= first + step)
    return _begins(time[near], (values[near] - rest) / most, max(noise / abs(most), 1e-3))


def _begins(time: np.ndarray, share: np.ndarray, noise: float) -> tuple[float, float]:
    """Where the line begins that, after zeros, fits shares ``(n,)`` best, and the sd of that."""
    step = float(np.median(np.diff(time)))
    starts = np.linspace(time[0] - step, time[-1], 400)
    ramps = np.maximum(time - starts[:, None], 0.0)
    slopes = (ramps @ share) / np.maximum(np.square(ramps).sum(axis=1), 1e-12)
    squares = np.square(share - slopes[:, None] * ramps).sum(axis=1) / noise**2
    weights = np.exp(-0.5 * (squares - squares.min()))
    weights /= weights.sum()
    at = float(weights @ starts)
    return at, float(np.hypot(np.sqrt(weights @ np.square(starts - at)), step / np.sqrt(12.0)))


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
