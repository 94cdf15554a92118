"""A small fleet: answered as single drives are, an odd one found, and ranked by what is due."""

from types import SimpleNamespace

import numpy as np
import pytest

from breaker.common.document import html_page
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.family.curve_file import write_curve
from breaker.figures.reports import fleet as picture
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.prognosis.drive_document import DIFFERENT, FLEET, Due, FleetRow
from breaker.prognosis.examination import examine, stored
from breaker.prognosis.fleet_page import fleet_document
from breaker.prognosis.members import Member, members_of
from breaker.prognosis.ranking import compare_poles, fleet_table, learn_types, type_table
from breaker.records.folder import list_fleet

TIME, SPREAD = 0.1 * np.arange(760), 0.02  # ms
ODD, WORN, BROKEN, POLES, REMOUNTED = "Q4", "Q2", "Q7", "Q1", "Q8"


def write(folder, breaker, thetas, rng, *, about="", ratio=1.0):
    """Write an operation for each of some parameters, and return the rows of the table; a ratio is
    that of the transducer from the second on.
    """
    rows = []
    for number, theta in enumerate(thetas, start=1):
        for motion in MOTIONS:
            curve = travel(theta[None], TIME, motion, onset=10.0).travel[0]
            file = folder / f"{breaker}{about[:1]}_{motion}_{number}.csv"
            noisy = curve * (ratio if number > 1 else 1.0) + 0.1 * rng.standard_normal(TIME.size)
            write_curve(file, TIME, noisy, motion=motion, operation=number)
            year = 2014 + 3 * number if breaker in (WORN, REMOUNTED) else 2026
            rows.append(f"{file.name},{motion},{number},{breaker},{about},{year}-03-01")
    return rows


@pytest.fixture(scope="module")
def rows(tmp_path_factory, prior):
    """Rows of nine breakers alike, but for one with more friction and one that has worn."""
    folder, rng = tmp_path_factory.mktemp("fleet"), np.random.default_rng(1)
    lines = ["file,motion,operation,breaker,phase,date"]
    for breaker in (f"Q{k}" for k in range(9)):
        theta = prior.medians * np.exp(SPREAD * rng.standard_normal(len(NAMES)))
        theta[3] *= 1.6 if breaker == ODD else 1.0
        worn = theta * np.where(np.array(NAMES) == "gamma_a", 1.4, 1.0)
        for about in "RS" if breaker == POLES else [""]:
            last = worn if breaker == WORN else theta
            ratio = 0.94 if breaker == REMOUNTED else 1.0
            lines += write(folder, breaker, [theta, last], rng, about=about, ratio=ratio)
    for motion in MOTIONS:
        (folder / f"{BROKEN}_{motion}_1.csv").write_text("nothing")
        (folder / f"{BROKEN}_{motion}_2.csv").write_text("nothing")
    (folder / "operations.csv").write_text("\n".join(lines), encoding="utf-8")
    return list_fleet(folder)


@pytest.fixture(scope="module")
def examined(rows, defaults):
    members = members_of(rows, MOTIONS)
    return {(each.breaker, each.phase): examine(each, defaults) for each in members}


@pytest.fixture(scope="module")
def table(examined, prior):
    drives = stored([*examined.values()])
    types = learn_types(drives, prior)
    return fleet_table(drives, types), types


def test_a_drive_gets_what_it_gets_alone(rows, examined, defaults, levels):
    alone = {m: [each for of, each in rows["Q0"] if of == m] for m in MOTIONS}
    records = read_operations(alone, defaults["endurance"]["format"])
    answers = Diagnosis(defaults, families=lambda: [levels]).infer(records)
    first = [each.draws.theta for each in answers if each.record.motion == "closing"]
    assert np.array_equal(examined["Q0", ""].theta, first)


def test_two_visits_are_compared(rows, examined, defaults):
    document = examined[WORN, ""].document
    visits = {}
    for visit, number in (("before", 1), ("today", 2)):
        own = {m: [e for of, e in rows[WORN] if (of, e.number) == (m, number)] for m in MOTIONS}
        visits[visit] = read_operations(own, defaults["endurance"]["format"])
    alone = Diagnosis(defaults).compare(visits).reported
    assert [each.name for each in document.changed] == [each.name for each in alone]
    assert (document.how, document.visits, document.state) == ("visits", 2, "now")
    assert document.due == Due("stiff_drive")


def test_a_drive_without_a_usable_record_stops_no_other(examined):
    found = examined[BROKEN, ""]
    assert (found.document.state, len(found.theta)) == ("unknown", 0)
    assert len(found.document.rejected) == 4


def test_the_odd_one_is_found_and_what_is_due_comes_first(table):
    found, _ = table
    assert {*found.breaker[found.odd != ""]} == {ODD, WORN}  # whose friction has risen as far
    assert found.set_index("breaker").odd[ODD] == "gamma_a"
    assert (found.breaker[0], found.state[0]) == (WORN, "now")
    assert "stiff_drive" in found.reason[0]
    parameters = [each for name in NAMES for each in (name, f"{name}_5", f"{name}_95")]
    assert [*found.columns] == [*FLEET, *parameters]
    poles = found[found.breaker == POLES]
    assert len(poles) == 2
    assert (poles.pole_spread < 0.5).all()
    assert found.pole_spread.isna().sum() == len(found) - 2
    assert {*poles.pole_spread_of} == {"travel_time"}


def test_poles_are_compared_by_instants_where_these_are_shown():
    times = {"R": (30.1, 9.0), "S": (31.4, 12.0), "T": (30.0, 9.1)}
    rows = [
        FleetRow(SimpleNamespace(breaker="Q1", measured=measured))
        for instant, way in times.values()
        for measured in [[("closing_time", "closing", instant), ("travel_time", "closing", way)]]
    ]
    alone = SimpleNamespace(breaker="Q2", measured=[("closing_time", "closing", 40.0)])
    rows.append(FleetRow(alone))
    compare_poles(rows)
    assert rows[0].pole_spread == pytest.approx(1.4)
    assert [each.pole_spread_of for each in rows] == 3 * ["closing_time"] + [""]
    assert np.isnan(rows[3].pole_spread)
    for each in rows[:3]:
        each.document.measured = each.document.measured[1:]
    compare_poles(rows)
    assert (rows[1].pole_spread, rows[1].pole_spread_of) == (3.0, "travel_time")


def test_another_ratio_of_the_transducer_is_no_wear(table, examined):
    document = examined[REMOUNTED, ""].document
    assert (document.state, document.due, document.changed) == (DIFFERENT, Due(), [])
    assert "0.94" in document.differences[0]
    assert {*document.limits.values()} == {"inconclusive"}  # they are of changes of the drive
    found, types = table
    row = found[found.breaker == REMOUNTED].iloc[0]
    assert (row.state, row.due, found.breaker[1]) == (DIFFERENT, "", REMOUNTED)
    page = html_page(fleet_document(found, type_table(types)), [b""])
    assert f'<td class="doubt">{DIFFERENT}</td>' in page
    figure = picture(found, [*examined], types)
    crosses = [e for e in figure.axes[0].lines if e.get_marker() == "x" and e.get_xdata().size]
    assert [each.get_xdata().size for each in crosses] == len(NAMES) * [1]
    assert DIFFERENT in [each.get_text() for each in figure.legends[0].texts]


def test_another_ratio_makes_no_date(defaults, tmp_path, prior):
    rng = np.random.default_rng(2)
    theta = prior.medians * np.where(np.array(NAMES) == "gamma_a", 1.3, 1.0)
    late = {"name": "late", "motion": "closing", "of": "record", "upper": {"travel_time": 11.2}}
    states = []
    for ratio, last in ((1.0, theta), (0.94, prior.medians)):
        lines = write(tmp_path, WORN, [prior.medians, last], rng, ratio=ratio)
        lines = ["file,motion,operation,breaker,phase,date", *lines]
        (tmp_path / "operations.csv").write_text("\n".join(lines), encoding="utf-8")
        (member,) = members_of(list_fleet(tmp_path), MOTIONS)
        document = examine(member, {**defaults, "limits": [late]}).document
        states.append((document.state, bool(document.differences), bool(document.due.limit)))
    assert states == [("plan", False, True), (DIFFERENT, True, False)]
    assert document.differences
    assert document.changed == []  # as no trend is told


def test_limits_of_a_type_are_of_its_drives_in_any_spelling(rows, defaults):
    operations = {m: [e for of, e in rows["Q0"] if of == m] for m in MOTIONS}
    types = {"GL 314": {"limits": {"closing stroke": [20, 22], "opening travel_time": [None, 50]}}}
    states = {}
    for name in ("gl-314", "GL318"):
        document = examine(Member("Q0", "", name, operations), defaults, types).document
        states[name] = document.state, document.limits
    verdicts = {"closing stroke by type": "fail", "opening travel_time by type": "pass"}
    assert states == {"gl-314": ("now", verdicts), "GL318": ("not judged", {})}


def test_a_drive_without_limits_is_listed_by_what_is_known(table):
    found, _ = table
    quiet = found[(found.state == "not judged") & (found.odd == "")]
    assert len(quiet) > 4
    assert (quiet.reason != "").all()
    assert quiet.off_type.abs().gt(0.0).all()
    assert "unknown" not in {*quiet.state}
    assert found.state[found.breaker == BROKEN].tolist() == ["unknown"]
    assert found.change[found.breaker == WORN].abs().item() > 5.0


@pytest.mark.parametrize("loss", [0.09, 0.0])
def test_many_operations_are_a_life(tmp_path, prior, defaults, loss):
    rng, steps = np.random.default_rng(1), np.linspace(0.0, 1.0, 30)
    thetas = [prior.medians * (1.0 - loss * step * (np.arange(7) == 5)) for step in steps]
    lines = ["file,motion,operation,breaker,phase,date", *write(tmp_path, "Q0", thetas, rng)]
    (tmp_path / "operations.csv").write_text("\n".join(lines), encoding="utf-8")
    wear = {**defaults["trend"], "reference": 6, "settle": 5, "draws": 60}
    few = {**defaults, "trend": wear, "fleet": {"followed": 30}}
    (member,) = members_of(list_fleet(tmp_path), MOTIONS)
    document = examine(member, few).document
    assert (document.how, document.trust) == ("life", [])
    assert document.limits.keys() == {"stiff_drive", "tired_closing"}
    if loss:
        assert "f" in {each.name for each in document.changed}
        assert document.state in ("plan", "now")
        assert document.due.limit == "tired_closing"
    else:
        assert document.due.operation is None
        assert document.changed == []


def test_a_life_needs_no_comparison_of_its_first_visit(tmp_path, prior, defaults):
    """Planted fault: the life was lost where no record of the first visit can be used."""
    lines = write(tmp_path, WORN, 13 * [prior.medians], np.random.default_rng(1))
    lines = ["file,motion,operation,breaker,phase,date", *lines]
    (tmp_path / "operations.csv").write_text("\n".join(lines), encoding="utf-8")
    for motion in MOTIONS:
        (tmp_path / f"{WORN}_{motion}_1.csv").write_text("nothing")
    wear = {**defaults["trend"], "reference": 6, "settle": 5, "draws": 60}
    few = {**defaults, "trend": wear, "fleet": {"followed": 13}}
    (member,) = members_of(list_fleet(tmp_path), MOTIONS)
    document = examine(member, few).document
    assert (document.how, document.visits, document.trust) == ("life", 13, [])
    assert document.limits.keys() == {"stiff_drive", "tired_closing"}


def test_a_life_knows_the_mean_of_what_rows_of_both_motions_say(
    tmp_path, prior, defaults, monkeypatch
):
    """Planted fault: the last row of an operation stood for it."""
    rows = write(tmp_path, "Q0", 13 * [prior.medians], np.random.default_rng(1))
    of = {"closing": "20,greased", "opening": "24,"}
    rows = [f"{row},{of[row.split(',')[1]]}" for row in rows]
    head = "file,motion,operation,breaker,phase,date,temperature,event"
    (tmp_path / "operations.csv").write_text("\n".join([head, *rows]), encoding="utf-8")
    known = {}

    def follow(*_, **more):
        known.update(more)
        raise ValueError("enough")

    monkeypatch.setattr("breaker.prognosis.examination.follow_curves", follow)
    (member,) = members_of(list_fleet(tmp_path), MOTIONS)
    assert examine(member, {**defaults, "fleet": {"followed": 13}}).document.trust == ["enough"]
    assert known["conditions"] == {"temperature": dict.fromkeys(range(1, 14), 22.0)}
    assert known["events"].keys() == {*range(1, 14)}
