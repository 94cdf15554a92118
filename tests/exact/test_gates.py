"""Laws of forces are seen as far as there are these forces."""

from dataclasses import fields

import numpy as np
import pytest

from breaker.common.randomness import generator
from breaker.drive.exact.gates import Gates
from breaker.drive.simulation.rich_drive import ELEMENTS, STOPS, WAVES, Drive, Elements, Stop, Waves
from breaker.quantities.parameters import NAMES

_ALL = (*NAMES, *ELEMENTS)
_MORE = 3  # columns beyond those of a drive


def place(name: str) -> int:
    return _ALL.index(name)


SIZES = {
    **{f"{s}.{law}": f"{s}.damping" for s in STOPS for law in ("reach", "power", "depth")},
    **{f"{s}.profile": f"{s}.damping" for s in STOPS},
    **dict.fromkeys(("stick", "slip", "load"), "dry_friction"),
    **{"growth": "build_up", "drag_power": "drag"},
    **{f"{wave}.harmonics.{i}": f"{wave}.share" for wave in WAVES for i in range(6)},
}
"""By each law the size of its force."""
LAW, SIZE = (np.array([place(each) for each in some]) for some in (SIZES, SIZES.values()))
HARMONIC = np.array(["harmonics" in name for name in SIZES])


@pytest.fixture(scope="module")
def drives(drawn):
    return np.array([each.numbers for each in drawn])


@pytest.fixture(scope="module")
def gates(drives):
    return Gates.of(drives)


@pytest.fixture
def numbers(drives):
    """Of drives that have every force, and columns beyond."""
    rng = generator(1, "test gates")
    some = drives[:50].copy()
    sizes = np.unique(SIZE)
    some[:, sizes] = drives.max(axis=0)[sizes] * rng.uniform(0.05, 1.0, (50, sizes.size))
    return np.column_stack([some, rng.standard_normal((50, _MORE))])


def whole(value: float) -> Elements:
    """Elements all of which have this value, also those that nobody thought of here."""
    found = {}
    for each in fields(Elements):
        default = getattr(Elements(), each.name)
        if isinstance(default, Stop):
            found[each.name] = Stop(**dict.fromkeys(vars(default), value))
        elif isinstance(default, Waves):
            found[each.name] = Waves(value, (value,) * len(default.harmonics))
        elif not isinstance(default, str):
            found[each.name] = value
    return Elements(**found)


def test_laws_are_seen_as_far_as_their_force_is_there(gates, numbers, drives):
    before = numbers.copy()
    seen = gates.seen(numbers)
    assert np.array_equal(numbers, before)
    assert np.array_equal(np.delete(seen, LAW, axis=1), np.delete(numbers, LAW, axis=1))

    def at(law=0.0, size=1.0):
        some = numbers.copy()
        some[:, LAW] += law
        some[:, np.unique(SIZE)] *= size
        return gates.seen(some)[:, LAW]

    slope = at(law=1.0) - at()
    assert (slope > 0.0).all()
    assert np.allclose(at(law=2.0) - at(law=1.0), slope, rtol=1e-9)
    middle = numbers[:, LAW] - at() / slope
    assert np.allclose(middle, middle[0], atol=1e-9)  # of any size
    inside = (drives.min(axis=0)[LAW] <= middle[0]) & (middle[0] <= drives.max(axis=0)[LAW])
    assert inside.all()
    larger = at(law=1.0, size=2.0) - at(size=2.0)
    assert (larger > slope).all()
    assert np.allclose(larger[:, HARMONIC], 2.0 * slope[:, HARMONIC], rtol=0.02)  # a force is both
    assert not at(size=0.0).any()


def test_a_force_that_is_absent_is_seen_the_same_whatever_its_law(gates, drives):
    rng = generator(2, "test gates")
    for size in np.unique(SIZE):
        laws = LAW[size == SIZE]
        without, other = drives.copy(), drives.copy()
        other[:, laws] = rng.permutation(drives[:, laws]) + rng.standard_normal(laws.size)
        assert (gates.seen(other) != gates.seen(without)).any(), _ALL[size]
        without[:, size] = other[:, size] = 0.0
        assert np.array_equal(gates.seen(other), gates.seen(without)), _ALL[size]


def test_slopes_of_what_is_seen_are_those_by_differences(gates, numbers):
    by = generator(3, "test gates").standard_normal(numbers.shape)
    before = by.copy()
    slopes = gates.back(numbers, by)
    assert np.array_equal(by, before)
    for j in range(numbers.shape[1]):
        step = 1e-5 * np.abs(numbers[:, j]).max()
        beside = step * (np.arange(numbers.shape[1]) == j)
        moved = gates.seen(numbers + beside) - gates.seen(numbers - beside)
        expected = (moved * by).sum(axis=1) / (2.0 * step)
        scale = np.abs(expected).max()
        assert np.allclose(expected, slopes[:, j], rtol=1e-4, atol=1e-6 * scale), j


def test_every_element_without_a_size_of_its_own_is_seen_so(gates):
    """Those that the strength of the elements leaves as they are, so also one that is new."""
    absent = whole(0.7).scaled(0.0)
    numbers = Drive((1.0,) * len(NAMES), absent).numbers[None]
    kept = {name for name in ELEMENTS if numbers[0, place(name)] != 0.0}
    assert kept == set(SIZES)
    assert not gates.seen(numbers)[:, len(NAMES) :].any()


def test_a_force_that_no_drive_has_hides_its_law(drives):
    without = drives.copy()
    without[:, SIZE] = 0.0
    seen = Gates.of(without).seen(without)
    assert np.isfinite(seen).all()
    assert not seen[:, LAW].any()
