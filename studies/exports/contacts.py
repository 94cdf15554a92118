"""Simulate a contact as an analyser prints it: test current, resistance, voltage or state.

The circuit is open, or closed through the arcing or the main contact. A source of constant current
feeds it. The analyser prints voltage over current, or the end of its range if the ratio is larger
or hardly any current flows.
"""

import numpy as np

OPEN, ARCING, MAIN = range(3)
STEP = 0.02  # ms, time step of a motion's curve
_FLOWS = 0.05  # share of the test current above which a resistance is computed


def reached(travel: np.ndarray, mm: float) -> float:
    """Return the time at which the travel first reaches a position, ms after the first motion."""
    after = int(np.argmax(travel >= mm))
    before = travel[after - 1]
    share = (mm - before) / (travel[after] - before) if after else 0.0
    return float(STEP * (after - 1 + share)) if after else 0.0


def contact_times(pole: dict, move: dict) -> dict[str, float]:
    """Return the times at which contacts of a pole touch or separate, ms after first motion."""
    closing, stroke = move["motion"] == "closing", pole["stroke"]
    levels = {kind: mm if closing else stroke - mm for kind, mm in pole["contacts"].items()}
    return {kind: reached(move["travel"], mm) for kind, mm in levels.items()}


def draw_bounces(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return the interruptions after a touch, each begin and end, ms; mostly none."""
    edges = np.cumsum(rng.uniform(0.3, 1.5, 2 * int(rng.integers(1, 3))))
    return [*zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)] * (rng.random() < 0.25)


def bounces_of(pole: dict, move: dict) -> list[tuple[float, float]]:
    """Return the interruptions of a pole; none if the main contact touches during them."""
    times = contact_times(pole, move)
    bounces = move["bounces"]
    clear = not bounces or not 0 < times["main"] - times["arcing"] < bounces[-1][1]
    return bounces if clear else []


def switching(pole: dict) -> list[tuple[float, int]]:
    """Return the instants at which the circuit of a pole changes, ms, and the level after each."""
    closed = pole["motions"][0]["motion"] == "opening"
    changes = [(-np.inf, MAIN if closed else OPEN)]
    for move in pole["motions"]:
        arcing, main = (move["first"] + t for t in contact_times(pole, move).values())
        if move["motion"] == "opening":
            changes += [(main, ARCING)] * (main < arcing) + [(arcing, OPEN)]
            continue
        bounces = bounces_of(pole, move)
        ends = [arcing] + [arcing + end for _, end in bounces]
        changes += [(at, MAIN if main <= at else ARCING) for at in ends]
        changes += [(arcing + begin, OPEN) for begin, _ in bounces]
        changes += [(main, MAIN)] * (main > arcing)
    return sorted(changes)


def levels(changes: list[tuple[float, int]], time: np.ndarray) -> np.ndarray:
    """Return the level of a circuit at times ``(t,)``."""
    instants, states = zip(*changes, strict=True)
    return np.array(states)[np.searchsorted(instants, time, side="right") - 1]


def follow(changes, targets: dict, rise: float, fall: float, time, first: float) -> np.ndarray:
    """Return a current that follows the circuit with time constants of its rise and fall, ms."""
    current, now, since = np.zeros(len(time)), first, time[0]
    instants = [at for at, _ in changes[1:]] + [np.inf]
    for (_, state), until in zip(changes, instants, strict=True):
        target = targets[state]
        tau = rise if target > now else fall
        here = (time >= since) & (time < until)
        current[here] = target + (now - target) * np.exp(-(time[here] - since) / tau)
        if until > since:
            now = target + (now - target) * np.exp(-(until - since) / tau)
            since = until
    return current


def draw_meter(rng: np.random.Generator, full: float) -> dict:
    """Return the properties of an analyser's source and a breaker's contacts: A, ms and uOhm."""
    closed, above = rng.uniform(30, 250), rng.random() < 0.25  # an arcing contact beyond the range
    arcing = max(rng.uniform(300, 2000), 4 * closed)
    return {
        "amps": rng.uniform(50, 200),
        "rise": rng.uniform(0.1, 1.0) / 3,
        "fall": rng.uniform(0.1, 1.0) / 3,
        "full": full,
        "closed": closed,
        "arcing": full * rng.uniform(1.2, 3.0) if above else arcing,
        "grow": rng.uniform(0.1, 0.6),
        "ripple": rng.uniform(50, 800) * (rng.random() < 0.5),
        "nano_henry": rng.uniform(0, 200),
        "hum": rng.uniform(0, 0.01),
    }


def measured(rng: np.random.Generator, pole: dict | None, time: np.ndarray, meter: dict):
    """Return the resistance (uOhm) and the test current (A) of a pole, or of an unused channel."""
    if pole is None:
        noise = 0.05 * rng.standard_normal(len(time))
        return np.full(len(time), meter["full"]), noise
    changes, level = switching(pole), meter["amps"]
    amps = {OPEN: 0.0, ARCING: level, MAIN: level}
    first = amps[changes[0][1]] * (rng.random() > 0.3)  # otherwise the source is just switched on
    clean = follow(changes, amps, meter["rise"], meter["fall"], time, first)
    state = levels(changes, time)
    period, decay, phase = rng.uniform(1.5, 6), rng.uniform(10, 40), rng.uniform(0, np.pi)
    swing = abs(np.sin(np.pi * time / period + phase))
    closed, grown = np.full(len(time), meter["closed"]), np.ones(len(time))
    for move in pole["motions"]:
        at = move["first"] + contact_times(pole, move)["arcing"]
        grown += 8 * np.exp(-abs(time - at) / meter["grow"])  # few points touch
        if move["motion"] == "closing":
            away = np.maximum(time - at, 0)
            closed += (time > at) * meter["ripple"] * swing * np.exp(-away / decay)
    ohm = np.where(state == MAIN, closed, meter["arcing"] * grown)
    ohm *= 1 + rng.uniform(0.005, 0.05) * rng.standard_normal(len(time))
    lead = meter["nano_henry"] * np.gradient(clean, time) / np.maximum(clean, 1e-3)  # uOhm
    ohm = np.where((state >= ARCING) & (clean > _FLOWS * level), ohm + lead, meter["full"])
    hum = 1 + meter["hum"] * np.sin(2 * np.pi * 0.1 * time)
    noise = rng.uniform(0.02, 0.5) * rng.standard_normal(len(time))
    return np.clip(ohm, 0, meter["full"]), clean * hum + noise


def signal(pole: dict, time: np.ndarray, rises: bool, volts: float) -> np.ndarray:
    """Return the voltage (or state, for 1 V) of an input, which is high or low while closed."""
    closed = levels(switching(pole), time) != OPEN
    return volts * (closed if rises else ~closed)
