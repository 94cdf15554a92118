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
from breaker.wear.changepoint import Tracker
from breaker.wear.hypotheses import FIRST, Hypotheses
from breaker.wear.learned import Learned
from breaker.wear.state import State
from breaker.wear.temperature import FRICTION, lines

__all__ = ["ALL", "TRANSDUCER", "Event", "after_event", "started_anew"]

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

    @classmethod
    def by_operation(
        cls, texts: Mapping[int, str], more: Mapping[str, Sequence[str]]
    ) -> dict[int, "Event"]:
        """Build those of several operations, from cells by their numbers."""
        return {number: cls.from_text(text, more) for number, text in texts.items()}

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
        learned: What was learned of the difference of drives, if anything is held to differ.
    """
    if not (event.renews and state.seen):
        return state
    old, difference = state.hypotheses, state.difference
    if difference is None:
        passes, jump = 0.0, np.diag(np.square(tracker.step_sd / tracker.log_sds))
    else:
        passes = jump = difference.gain @ learned.new @ difference.gain.T
        drift = lines(old).level()[0][tracker.size :]
        difference = difference.renewed(learned, old.operation, drift, stepped=event.is_whole)
    which = [NAMES.index(name) for name in event.parameters]
    # Another grease has another effect of the temperature.
    new = lines(old) if FRICTION in which else old
    return replace(
        state,
        hypotheses=started_anew(tracker, new, which, passes, jump if event.transducer else 0.0),
        first=old.operation,
        alarms=(),
        difference=difference,
        watch=state.watch and state.watch.anew(),
    )


def started_anew(
    tracker: Tracker,
    old: Hypotheses,
    which: Sequence[int],
    passes: np.ndarray | float = 0.0,
    jump: np.ndarray | float = 0.0,
) -> Hypotheses:
    """Return hypotheses about a segment that begins now, in no change that was noticed.

    Args:
        old: Hypotheses that predict an operation.
        which: Parameters of which level and slope return to the prior.
        passes: Covariance of what passes for levels and is none, ``(p, p)``.
        jump: Covariance of the jump of all other levels, ``(p, p)``.
    """
    p, new, which = tracker.size, _merged_by_scatter(old), np.array(which, dtype=int)
    new.cov[:, :p, :p] += jump
    prior = tracker.begin(new.operation, passes).cov[0]
    places = np.concatenate([which, p + which])
    new.mean[:, places] = 0.0
    new.cov[:, places, :] = 0.0
    new.cov[:, :, places] = 0.0
    new.cov[:, places[:, None], places] = prior[np.ix_(places, places)]
    return new


def _merged_by_scatter(old: Hypotheses) -> Hypotheses:
    """One hypothesis for each scatter: the mixture of all segments."""
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
