"""Times of contact touch or separation, and of the trigger, which energises the coil.

The contact makes when its test current starts to flow, and breaks when the current stops. While
current flows, a resistance beyond its range means that only the arcing contact conducts. Without a
current, a resistance switches at the end of its range, and any other signal at half of its step.
Times that the channels do not determine, or that contradict the travel, are replaced by a reason.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from breaker.records.motion import LocatedMotion
from breaker.records.noise import running_median, white_noise
from breaker.records.rejections import NotShownError
from breaker.records.words import holds, label_of, places_of

_LASTS = 0.2  # ms, shortest state of a contact; interference from switching is shorter
CLEAR = 6.0  # sd of noise, which white noise exceeds once in 5e8 samples
LEAST = 0.02  # share of a step, above offsets and hum of a test current or of a range's end
FEWEST = 3  # samples, the fewest with a median and a spread
_ARCING = 1e3  # largest ratio of resistances: arcing contact 20 milliohm, main contact 20 microohm
RESOLVED = 1.0  # ms, uncertainty of a first motion by definition, and shortest level of a contact
_RISE = 0.25  # share of a step up to which a test or coil current rises linearly
SETTLED = 0.75
"""Share of the time from the first motion on, after which the contact of a closing is at rest."""
SLOWEST = 100.0  # ms, longest time from trigger to first motion: any coil and latch are faster
_UNSEEN = "the contact does not switch during the motion"


class ContactTimes(NamedTuple):
    """Times of the contact in a record with the sds of their errors, ms; nan where unknown."""

    time: float = np.nan  # contact touch or separation: the current starts or stops
    sd: float = np.nan
    main: float = np.nan  # time of the main contact, where that of the arcing contact differs
    main_sd: float = np.nan
    arcing: float = np.nan
    arcing_sd: float = np.nan
    trigger: float = np.nan  # when the coil was energised
    trigger_sd: float = 0.0
    bounce_time: float = np.nan  # from the first touch to the last
    why: str = ""  # reason why there is no time of the contact; empty otherwise


class _Switch(NamedTuple):
    """Signal of a contact as a share of its step: 0 when open, 1 when closed; no sample missing."""

    time: np.ndarray  # (n,), ms
    share: np.ndarray  # (n,)
    noise: float  # sd of the share when open
    closing: bool  # whether touches count, as in a closing; else separations
    begin: float  # time from which on touches or separations count, ms

    @property
    def least(self) -> float:
        """Smallest share that is clear of the noise of the open contact."""
        return float(np.clip(CLEAR * self.noise, LEAST, _RISE))

    def edges(self, level: float) -> np.ndarray:
        """Return the times at which the share crosses a level, ``(m,)``, ms."""
        on = running_median((self.share >= level) * 1.0, _window(self.time)) > 0.5
        changes = np.flatnonzero((on[1:] != on[:-1]) & (on[1:] == self.closing))
        first, second = self.share[changes], self.share[changes + 1]
        part = np.clip((level - first) / np.where(first == second, 1.0, second - first), 0.0, 1.0)
        part = np.where(np.abs(second - first) > 0.5, 0.5, part)  # a jump may lie anywhere between
        times = self.time[changes] + part * (self.time[changes + 1] - self.time[changes])
        return times[times >= self.begin]

    def edge(self, level: float) -> float:
        """Return the first time at which the share crosses a level, ms; raise if it never does."""
        if not (result := self.edges(level)).size:
            raise NotShownError(_UNSEEN)
        return float(result[0])

    def open_edge(self) -> tuple[float, float]:
        """Return the time at which the signal leaves or reaches the open level, and its sd, ms.

        A current rises slowly, so a line through two small shares is extrapolated to that level.
        """
        low, high = self.edge(self.least), self.edge(2.0 * self.least)
        return 2.0 * low - high, self.sd(low, high - low)

    def sd(self, time: float, *spans: float) -> float:
        """Return the sd of a time, ms, uniform within spans and between two samples."""
        after = int(np.clip(np.searchsorted(self.time, time), 1, self.time.size - 1))
        spans = (*spans, float(self.time[after] - self.time[after - 1]))
        return float(np.sqrt(np.square(spans).sum() / 12.0))

    def counted(self, level: float, time: float, sd: float) -> ContactTimes:
        """Return a contact time with the bounces at a level; raise if an opening closes again."""
        switches = self.edges(level)
        lasts = float(np.ptp(switches))
        if not self.closing and lasts > RESOLVED:
            raise NotShownError(f"the contact closes again within {lasts:.1f} ms of separation")
        return ContactTimes(time, sd, bounce_time=lasts)


def events_of(
    settings: Mapping,
    located: LocatedMotion,
    channels: Mapping[str, np.ndarray],
    names: Sequence[str] | None = None,
) -> tuple[ContactTimes, list[str]]:
    """Return the times of contact and trigger of a motion, and remarks on doubtful times.

    Args:
        settings: The section ``endurance.format``, complete.
        located: The motion.
        channels: Channels ``"contact"``, ``"current"`` (test current) and ``"trigger"`` of the
            record, where present, ``(n,)``; nan where a sample is missing.
        names: Names of the columns of the file, where known.
    """
    time, moves, closing = located.time[located.inside], located.moves, located.motion == "closing"
    signals = {kind: channel[located.inside] for kind, channel in channels.items()}
    contact, remarks, column = ContactTimes(), [], settings["contact_column"]
    if "contact" in signals:
        places = places_of(names, column) if names else []
        name = names[places[0]] if len(places) == 1 else str(column)
        sides = (time < moves, time > moves + SETTLED * (time[-1] - moves))[:: -1 if closing else 1]
        begin = moves - max(RESOLVED, 3.0 * located.moves_sd)
        try:
            samples = signals["contact"], signals.get("current"), holds(name, "resistance")
            contact = times_of(time, *samples, sides, closing, begin)
            end = time[located.done >= 1.0 - LEAST][:1].min(initial=np.inf)
            if contact.time > end:
                reason = f"it switches at {contact.time:.1f} ms, after the travel has arrived"
                raise NotShownError(reason)
            if contact.main > end:
                contact = contact._replace(main=np.nan, main_sd=np.nan)
        except NotShownError as error:
            contact = ContactTimes(why=str(error))
        if contact.why:
            reason = f"{contact.why}; see endurance.format.current_column"
            remarks.append(f"{label_of(column)}: {reason}")
        for key in ("sd", "main_sd", "arcing_sd"):
            sd = float(np.hypot(settings["timing_sd"], getattr(contact, key)))
            contact = contact._replace(**{key: sd})
    if "trigger" in signals:
        trigger, sd = trigger_of(time, signals["trigger"], moves)
        if moves - trigger <= SLOWEST:
            contact = contact._replace(trigger=trigger, trigger_sd=sd)
        else:  # the trigger may belong to another motion
            reason = f"does not rise in the {SLOWEST:g} ms before the {located.motion}"
            remarks.append(f"{label_of(settings['trigger_column'])} {reason}")
    elif settings["trigger_column"] == 0 and located.inside.start == 0 and moves >= 0.0:
        contact = contact._replace(trigger=0.0)
    return contact, remarks


def times_of(
    time: np.ndarray,
    contact: np.ndarray,
    current: np.ndarray | None,
    resists: bool,
    sides: Sequence[np.ndarray],
    closing: bool,
    begin: float,
) -> ContactTimes:
    """Return the times of a contact; raise NotShownError if they are not shown or doubtful.

    With a test current, ``(n,)``, the channel, ``(n,)``, is a resistance; ``resists`` states it
    without one. ``sides`` are samples of the closed and the open contact, each ``(n,)`` of bool.
    """
    there = ~np.isnan(contact if current is None else current)
    time, contact, sides = time[there], contact[there], [side[there] for side in sides]
    if resists or current is not None:
        positive = contact[contact > 0.0]
        contact = np.log(np.maximum(contact, positive.min() if positive.size else 1.0))
    values = contact if current is None else current[there]
    (closed, spread), (opened, noise) = (_level(values[side]) for side in sides)
    step = abs(closed - opened)
    if not step > CLEAR * max(noise, spread):
        raise NotShownError(_UNSEEN)
    signal = _Switch(time, (values - opened) / (closed - opened), noise / step, closing, begin)
    if current is None and not resists:
        return _of_steps(signal)
    edge, sd = signal.open_edge()
    if current is not None and not closing:  # the contact separates during the fall
        falls = signal.edge(1.0 - _RISE)
        edge, sd = 0.5 * (edge + falls), signal.sd(edge, edge - falls)
    # Bounces count at a higher level for a current, which falls slowly and not to zero.
    edges = signal.counted(signal.least if current is None else _RISE, edge, sd)
    rest = _level(contact[sides[0]])[0]
    main, main_sd, arcing = _main(signal, contact, rest, edge)
    if current is None:
        return _of_range(signal, edges, (main, main_sd), (rest, arcing, opened))
    edge, sd = (edge, sd) if np.isfinite(main) else (np.nan, np.nan)
    return edges._replace(main=main, main_sd=main_sd, arcing=edge, arcing_sd=sd)


def _of_range(
    signal: _Switch,
    timed: ContactTimes,
    main: tuple[float, float],
    levels: tuple[float, float, float],
) -> ContactTimes:
    """Return the times of a resistance without a current, whose range may end below the resistance
    of the arcing contact, from the times at the end of the range, time and sd of the main contact,
    and the logarithms of the resistance of the closed, the arcing and the open contact.
    """
    rest, arcing, opened = levels
    step, distinct, (time, sd) = abs(rest - opened), np.isfinite(main[0]), timed[:2]
    if distinct and arcing - rest > np.log(_ARCING):  # a pre-insertion resistor
        return ContactTimes(*main, *main)
    if not distinct and step > np.log(_ARCING):
        return timed
    # Beyond the range's end, the contact conducts about as long as an e-fold takes, or a bounce.
    folds = abs(signal.edge(1.0 / step) - time)
    jumps = signal.closing and folds <= max(_LASTS, np.diff(signal.time[:2])[0])
    sd = signal.sd(time, 2.0 * max(folds, RESOLVED))
    if distinct and opened - arcing > 1.0 and not timed.bounce_time and not jumps:
        return ContactTimes(time, sd, *main, time, sd)
    if not distinct and np.isnan(arcing):  # otherwise ripple may hide the arcing contact
        main = timed[:2]
    reason = "the arcing contact may conduct beyond the range of the resistance"
    return ContactTimes(main=main[0], main_sd=main[1], why=reason)


def _of_steps(signal: _Switch) -> ContactTimes:
    """Return the times of a signal that steps, such as a voltage or a binary input.

    A lasting level nearer to the open contact is a pre-insertion resistor, which the threshold at
    half of the step ignores; a lasting level nearer to the closed contact is ambiguous.
    """
    edge, *ends = (signal.edge(level) for level in (0.5, signal.least, 1.0 - signal.least))
    between = signal.share[(signal.time > min(ends)) & (signal.time < max(ends))]
    if np.ptp(ends) > RESOLVED and np.median(between) > 0.5:
        raise NotShownError(f"it stays between open and closed for {np.ptp(ends):.1f} ms")
    return signal.counted(0.5, edge, signal.sd(edge, edge - signal.edge(1.0 - _RISE)))


def _main(
    signal: _Switch, logs: np.ndarray, low: float, counted: float
) -> tuple[float, float, float]:
    """Return the time of the main contact and its sd, ms, nan if not distinct from the arcing
    contact; and the level of the arcing contact, nan if there is none.

    ``logs`` are logarithms of the resistance, ``(n,)``, ``low`` that of the closed contact, and
    ``counted`` is the time at which the arcing contact switches, ms.
    """
    made = signal.time >= counted if signal.closing else signal.time <= counted
    made &= (signal.share >= signal.least) & ~np.isnan(logs)
    logs = logs[made]
    upper = logs > low + 1.0
    if upper.all() or not upper.any():
        return np.nan, np.nan, np.nan
    low, high = float(np.median(logs[~upper])), float(np.median(logs[upper]))
    middle = 0.5 * (low + high)
    if not high > low + 1.0:  # wear of a single sliding contact makes such a difference
        return np.nan, np.nan, high
    # The resistance of a sliding arcing contact rises, so its low quantile is the end of the step.
    top = np.exp(max(low + 1.0, np.quantile(logs[logs > middle], 0.1)))
    share = (top - np.exp(logs)) / (top - np.exp(low))
    main = signal._replace(time=signal.time[made], share=share)
    crossings = main.edges(0.5)
    if not crossings.size:
        return np.nan, np.nan, high
    edge, spread = float(crossings[0]), float(np.ptp(crossings))
    # The main contact is open once hardly any current flows through it.
    marks = main.edges(_RISE)
    last, first = [edge, *marks[marks <= edge]][-1], [*marks[marks >= edge], edge][0]
    edge = float(last if signal.closing else first)
    return edge, main.sd(edge, spread, main.edge(1.0 - _RISE) - edge), high


def trigger_of(time: np.ndarray, trigger: np.ndarray, moves: float) -> tuple[float, float]:
    """Return the time at which a trigger or coil current ``(n,)`` leaves its rest before a motion,
    and the sd, ms; nan if it does not.

    The rest is the level in the first tenth of the time before the first motion, at least 1 ms.
    Many recorders start with the trigger: then the rest is the level at the end.
    """
    there = ~np.isnan(trigger)
    time, lead = time[there], time[there] < moves
    if lead.sum() < FEWEST:
        return np.nan, np.nan
    count = 2 * _window(time) - 1
    smooth = running_median(trigger[there], count)
    least = white_noise(trigger[there]) * np.sqrt(0.5 * np.pi / count)  # sd of a running median
    ends = smooth[time > time[-1] - 0.25 * (time[-1] - moves)]
    begins = smooth[time <= time[0] + max(RESOLVED, 0.1 * (moves - time[0]))]
    time, smooth = time[lead], smooth[lead]
    for rest, spread in (_level(begins), _level(ends)):
        noise = max(least, spread)
        most = float((smooth - rest)[np.abs(smooth - rest).argmax()])
        if not abs(most) * _RISE > CLEAR * noise:
            continue
        signal = _Switch(time, (smooth - rest) / most, noise / abs(most), True, -np.inf)
        with suppress(NotShownError):
            return signal.open_edge()
    return np.nan, np.nan


def _window(time: np.ndarray) -> int:
    """Return the window, samples, of a running median that removes states shorter than _LASTS."""
    return max(2 * int(np.ceil(_LASTS / np.median(np.diff(time)) - 1e-6)) - 1, 1)


def _level(samples: np.ndarray) -> tuple[float, float]:
    """Return the median of a level and the sd of its noise; nan if there are too few samples."""
    samples = samples[~np.isnan(samples)]
    if samples.size < FEWEST:
        return np.nan, np.nan
    middle = np.median(samples)
    return float(middle), float(np.median(np.abs(samples - middle)) / 0.6745)
