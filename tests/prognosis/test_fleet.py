"""A small fleet: drives are examined as single ones, and stand in one table beside their type."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.plain_values import to_json
from breaker.diagnosis.inspection_change import compare_inspections
from breaker.diagnosis.session import Diagnosis
from breaker.family.endurance import write_curve
from breaker.model.curves import travel
from breaker.model.parameters import MOTIONS, NAMES
from breaker.prognosis.fleet import drives_of, examine, inspections_of
from breaker.prognosis.fleet_table import fleet_table, outliers, read_results
from breaker.records.folder import list_fleet
from breaker.records.operations import Operation

TIME, SPREAD = 0.1 * np.arange(760), 0.02  # ms
WORN, DIFFERENT, BROKEN, REMOUNTED = "Q2", "Q4", "Q7", "Q8"
HEAD = "file,motion,operation,breaker,phase,date"


def write(folder, breaker, thetas, rng, *, ratio=1.0, years=(2026,)):
    """Write an operation for each of some parameters, in these years, and return the rows of the
    table; a ratio is that of the transducer from the second on.
    """
    rows = []
    for number, theta in enumerate(thetas, start=1):
        for motion in MOTIONS:
            curve = travel(theta[None], TIME, motion, onset=10.0).travel[0]
            file = folder / f"{breaker}_{motion}_{number}.csv"
            noisy = curve * (ratio if number > 1 else 1.0) + 0.1 * rng.standard_normal(TIME.size)
            write_curve(file, TIME, noisy, motion=motion, operation=number)
            date = f"{years[(number - 1) % len(years)]}-03-01"
            rows.append(f"{file.name},{motion},{number},{breaker},,{date}")
    return rows


def listed(folder, lines, defaults):
    (folder / "operations.csv").write_text("\n".join([HEAD, *lines]), encoding="utf-8")
    return [*drives_of(list_fleet(folder), MOTIONS, defaults["endurance"]["format"])]


@pytest.fixture
def one_drive(tmp_path, defaults):
    """Write a drive, whose first closing may be lost."""

    def one_drive(thetas, years=(2026,), *, lost=False):
        lines = write(tmp_path, "Q0", thetas, np.random.default_rng(1), years=years)
        if lost:
            (tmp_path / "Q0_closing_1.csv").write_text("nothing")
        return listed(tmp_path, lines, defaults)[0]

    return one_drive


@pytest.fixture(scope="module")
def drives(tmp_path_factory, prior, defaults):
    """Nine drives: one with more damping, one that has worn, one remounted, one not readable."""
    folder, rng, lines = tmp_path_factory.mktemp("fleet"), np.random.default_rng(1), []
    for breaker in (f"Q{k}" for k in range(9)):
        theta = prior.medians * np.exp(SPREAD * rng.standard_normal(len(NAMES)))
        theta[3] *= 1.6 if breaker == DIFFERENT else 1.0
        worn = np.where((np.array(NAMES) == "gamma_a") & (breaker == WORN), 1.4, 1.0)
        years = (2017, 2020) if breaker in (WORN, REMOUNTED) else (2026,)
        ratio = 0.94 if breaker == REMOUNTED else 1.0
        lines += write(folder, breaker, [theta, theta * worn], rng, ratio=ratio, years=years)
    for motion in MOTIONS:
        (folder / f"{BROKEN}_{motion}_1.csv").write_text("nothing")
        (folder / f"{BROKEN}_{motion}_2.csv").unlink()
    return listed(folder, lines, defaults)


@pytest.fixture(scope="module")
def results(drives, defaults):
    return [examine(drive, defaults, {}) for drive in drives]


def of(breaker, results):
    return next(result for result in results if result.breaker == breaker)


def test_two_inspections_are_compared_as_alone(drives, results, defaults):
    drive, result = of(WORN, drives), of(WORN, results)
    alone = Diagnosis(defaults, [e for e in defaults["limits"] if e["of"] == "change"])
    before, today = (alone.read({m: [e] for m, e in rows}) for rows in drive.inspections)
    change = compare_inspections(alone, {"before": before, "today": today})
    assert (result.state, result.limits[0].limit, result.inspections) == ("due", "stiff_drive", 2)
    assert {e.limit: e.p_exceeded for e in result.limits} == {
        item["name"]: item["p_exceeded"] for item in change.limits
    }


def test_drives_without_a_usable_record_or_with_another_ratio_are_unknown(results):
    result, remounted = of(BROKEN, results), of(REMOUNTED, results)
    assert (result.state, result.rejected, result.measured) == ("unknown", 4, [])
    files = {f"{BROKEN}_{motion}_{number}.csv" for motion in MOTIONS for number in (1, 2)}
    assert {file for file in files for note in result.remarks if file in note.text} == files
    assert (remounted.state, len(remounted.limits)) == ("unknown", 0)
    assert "different-setup-check" in {note.code for note in remounted.remarks}


def test_the_table_has_the_urgent_drive_first_and_marks_those_unlike_their_type(results):
    table = fleet_table(read_results(to_json(results)))
    assert table.equals(fleet_table(results))
    assert (len(table), table.breaker[0], table.state[0]) == (9, WORN, "due")
    assert {*table.breaker[table.differs == True]} == {DIFFERENT, WORN}  # noqa: E712, nan is not
    assert table.set_index("breaker").difference[DIFFERENT] > 30.0


def test_false_outliers_are_as_rare_as_stated():
    rng, result = np.random.default_rng(1), []
    deviates = np.arange(12) < 2
    for _ in range(1000):
        values = 10.0 + 0.1 * rng.standard_normal(12) + 2.0 * deviates
        usual, p = outliers(values, np.full(12, 1e-3), 0.05)
        result.append([not usual[deviates].any() and (p[deviates] < 0.05).all(), usual[2:].all()])
    assert np.mean(result, axis=0) == pytest.approx([1.0, 0.95], abs=0.03)


def test_operations_without_a_date_belong_to_the_inspection_before():
    dates = {1: "2012-05-01", 2: "", 3: "2012-05-20T10:00:00", 7: "2020-01-01", 8: ""}
    rows = [("closing", Operation(number, "", date=date)) for number, date in dates.items()]
    numbers = [[item.number for _, item in some] for some in inspections_of(rows[::-1])]
    assert numbers == [[1, 2, 3], [7, 8]]
    assert len(inspections_of([rows[1], rows[4]])) == 1


def test_limits_of_a_type_count_in_any_spelling(drives, defaults):
    types = {"GL 314": {"limits": {"closing stroke": [20, 22], "opening travel_time": [None, 50]}}}
    result = [
        examine(replace(of("Q0", drives), type=name), defaults, types)
        for name in ("gl-314", "GL314", "GL318")
    ]
    states = {"closing stroke by type": "due", "opening travel_time by type": "ok"}
    assert [{e.limit: e.state for e in item.limits} for item in result] == [states, states, {}]
    assert "no-limit-of-drive" in {note.code for note in result[2].remarks}
    assert {*fleet_table(result).type} == {"gl-314", "GL318"}  # two spellings are one


def test_a_limit_is_judged_where_the_first_inspection_lacks_its_motion(one_drive, prior, defaults):
    """Planted fault: a limit that is exceeded was unknown, as compared records had no closing."""
    drive = one_drive(2 * [prior.medians], (2017, 2020), lost=True)
    late = {"name": "late", "motion": "closing", "of": "record", "upper": {"travel_time": 5.0}}
    result = examine(drive, {**defaults, "limits": [late]}, {})
    assert (result.inspections, result.state, result.limits[0].p_exceeded) == (2, "due", 1.0)


def test_yearly_inspections_show_wear_before_the_limit(one_drive, prior, defaults):
    """A force that falls by 12 % in ten years, two records a year, and a limit at 10 %."""
    falls = np.repeat(np.linspace(0.0, 0.12, 10), 2)[:, None] * (np.array(NAMES) == "f")
    drive = one_drive(prior.medians * (1.0 - falls), np.repeat(range(2000, 2010), 2))
    limits = [{"name": "tired", "of": "change", "lower": {"f": "-10 %"}}]
    limits += [{"name": "stiff", "of": "change", "upper": {"gamma_a": "+15 %"}}]
    config = {**defaults, "limits": limits, "trend": {**defaults["trend"], "draws": 60}}
    first = (replace(drive, inspections=drive.inspections[:count]) for count in (2, 8, 10))
    result = [examine(item, config, {}) for item in first]
    assert [item.state for item in result] == ["ok", "planned", "due"]
    assert [item.limits[-1].state for item in result] == ["ok", "ok", "ok"]  # of stiff
    assert result[1].limits[0].service_by_date.startswith("200")
