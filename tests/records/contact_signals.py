"""Simulated signals of contacts: resistance, test current and travel with known times."""

from dataclasses import dataclass

import numpy as np

from breaker.records.contacts import ContactTimes, events_of
from breaker.records.motion import LocatedMotion, Segment
from breaker.records.settings import complete

STROKE = 180.0  # mm
TIMING = 0.02  # ms, sd of the settings, small compared with the uncertainty of the signals


@dataclass
class Case:
    """An opening, or a closing as its mirror image, with the levels of 252 kV breakers."""

    rng: np.random.Generator
    motion: str = "opening"
    step: float = 0.1
    main: float = 55.0  # true times of the contacts, ms
    arcing: float = 72.0
    cut: float = 10.0
    noise: float = 0.01
    begins: float = 40.0
    lasts: float = 60.0
    until: float = 160.0

    @property
    def time(self):
        return np.arange(0.0, self.until, self.step)

    def mirrored(self, at):
        return self.until - at if self.motion == "closing" else at

    @property
    def own(self):
        """Time from the closed contact on, ms."""
        return self.mirrored(self.time)

    def resistance(self, gaps=()):
        """Milliohm: closed, sliding, a first peak, arcing with ripple, and a rise to the cut."""
        rng, t = self.rng, self.own
        closed, arcs = rng.uniform(0.045, 0.07), rng.uniform(0.44, 0.62)
        slides = np.interp(t, [self.begins - 2.0, self.main - 1.5], [closed, 2.3 * closed])
        t0, t1 = self.main - 1.2, self.main + 0.3  # the current commutates
        part = np.clip((t - t0) / (t1 - t0), 0.0, 1.0)
        peak = rng.uniform(0.0, 0.8) * np.exp(-np.maximum(t - t1, 0.0) / 1.5)
        ripple = 1.0 + rng.uniform(0.02, 0.1) * np.sin(2 * np.pi * t / rng.uniform(1.0, 5.0))
        logs = (1 - part) * np.log(slides) + part * np.log(arcs * (1.0 + peak) * ripple)
        rise = rng.uniform(0.8, 1.3)  # ms, an e-fold, to 10 milliohm at the separation
        logs = np.maximum(logs, np.log(10.0) + (t - self.arcing) / rise)
        value = np.exp(logs + self.noise * rng.standard_normal(t.size))
        return np.where(self.within(gaps), self.cut, np.minimum(value, self.cut))

    def within(self, gaps):
        """Samples between times after the touch of the arcing contact, ms."""
        since = self.time - self.mirrored(self.arcing)
        return np.any([(since >= begin) & (since < end) for begin, end in gaps], axis=0) & True

    def current(self, *, rises=1.0, falls=0.15, noise=0.3, gaps=()):
        """Amperes; the supply's coil lets it rise slowly, and the arc ends it fast."""
        t, edge = self.time, self.mirrored(self.arcing)
        since = np.maximum(t - edge, 0.0)
        flows = 1.0 - np.exp(-since / rises) if self.motion == "closing" else np.exp(-since / falls)
        flows = np.where(self.within(gaps), 0.0, flows)
        return 100.0 * flows + noise * self.rng.standard_normal(t.size)

    def located(self):
        share = np.clip((self.own - self.begins) / self.lasts, 0.0, 1.0)
        travel, doubts = STROKE * (1.0 - share**2 * (3.0 - 2.0 * share)), np.full(share.size, "")
        segment = Segment(0, share.size, travel[0], travel[-1], 0.0, np.nan)
        moves = self.mirrored(self.begins + self.lasts * (self.motion == "closing"))
        return LocatedMotion(self.motion, self.time, travel, doubts, 0.0, segment, moves, 0.1)

    def read(self, contact, current=None, name="DCRM Res CH1") -> ContactTimes:
        channels = {"contact": contact} | ({} if current is None else {"current": current})
        settings = complete({"contact_column": name, "timing_sd": TIMING})
        return events_of(settings, self.located(), channels)[0]


def random_case(rng):
    """A case of any step, duration of the arcing contact, cut, noise and motion."""
    main = rng.uniform(50.0, 60.0)
    return Case(
        rng,
        motion=str(rng.choice(["opening", "closing"])),
        step=float(rng.choice([0.05, 0.1, 0.2, 0.25, 0.5])),
        main=main,
        arcing=main + rng.uniform(6.0, 25.0),
        cut=float(rng.choice([4.0, 8.0, 10.0])),
        noise=float(rng.choice([0.0, 0.01, 0.05])),
    )
