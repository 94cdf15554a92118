"""The bank of a family: every number of it against the drive that it is of."""

from pathlib import Path

import numpy as np
import pytest

from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.family import bank as bank_module
from breaker.family.bank import GRID, shapes, simulate_family
from breaker.family.drive_family import WEAR, Family
from breaker.family.rich_drive import CONTACTS, ELEMENTS, LAWS, Drive, Elements
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS
from breaker.model.prior import Prior

DRIVES = 300
ANY = Path(__file__).parents[2] / "config" / "any.yaml"


@pytest.fixture(scope="module")
def family(prior, defaults) -> Family:
    return Family(prior, family_of("medium_voltage"))


@pytest.fixture(scope="module")
def bank(family):
    return simulate_family(family, DRIVES, np.random.default_rng(1))


def drive_of(bank, drive, condition) -> Drive:
    """A drive, put together from the names of its elements."""
    row = bank.isel(drive=drive, condition=condition)
    settings = {"contact": CONTACTS[int(row.elements.sel(element="contact"))]}
    for name, value in zip(ELEMENTS, row.elements.values.tolist(), strict=True):
        part, _, of = name.partition(".")
        if of.startswith("harmonics"):
            settings[part]["harmonics"] = (*settings[part].get("harmonics", ()), value)
        elif of:
            settings.setdefault(part, {})[of] = value
        else:
            settings.setdefault(part, value)
    return Drive(tuple(row.parameters.values.tolist()), Elements.from_settings(settings))


def test_the_same_seed_gives_the_same_bytes(family, bank):
    again = simulate_family(family, 20, np.random.default_rng(1))
    assert again.drop_attrs().equals(bank.isel(drive=slice(20)).drop_attrs())
    other = simulate_family(family, 20, np.random.default_rng(2))
    assert not (other["shape"] == again["shape"]).all()


@pytest.mark.parametrize("number", range(12))
def test_a_curve_is_that_of_the_drive(bank, number):
    """Put together again from shape, stroke and duration; and its events."""
    whole = shapes(bank["shape"].values)
    for condition in range(2):
        drive, row = drive_of(bank, number, condition), bank.isel(drive=number, condition=condition)
        for motion in MOTIONS:
            one = row.sel(motion=motion)
            times = float(one.duration) * (GRID - float(one.release))
            curve, switches = drive.operate(motion, times)
            place = (number, condition, MOTIONS.index(motion))
            way = float(one.stroke) * whole[place]
            begin = 0.0 if motion == "closing" else float(one.stroke)
            np.testing.assert_allclose(abs(curve - begin), abs(way), atol=2e-3)
            later = float(one.duration) * float(one.switching - one.release)
            if switches < np.inf:
                assert later == pytest.approx(switches, abs=1e-4)
            at = [np.interp(u, GRID, whole[place]) for u in (0.0, 1.0)]
            np.testing.assert_allclose(at, [0.1, 0.5], atol=1e-3)
            assert whole[place][float(one.release) > GRID] == pytest.approx(0.0, abs=1e-4)


SIZES = [
    name
    for name in ELEMENTS
    if name.partition(".")[0] not in LAWS and name.rpartition(".")[2] in (name, "damping", "share")
]


def test_how_many_mechanisms_a_drive_has_is_uniform(bank):
    """From none to all; so a drive with one alone is as probable as any other."""
    there = bank.elements.sel(element=SIZES, condition="new") > 0.0
    there |= bank.elements.sel(element=SIZES, condition="new") < 0.0
    free = there.sel(element=[name for name in SIZES if name != "contact_preload"])
    counts = free.sum("element").values / (len(SIZES) - 1)
    # The largest distance of 300 draws is above 0.113 with a probability of 1e-3; steps are 1 / 18.
    share = np.sort(counts)
    assert np.abs(share - (np.arange(300) + 0.5) / 300).max() < 0.113 + 0.5 / 18
    assert (counts == 0.0).any()


def test_a_drive_without_mechanisms_is_exactly_the_model(bank):
    sizes = bank.elements.sel(element=SIZES, condition="new").values
    same = np.flatnonzero((sizes == 0.0).all(axis=1) & (bank.contact == 0).values)
    assert same.size > 2
    for number in same:
        theta, row = bank.parameters.values[number, 0], bank.isel(drive=number, condition=0)
        for i, motion in enumerate(MOTIONS):
            times = float(row.duration[i]) * (GRID - float(row.release[i]))
            exact = travel(theta[None], times, motion).travel[0]
            begin = 0.0 if motion == "closing" else float(row.stroke)
            way = abs(exact - begin) / float(row.stroke)
            np.testing.assert_allclose(abs(shapes(row["shape"].values)[i]), way, atol=4e-5)


def test_contacts_and_wear_come_by_their_shares(family, bank):
    assert bank.contact.kinds == list(CONTACTS)
    shares = np.array([family.settings["contacts"][kind] for kind in CONTACTS])
    found = np.bincount(bank.contact, minlength=3) / bank.drive.size
    np.testing.assert_allclose(found, shares / shares.sum(), atol=0.1)  # 3.5 sd of 300 draws
    changed = (np.diff(bank.parameters.values, axis=1)[:, 0] != 0).sum(axis=1)
    assert bank.wear.kinds == list(WEAR)
    for kind, (least, most) in enumerate([(0, 0), (1, 3), (4, 6)]):
        of_kind = changed[bank.wear.values == kind]
        assert of_kind.size > 60
        assert (of_kind.min(), of_kind.max()) == (least, most)


def test_drives_of_any_kind():
    """The overlay with sliding contacts, which touch where they may."""
    config = load([ANY])
    wide = Family(Prior.from_settings(config["prior"]), family_of(config["family"]["name"]))
    bank = simulate_family(wide, 100, np.random.default_rng(4))
    assert bank.drawn_again < 20
    slides = bank.isel(condition=0, drive=(bank.contact == CONTACTS.index("sliding")).values)
    assert 25 < slides.drive.size < 65  # of 100, half of them
    low, high = family_of("any")["touch"]
    touch = slides.parameters.sel(parameter="L") / slides.stroke
    assert low <= touch.min() <= touch.max() <= high
    for i, motion in enumerate(MOTIONS):  # the curve is there when the contact touches or parts
        one = slides.isel(motion=i)
        pairs = zip(one.switching.values, shapes(one["shape"].values), strict=True)
        way = np.array([np.interp(u, GRID, curve) for u, curve in pairs])
        bent = one.elements.sel(element=["linkage", "reading.share"]).any("element")
        rigid = (~bent & (one.switching < GRID[-1])).values
        expected = touch.values if motion == "closing" else 1.0 - touch.values
        np.testing.assert_allclose(way[rigid], expected[rigid], atol=2e-3)


def test_a_drive_without_a_shape_is_drawn_again_and_counted(family, monkeypatch):
    plain = simulate_family(family, 40, np.random.default_rng(3))
    highest = shapes(plain["shape"].values).max(axis=(1, 2, 3))
    monkeypatch.setattr(bank_module, "_HIGHEST", float(np.median(highest)))
    fewer = simulate_family(family, 40, np.random.default_rng(3))
    assert fewer.drawn_again > 10
    assert shapes(fewer["shape"].values).max() <= np.median(highest) + 1e-4
    monkeypatch.setattr(bank_module, "_HIGHEST", 0.5)
    with pytest.raises(RuntimeError, match="hardly a drive"):
        simulate_family(family, 1, np.random.default_rng(3))
