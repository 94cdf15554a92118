"""Known events: what starts anew, what goes on, that nobody is alarmed, and state in chunks."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from breaker.files.cells import event_words
from breaker.mechanism.limits import from_list
from breaker.mechanism.parameters import MOTIONS, NAMES
from breaker.model.randomness import generator
from breaker.wear.events import Event
from breaker.wear.trend import Follower
from tests.wear.parts import assert_goes_on, part, recorded

P = len(NAMES)
GAMMA_A, F = (NAMES.index(name) for name in ("gamma_a", "f"))
SCATTER = 0.002  # share of a parameter; one of the model's candidates
OPERATIONS = 1 + 10 * np.arange(75)
EVENT, AT = 501, 50  # operation, and its place
WEAR = 5.0  # of gamma_a before the event, standardised in 1,000 operations
LOSS = -1.0  # of f
FAR = from_list([{"name": "far", "motion": "closing", "upper": {"L": 30.0}}], MOTIONS)


@pytest.fixture(scope="module")
def follower(models, defaults):
    settings = defaults["wear_model"] | {"baseline": 20, "settle": 20, "lines": 2}
    return Follower.from_settings(models, FAR, settings, 1)


def life(models, z, rng):
    """Records of standardised parameters ``(o, p)``."""
    return recorded(models, OPERATIONS, z, rng, scatter=SCATTER)


@pytest.fixture(scope="module")
def greased(models):
    """A drive whose friction is new again from an event on, while its closing force goes on."""
    z = np.zeros((OPERATIONS.size, P))
    z[:AT, GAMMA_A] = WEAR * (OPERATIONS[:AT] - 1) / 1000
    z[:, F] = LOSS * (OPERATIONS - 1) / 1000
    return life(models, z, generator(1, "test events")), z


def with_event(series, text):
    return replace(series, events={EVENT: Event.from_text(text)})


@pytest.fixture(scope="module")
def unknown(follower, greased):
    series, _ = greased
    return follower.follow(follower.begin(series), series)


@pytest.fixture(scope="module")
def known(follower, greased):
    series = with_event(greased[0], "Greased")
    return follower.follow(follower.begin(series), series)


def level_of(follower, found, i, parameter):
    """Standardised level and half its 90 % interval at operation ``i``."""
    prior = follower.prior
    new = np.log(prior.destandardise(np.zeros(P))[parameter])
    ends = (np.log(found.level_interval.values[i, parameter]) - new) / prior.log_sds[parameter]
    return ends.mean(), np.ptp(ends) / 2


def test_a_known_event_starts_the_level_anew_at_once(follower, known, greased):
    """From the first operation on; the others go on. By stated intervals: false alarm 1e-3."""
    _, found = known
    bound = norm.isf(0.5e-3 / 4) / 1.6449  # of four errors, in half widths
    for i in (AT, AT + 4):
        for parameter in (GAMMA_A, F):
            level, half = level_of(follower, found, i, parameter)
            assert abs(level - greased[1][i, parameter]) < bound * half
            assert half < 0.2
    assert not found.alarm.any()
    assert found.change_probability.values[AT] == 0.0
    assert found.event.values[AT] == "Greased: gamma_a, gamma_b start anew at operation 501"
    assert not found.event.values[np.arange(OPERATIONS.size) != AT].any(), "told once"
    # The slope of the friction is unknown again, that of the force as well known as before.
    width = np.ptp(found.slope_interval.values, axis=-1)
    assert width[AT, GAMMA_A] > 4 * width[AT - 1, GAMMA_A]
    assert width[AT, F] < 1.05 * width[AT - 1, F]
    assert found.run_length_probability.values[AT, 0] == pytest.approx(1.0)


def test_without_it_the_level_is_wrong_first_and_a_change_is_reported(follower, unknown, greased):
    """The fault: what was done to the drive is kept from the trend."""
    _, found = unknown
    level, half = level_of(follower, found, AT, GAMMA_A)
    assert abs(level - greased[1][AT, GAMMA_A]) > 3 * half
    assert found.alarm.any()
    assert not found.event.values.any()


def test_nothing_else_changes_before_an_event(known, unknown):
    """Bit by bit; nor by an event that starts nothing anew."""
    before = slice(0, AT)
    xr.testing.assert_identical(
        known[1].isel(operation=before).drop_vars("event"),
        unknown[1].isel(operation=before).drop_vars("event"),
    )


def test_an_inspection_starts_nothing_anew(follower, greased):
    series = part(greased[0], slice(0, 25))
    plain = follower.follow(follower.begin(series), series)
    looked_at = replace(series, events={151: Event.from_text("inspected")})
    same = follower.follow(follower.begin(looked_at), looked_at)
    xr.testing.assert_identical(same[1], plain[1])
    xr.testing.assert_identical(same[0].to_dataset(), plain[0].to_dataset())


@pytest.mark.parametrize("split", [AT, AT + 5])
def test_events_in_other_chunks_are_as_in_one(split, follower, known, greased):
    """Bit by bit, with the event in the first operation of a chunk, and in the chunk before."""
    series = with_event(greased[0], "Greased")
    assert_goes_on(follower, series, split, known)


def test_a_transducer_mounted_again_changes_levels_as_seen_but_no_slope(follower, models):
    """Its scale is 2 % larger: f and L seem to be, and the force goes on as it did."""
    z = np.zeros((OPERATIONS.size, P))
    z[:, F] = LOSS * (OPERATIONS - 1) / 1000
    series = with_event(life(models, z, generator(2, "test events")), "remounted")
    for each in series.records.values():
        each[AT:] *= 1.02
    _, found = follower.follow(follower.begin(series), series)
    assert not found.alarm.any()
    sds = follower.prior.log_sds
    level, half = level_of(follower, found, AT + 4, F)
    bound = norm.isf(0.5e-3 / 2) / 1.6449  # of two errors: false alarm 1e-3
    assert abs(level - z[AT + 4, F] - np.log(1.02) / sds[F]) < bound * half
    slope, ends = found.slope.values[AT + 4, F], found.slope_interval.values[AT + 4, F]
    assert abs(slope - 100 * sds[F] * LOSS) < bound * np.ptp(ends) / 2
    assert np.ptp(ends) < 1.2 * np.ptp(found.slope_interval.values[AT - 1, F])


def test_the_reference_has_no_event_in_it(greased):
    series = greased[0]
    places = np.arange(20)
    assert series.alike(places).tolist() == places.tolist()
    events = {81: Event.from_text("greased"), 151: Event.from_text("cleaned")}
    parted = replace(series, events=events)
    assert parted.alike(places).tolist() == list(range(8, 20))
    assert parted.alike(places[:12]).tolist() == list(range(8))
    assert parted.alike(places[:0]).size == 0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("maintenance", "maintenance: every parameter starts anew at operation 1,204"),
        ("Contact-spring replaced", "k_b, gamma_b start anew"),
        ("greased, transducer remounted", "gamma_a, gamma_b, what the transducer shows start"),
        ("inspected + cleaned", ""),
        ("", ""),
    ],
)
def test_words(text, words):
    told = Event.from_text(text).told(1204)
    assert words in told
    assert bool(told) == bool(words)


def test_an_event_without_a_meaning_is_refused():
    with pytest.raises(ValueError, match=r"endurance\.events has no painted; add what starts"):
        Event.from_text("greased, painted", {"oiled": ["gamma_a"]})


def test_more_events_may_have_a_meaning():
    more = {"oil changed": ["gamma_a"], "greased": []}
    assert Event.from_text("Oil-changed", more).parameters == ("gamma_a",)
    assert not Event.from_text("greased", more).renews


def test_words_of_a_cell():
    assert event_words(" Greased;spring_replaced + GREASED,") == ("greased", "spring replaced")
