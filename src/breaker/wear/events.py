"""Known events: work on a drive or its transducer, after which a part of what is known starts anew.

What was worked on is as it may be on any drive, so its level and slope return to the prior, and
forget what they had to do with the rest, which goes on. A transducer that was mounted again changes
what the records show of every parameter, and no slope. Either way a new segment begins, of which
nobody needs to be warned.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from breaker.files import EVENTS, event_words
from breaker.mechanism import NAMES
from breaker.wear.changepoint import FIRST, Hypotheses, Tracker
from breaker.wear.learned import Learned
from breaker.wear.state import State
from breaker.wear.temperature import FRICTION, lines

__all__ = ["ALL", "TRANSDUCER", "Event", "after_event"]

ALL, TRANSDUCER = "all", "transducer"
"""What an event may start anew beside single parameters: all of them, and what records show."""


@dataclass(frozen=True)
class Event:
    """Work that was done before an operation.

    Attributes:
        text: Its words, as the table of operations has them.
        parameters: Those that start anew.
        transducer: Whether the transducer may show something else.
    """

    text: str
    parameters: tuple[str, ...] = ()
    transducer: bool = False

    @classmethod
    def from_text(cls, text: str, more: Mapping[str, Sequence[str]] | None = None) -> "Event":
        """Build from a cell of the table.

        >>> Event.from_text("Greased, inspected").told(1204)
        'Greased, inspected: gamma_a, gamma_b start anew at operation 1,204'

        Args:
            text: The cell.
            more: The section ``endurance.events`` of the configuration: by event, beside those of
                ``EVENTS``, the names of parameters, ``ALL`` or ``TRANSDUCER``.

        Raises:
            ValueError: If an event has no meaning.
        """
        every = [*EVENTS.items(), *(more or {}).items()]
        known = {word: meaning for key, meaning in every for word in event_words(key)}
        if unknown := [word for word in event_words(text) if word not in known]:
            raise ValueError(f"endurance.events has no {', '.join(unknown)}; add what starts anew")
        affected = {name for word in event_words(text) for name in known[word]}
        parameters = tuple(name for name in NAMES if affected & {name, ALL})
        return cls(text, parameters, TRANSDUCER in affected)

    @property
    def renews(self) -> bool:
        """Whether anything starts anew."""
        return bool(self.parameters) or self.transducer

    @property
    def is_whole(self) -> bool:
        """Whether the records may differ from those before in everything."""
        return self.transducer or len(self.parameters) == len(NAMES)

    def told(self, operation: int) -> str:
        """Say what starts anew at an operation; nothing if nothing does."""
        if not self.renews:
            return ""
        names = [*self.parameters]
        if len(names) == len(NAMES):
            names = ["every parameter"]
        if self.transducer:
            names.append("what the transducer shows")
        verb = "starts" if len(names) == 1 else "start"
        return f"{self.text}: {', '.join(names)} {verb} anew at operation {operation:,}"


def after_event(event: Event, state: State, tracker: Tracker, learned: Learned | None) -> State:
    """Return what is known before the first operation after an event.

    Args:
        event: What was done; before the first record it changes nothing.
        state: What is known before the operation, with hypotheses that predict it.
        tracker: The model of wear.
        learned: What was learned of the difference of drives, if anything is held to differ.
    """
    if not (event.renews and state.seen):
        return state
    old, difference = state.hypotheses, state.difference
    p, new = tracker.size, _merged_by_scatter(old)
    if NAMES[FRICTION] in event.parameters:
        new = lines(new)  # another grease, another effect of the temperature
    if difference is None:
        passes, shown = 0.0, np.diag(np.square(tracker.step_sd / tracker.log_sds))
    else:
        passes = shown = difference.gain @ learned.new @ difference.gain.T
        drift = lines(old).level()[0][p:]
        difference = difference.renewed(learned, old.operation, drift, stepped=event.is_whole)
    if event.transducer:
        new.cov[:, :p, :p] += shown
    _renew(tracker, new, [NAMES.index(name) for name in event.parameters], passes)
    return replace(
        state,
        hypotheses=new,
        first=old.operation,
        alarms=(),
        difference=difference,
        watch=state.watch and state.watch.anew(),
    )


def _merged_by_scatter(old: Hypotheses) -> Hypotheses:
    """One hypothesis for each scatter: the mixture of all segments, in a segment that begins now.

    As before the first operation, it began in no change.
    """
    scatters = np.unique(old.scatter)
    parts = [old.of(old.scatter == each) for each in scatters]
    levels = [part.level() for part in parts]
    return Hypotheses(
        old.operation,
        np.log([part.weight.sum() for part in parts]),
        np.stack([mean for mean, _ in levels]),
        np.stack([cov for _, cov in levels]),
        start=np.full(len(parts), float(old.operation)),
        kind=np.full(len(parts), FIRST),
        scatter=scatters,
        start_variance=np.zeros(len(parts)),
    )


def _renew(
    tracker: Tracker, new: Hypotheses, which: Sequence[int], passes: np.ndarray | float
) -> None:
    """Return levels and slopes of some parameters to the prior, in place."""
    p, which = tracker.size, np.array(which, dtype=int)
    prior = tracker.begin(new.operation, passes).cov[0]
    places = np.concatenate([which, p + which])
    new.mean[:, places] = 0.0
    new.cov[:, places, :] = 0.0
    new.cov[:, :, places] = 0.0
    new.cov[:, places[:, None], places] = prior[np.ix_(places, places)]
