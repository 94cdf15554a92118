"""Drives made of scores are those that the family draws; what is drawn anew leaves them as they
are, and mechanisms that come and go leave the prior as it is.
"""

from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import binomtest, chisquare, ks_2samp, kstest

from breaker.common.randomness import generator
from breaker.drive.exact.family_scores import FamilyScores, ScoreColumns
from breaker.drive.exact.simulated_motions import closed_travels
from breaker.drive.simulation.rich_drive import CONTACTS, ELEMENTS, LAWS, Elements
from breaker.quantities.parameters import NAMES

_CONTACT = len(NAMES) + ELEMENTS.index("contact")


def unlike(numbers: np.ndarray, drives) -> float:
    """Smallest p-value of any number of a drive, times how many there are."""
    own = np.array([each.numbers for each in drives])
    varied = np.flatnonzero(own.std(axis=0))
    found = [ks_2samp(numbers[:, k], own[:, k]).pvalue for k in varied]
    return float(min(found) * len(varied))


def weighed(scores, some, rng):
    """Numbers of drives that work, by the density of their scores over a standard normal."""
    numbers = scores.numbers(some)
    more = scores.log_prior(some) + 0.5 * np.square(some).sum(axis=1)
    share = np.exp(more - more.max())
    works = np.isfinite(closed_travels(numbers, scores.touch))
    return numbers[works & (rng.random(len(some)) < share)]


def test_scores_make_the_drives_that_the_family_draws(scores, drawn):
    rng = generator(2, "test scores")
    some = rng.standard_normal((4000, scores.unknowns))
    numbers = weighed(scores, some, rng)
    assert unlike(numbers, drawn) > 1e-3  # false alarms: 1e-3 by Bonferroni
    shifted = numbers.copy()
    shifted[:, 1] *= 1.1  # a planted fault
    assert unlike(shifted, drawn) < 1e-3


def test_kinds_of_contact_have_their_shares_though_not_all_of_their_draws_work(scores, family):
    rng = generator(3, "test scores")
    assert scores.kinds == ["elastic", "held", "sliding"]
    assert scores.working.max() - scores.working.min() > 0.2  # so that it matters
    some = rng.standard_normal((20_000, scores.unknowns))

    def off(of):
        contact = weighed(of, some, rng)[:, _CONTACT]
        shares = family.settings["contacts"]
        return max(
            abs(share - shares[kind]) / np.sqrt(shares[kind] * (1.0 - shares[kind]) / contact.size)
            for kind, share in of.shares_of(contact).items()
        )

    # Shares that work are those of 4,000 draws, of which the kinds here are at most as many.
    assert off(scores) < 4.5
    assert off(replace(scores, working=np.ones(3))) > 4.5  # a planted fault


def test_what_works_is_what_the_family_takes(family, scores):
    """Of each kind of contact, drawn one at a time by the family itself."""
    rng = generator(4, "test scores")
    n = 1000
    for kind, share in zip(scores.kinds, scores.working, strict=True):
        taken = np.mean([family.proposed(kind, rng) is not None for _ in range(n)])
        sd = np.sqrt(max(share * (1.0 - share), 1e-3) * (1.0 / n + 1.0 / 4000))
        assert abs(taken - share) < 4.0 * sd, kind


def test_a_drive_of_scores_does_not_depend_on_those_beside_it(scores):
    some = generator(3, "test scores").standard_normal((20, scores.unknowns))
    whole = scores.numbers(some)
    assert np.array_equal(whole[7:8], scores.numbers(some[7:8]))


def test_a_program_makes_of_scores_what_the_family_does(scores):
    """To the last digits, which compiled code may round otherwise."""
    some = generator(10, "test scores").standard_normal((300, scores.unknowns))
    contact, numbers = scores.contact(some), scores.numbers(some)
    for k, kind in enumerate(scores.kinds):
        own = contact == k
        theta, elements = scores.family.drawn(kind, ScoreColumns(some[own, 1:]))
        columns = [*theta, *elements.numbers]
        expected = np.column_stack([np.broadcast_to(each, own.sum()) for each in columns])
        assert np.allclose(numbers[own], expected, rtol=1e-12, atol=0.0)


def test_slopes_of_drives_are_those_by_differences(scores):
    rng = generator(11, "test scores")
    some = rng.standard_normal((40, scores.unknowns))
    numbers, back = scores.traced(some)
    assert np.array_equal(numbers, scores.numbers(some))
    by = rng.standard_normal(numbers.shape)
    slopes = back(by)
    assert not slopes[:, 0].any()  # of the kind of contact
    for j in range(1, scores.unknowns):
        beside = 1e-6 * np.eye(scores.unknowns)[j]
        moved = scores.numbers(some + beside) - scores.numbers(some - beside)
        assert np.allclose((moved * by).sum(axis=1) / 2e-6, slopes[:, j], atol=1e-6), j


# ---- drawn anew ----------------------------------------------------------------------------------


def test_drawn_anew_drives_stay_to_the_bit(scores):
    """Also those whose other scores are far out."""
    some = 1.5 * generator(5, "test scores").standard_normal((5000, scores.unknowns))
    some[:50, 1] = 9.0
    new = scores.redrawn(some, generator(6, "test scores"))
    begin, count = scores.presence
    assert (new != some)[:, begin - 1 : begin + count].all()
    others = np.delete(np.arange(scores.unknowns), np.arange(begin - 1, begin + count))
    assert np.array_equal(new[:, others], some[:, others])
    assert np.array_equal(scores.numbers(new), scores.numbers(some))


def test_drawn_anew_scores_keep_their_prior(scores):
    """Drawn from it, they are standard normal again, and as independent: also after many times."""
    rng = generator(7, "test scores")
    some = rng.standard_normal((4000, scores.unknowns))
    for _ in range(5):
        some = scores.redrawn(some, rng)
    begin, count = scores.presence
    block = some[:, begin - 1 : begin + count]
    p_values = [kstest(each, "norm").pvalue for each in block.T]
    assert min(p_values) * len(p_values) > 1e-3
    apart = np.corrcoef(block.T)[np.triu_indices(count + 1, 1)]
    assert np.abs(apart).max() < 4.5 / np.sqrt(len(some))
    shifted = ndtr(block[:, 0]) ** 1.2  # a planted fault
    assert kstest(shifted, "uniform").pvalue < 1e-3


def test_drawn_anew_they_forget_how_they_decided(scores):
    """A share near 1 that decides as one near the middle would, goes there."""
    begin, count = scores.presence
    some = generator(8, "test scores").standard_normal((2000, scores.unknowns))
    some[:, begin - 1] = 3.0
    some[:, begin : begin + count] = np.where(np.arange(count) < count // 2, -1.0, 3.5)
    share = ndtr(scores.redrawn(some, generator(9, "test scores"))[:, begin - 1])
    has = count // 2
    expected = (has + 1.0) / (count + 2.0)
    sd = np.sqrt(expected * (1.0 - expected) / (count + 3.0))
    assert share.mean() == pytest.approx(expected, abs=4.0 * sd / np.sqrt(2000))
    assert share.std() == pytest.approx(sd, rel=0.1)


def test_a_family_in_which_all_mechanisms_are_has_nothing_to_draw_anew(family):
    alike = replace(family, settings=family.settings | {"strength": 1.0})
    found = FamilyScores.of(alike, generator(1, "test scores"))
    some = generator(2, "test scores").standard_normal((5, found.unknowns))
    assert found.presence is None
    assert found.redrawn(some, generator(3, "test scores")) is some


# ---- mechanisms that come and go -----------------------------------------------------------------


def there(scores, some):
    """Which mechanisms are there, ``(n, count)``."""
    begin, count = scores.presence
    return ndtr(some[:, begin - 1, None]) > ndtr(some[:, begin : begin + count])


def sizes_of(scores, some):
    """Scores of the sizes of mechanisms, ``(n, count)``."""
    begin, count = scores.presence
    return some[:, begin + count : begin + 2 * count]


def all_absent(scores, n, rng):
    """Drives without any mechanism, whose sizes would all be near the largest."""
    begin, count = scores.presence
    some = rng.standard_normal((n, scores.unknowns))
    some[:, begin - 1] = -3.0
    some[:, begin : begin + count] = np.abs(some[:, begin : begin + count])
    some[:, begin + count : begin + 2 * count] = 3.0
    return some


def after(scores, some, steps, rng, taken=lambda log_ratio: log_ratio, kinds=(False, True)):
    """Scores after so many Metropolis steps, in which mechanisms come, go and are exchanged.

    Args:
        taken: Logarithm of the odds by which new scores are taken, of the log ratio.
        kinds: Of the moves, in turn: whether mechanisms are exchanged.
    """
    for k in range(steps):
        new, log_ratio = scores.switched(some, kinds[k % len(kinds)], rng)
        some = np.where((np.log(rng.random(len(some))) < taken(log_ratio))[:, None], new, some)
    return some


def off_prior(scores, some) -> float:
    """Smallest p-value of the prior of mechanisms, times how many there are (Bonferroni).

    Scores that decide, and of sizes, are standard normal; those of sizes also of the mechanisms
    that are there alone, and of those that are not. Of mechanisms, any number is as likely, and
    each is there as often as not.
    """
    begin, count = scores.presence
    has, sizes = there(scores, some), sizes_of(scores, some)
    columns = [*some[:, begin - 1 : begin + 2 * count].T]
    for k in range(count):
        columns += [sizes[has[:, k], k], sizes[~has[:, k], k]]
    found = [kstest(each, "norm").pvalue if each.size else 0.0 for each in columns]
    found.append(chisquare(np.bincount(has.sum(axis=1), minlength=count + 1)).pvalue)
    found += [binomtest(int(each.sum()), len(some)).pvalue for each in has.T]
    return float(min(found) * len(found))


def test_mechanisms_that_come_and_go_keep_the_prior(scores):
    """So they do after many steps, of which a fault of any one adds up."""
    some = generator(12, "test scores").standard_normal((2000, scores.unknowns))
    found = after(scores, some, 200, generator(13, "test scores"))
    assert off_prior(scores, found) > 1e-3  # false alarms: 1e-3 by Bonferroni
    for kinds in ((False,), (True,)):  # planted faults: all are taken
        faulty = after(scores, some, 20, generator(13, "test scores"), np.zeros_like, kinds)
        assert off_prior(scores, faulty) < 1e-3, kinds


def test_mechanisms_that_come_and_go_reach_the_prior_from_afar(scores):
    """Of drives that have none: some 200 steps for a factor of e, by the walk of their number."""
    rng = generator(14, "test scores")
    some = all_absent(scores, 400, rng)
    assert not there(scores, some).any()
    assert off_prior(scores, after(scores, some, 60, rng)) < 1e-3  # too early
    found = after(scores, some, 1500, rng)
    assert off_prior(scores, found) > 1e-3  # false alarms: 1e-3 by Bonferroni


@pytest.mark.parametrize("exchanged", [False, True])
def test_one_mechanism_comes_or_goes_or_one_of_each(scores, exchanged):
    rng = generator(15, "test scores")
    begin, count = scores.presence
    some = rng.standard_normal((3000, scores.unknowns))
    some = np.vstack([some, all_absent(scores, 50, rng)])
    some[-20:, begin - 1] = 4.0  # all are there
    before = some.copy()
    new, log_ratio = scores.switched(some, exchanged, rng)
    assert np.array_equal(some, before)
    had, has = there(scores, some), there(scores, new)
    come, gone = has & ~had, had & ~has
    number = had.sum(axis=1)
    if exchanged:
        moved = (number > 0) & (number < count)
        assert np.array_equal(come.sum(axis=1), moved)
        assert np.array_equal(gone.sum(axis=1), moved)
        assert np.allclose(log_ratio[~moved], 0.0, atol=1e-9)
    else:
        assert ((come | gone).sum(axis=1) == 1).all()
        assert come[number == 0].any(axis=1).all()
        assert gone[number == count].any(axis=1).all()
    chosen = come | gone
    assert chosen.any(axis=0).all()
    assert np.array_equal(sizes_of(scores, new)[~chosen], sizes_of(scores, some)[~chosen])
    block = np.arange(begin - 1, begin + 2 * count)
    assert np.array_equal(np.delete(new, block, axis=1), np.delete(some, block, axis=1))
    assert 0.4 < (ndtr(sizes_of(scores, new)[come]) < 0.25).mean() < 0.8  # small ones, and others


@pytest.mark.parametrize("exchanged", [False, True])
def test_numbers_of_a_drive_change_for_mechanisms_that_come_or_go_alone(scores, exchanged):
    """Only their sizes do, and these are 0 where they are not."""
    rng = generator(16, "test scores")
    some = rng.standard_normal((3000, scores.unknowns))
    new, _ = scores.switched(some, exchanged, rng)
    had, has = there(scores, some), there(scores, new)
    old, numbers = scores.numbers(some), scores.numbers(new)
    names = [each.name for each in fields(Elements) if each.name not in LAWS]
    rest = np.ones(numbers.shape[1], bool)
    for k, name in enumerate(names):
        sizes = (name, *(f"{name}.{part}" for part in ("damping", "stiffness", "share")))
        own = [len(NAMES) + ELEMENTS.index(each) for each in sizes if each in ELEMENTS]
        rest[own] = False
        stays = had[:, k] == has[:, k]
        assert np.array_equal(numbers[stays][:, own], old[stays][:, own]), name
        free = numbers[:, _CONTACT] != CONTACTS.index("held") if name == "contact_preload" else True
        assert np.array_equal((numbers[:, own] != 0.0).all(axis=1) & free, has[:, k] & free), name
    assert np.array_equal(numbers[:, rest], old[:, rest])


# ---- columns for a generator ---------------------------------------------------------------------


def test_columns_are_taken_in_the_order_in_which_numbers_are_asked():
    scores = generator(1, "columns").standard_normal((4, 6))
    columns = ScoreColumns(scores)
    assert np.array_equal(columns.standard_normal(), scores[:, 0])
    assert np.array_equal(columns.standard_normal((1, 2)), scores[:, 1:3])
    assert np.array_equal(columns.random(2), ndtr(scores[:, 3:5]).T)
    assert columns.presence == (3, 2)
    assert np.allclose(columns.uniform(-1.0, 3.0), -1.0 + 4.0 * ndtr(scores[:, 5]))
    with pytest.raises(ValueError, match="more than 6 scores"):
        columns.random()


def test_kinds_of_contact_are_numbers_of_contacts(scores):
    some = generator(1, "test scores").standard_normal((300, scores.unknowns))
    contact = scores.numbers(some)[:, _CONTACT]
    assert [CONTACTS[int(k)] for k in contact] == [scores.kinds[k] for k in scores.contact(some)]
    assert sum(scores.shares_of(contact).values()) == pytest.approx(1.0)
