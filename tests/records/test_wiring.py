"""Which columns of contact and coil go with a column of travel."""

import numpy as np
import pytest

from breaker.records.channels import Travel, stated_contacts
from breaker.records.contact_columns import Beside, columns_beside, first_by_contacts
from breaker.records.description import travel_channels
from breaker.records.motion import Course
from breaker.records.sheet import Sheet
from tests.exports import way, write

TIME = np.arange(0.0, 400.0, 0.2)
SIGNAL = (TIME > 80.0) & (TIME < 260.0)  # closes and opens
LATE = (TIME > 85.0) & (TIME < 255.0)  # closes later, opens earlier


def beside(*names, motion="closing", quiet=(), late=()):
    """What goes with the first of columns; some have no signal, some are closed for less time."""
    columns = [np.where(name in late, LATE, SIGNAL) * 1.0 * (name not in quiet) for name in names]
    columns[0] = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
    layout = Sheet("a.csv", list(names), columns)
    travels = [Travel(0, "mm", Course(TIME, columns[0]))]
    return columns_beside(layout, travels)[0][motion]


@pytest.mark.parametrize(
    ("names", "contact"),
    [
        (("Travel 1", "Contact 1", "Contact 2"), "Contact 1"),
        (("Travel L2", "Contact L1", "Contact L2"), "Contact L2"),
        (("Weg", "Kontakt (V)"), "Kontakt (V)"),
        (("Travel 1 (mm)", "Res 1 (uOhm)", "Contact"), "Contact"),
        (("Travel 1", "Res 1", "Res 2"), None),  # channels of resistance are not those of travel
        (("Travel R", "Res R", "Res Y"), "Res R"),
        (("Travel 1", "Contact 2", "Aux contact 1"), None),
        (("Travel", "Contact 1", "Contact 2"), None),
        (("Travel A", "Main A", "Arcing A", "Main B", "Arcing B"), "Arcing A"),
        (("Travel A", "Main A", "PIR A", "Resistor contact A"), "Main A"),
    ],
)
def test_a_contact_goes_with_the_travel_of_its_number_or_phase(names, contact):
    assert beside(*names).settings.get("contact_column") == contact


@pytest.mark.parametrize(
    "names",
    [
        ("Travel 1", "Contact 1 upper", "Contact 1 lower", "Contact 2 upper"),
        ("Travel 1", "C1A", "C1B", "C2A", "C2B"),
        ("Travel A", "C1A", "C2A", "C1B", "C2B"),
        ("Travel A", "Main A 1", "Main A 2", "Main B 1"),
        ("Travel A", "Break 1 A", "Break 2 A", "Break 1 B"),
        ("Travel", "Break 1", "Break 2"),
    ],
)
@pytest.mark.parametrize("last", [1, 2])
@pytest.mark.parametrize("motion", ["closing", "opening"])
def test_of_breaks_in_series_that_counts_which_touches_last_or_parts_first(names, last, motion):
    found = beside(*names, motion=motion, late=[names[last]])
    assert found.settings["contact_column"] == names[last]
    assert found.others == (names[3 - last],)


@pytest.mark.parametrize(("motion", "coil"), [("closing", "Close coil"), ("opening", "Trip coil")])
def test_a_coil_goes_with_its_motion(motion, coil):
    found = beside("Travel 1", "Close coil", "Trip coil", "Motor current 1", motion=motion)
    assert found == Beside({"trigger_column": coil})


def test_a_channel_without_a_signal_is_none():
    assert beside("Travel 1", "Contact 1", quiet=["Contact 1"]) == Beside({})


def test_channels_of_an_export(tmp_path):
    write(tmp_path / "a.csv", motions=("closing", "opening"))
    found = travel_channels(tmp_path / "a.csv")
    assert [name for name, _ in found.values()] == ["R", "Y", "B"]
    assert found["Travel 2"][1]["opening"].settings == {
        "contact_column": "Contact 2",
        "trigger_column": "Coil 2 (A)",
    }


def wired(coils, *, poles=(1, 2, 3), second=None, motions=("closing", "opening")):
    """Coils of each pole by motion: pulses before each motion, or as given by name."""
    rises = 100.0 * (way(TIME, 60.0, 60.0) - way(TIME, 240.0, 40.0))
    names = [f"Travel T{k}" for k in poles] + [*coils]
    columns = [rises] * len(poles)
    for at in coils.values():
        columns.append(sum(np.abs(TIME - t - 20.0) < 20.0 for t in at) * 4.0 + 0.0 * TIME)
    layout = Sheet("a.csv", names, columns)
    travels = [Travel(k, "mm", Course(TIME, rises)) for k in range(len(poles))]
    found = columns_beside(layout, travels)
    return [[each[of].settings.get("trigger_column") for of in motions] for each in found]


@pytest.mark.parametrize(
    ("coils", "taken"),
    [
        # A second coil of all poles; 1 is a pole only where there are as many coils.
        ({"Close Coil 1": [20], "Close Coil 2": []}, ["Close Coil 1", None]),
        ({"Close Coil 1": [20], "Close Coil 2": [35]}, ["Close Coil 1", None]),
        ({"Close Coil": [20], "Close Coil #2": [35]}, ["Close Coil", None]),
        ({"Trip Coil 1": [], "Trip Coil 2": [200]}, [None, "Trip Coil 2"]),
        # Each motion has its own, by the name or by the time.
        ({"Close Coil": [20], "Trip Coil": [200]}, ["Close Coil", "Trip Coil"]),
        ({"Ic": [20], "Io": [200]}, ["Ic", "Io"]),
        ({"Spulenstrom": [20, 200]}, ["Spulenstrom", "Spulenstrom"]),
        ({"Courant moteur": [20, 200], "Motor current": [20, 200]}, [None, None]),
    ],
)
def test_a_coil_of_all_poles_goes_with_each_of_them(coils, taken):
    assert wired(coils) == [taken] * 3


def test_as_many_coils_as_poles_go_with_one_each():
    names = {f"Close Coil {k} (A)": [20 + k] for k in (1, 2, 3)}
    assert [closing for closing, _ in wired(names)] == [*names]


def test_coils_of_the_other_motion_may_have_the_first_numbers():
    """C1 to C3 close and C4 to C6 trip; the C of their names is no phase."""
    coils = {f"Coil Current C{k} (A)": [20 + k] for k in (1, 2, 3)}
    coils |= {f"Coil Current C{k} (A)": [200 + k] for k in (4, 5, 6)}
    names = [*coils]
    assert wired(coils) == [[names[k], names[k + 3]] for k in range(3)]


def test_transducers_of_other_numbers_take_coils_in_their_order():
    """Of transducers 2, 4 and 5 the first has coil C1 and C4, though there are coils C2 and C5."""
    coils = {f"Coil Current C{k} (A)": [20 + k] for k in (1, 2, 3)}
    coils |= {f"Coil Current C{k} (A)": [200 + k] for k in (4, 5, 6)}
    names = [*coils]
    assert wired(coils, poles=(2, 4, 5)) == [[names[k], names[k + 3]] for k in range(3)]


@pytest.mark.parametrize("shift", [0, 40], ids=["aligned", "in order"])
def test_rows_above_the_columns_say_which_contact_is_of_which_travel(shift):
    """Resistance by turns with the current of its test, which is no coil; CH2 is not of T2."""
    names = ["Coil Current C1 (A)", "Travel T1 (mm)", "Travel T2 (mm)"]
    for k in (1, 2, 3, 4):
        names += [f"DCRM Res CH{k} in uOhm", f"DCRM Current CH{k} in Amp"]
    closes = way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0)
    columns = [3.0 * ((TIME > 20.0) & (TIME < 45.0)), 100.0 * closes, 102.0 * closes]
    for closed in (SIGNAL, LATE, SIGNAL, SIGNAL):
        columns += [np.where(closed, 300.0, 8000.0), 50.0 * closed]
    travel, breaks = ["" for _ in names], ["" for _ in names]
    for place, of, called in zip((3, 5, 7, 9), ("TR1", "TR1", "TR2", "TR2"), "RRYY", strict=True):
        travel[place], breaks[place] = of, f"{called}Break1"
    breaks[7] = "NA"
    rows = [[""] * shift + each for each in (travel, breaks)]
    layout = Sheet("a.csv", names, columns, preamble=rows)
    travels = [Travel(k, "mm", Course(TIME, columns[k])) for k in (1, 2)]
    first, second = columns_beside(layout, travels)
    assert first["closing"].settings["contact_column"] == "DCRM Res CH2"  # touches last
    assert first["closing"].settings["current_column"] == "DCRM Current CH2 in Amp"
    assert second["closing"].settings["contact_column"] == "DCRM Res CH4"
    assert {e["closing"].settings["trigger_column"] for e in (first, second)} == {names[0]}
    silent = Sheet("a.csv", names, columns)
    for each in columns_beside(silent, travels):
        assert "contact_column" not in each["closing"].settings


def test_a_travel_called_that_of_a_contact_is_no_contact():
    """An unused channel: noise, which switches in no motion and is in no row of breaks."""
    names = ["Contact Travel T1 (mm)", "Contact Travel T2 (mm)", "DCRM Res CH1 in uOhm"]
    rows = [["", "", "TR1"], ["", "", "L1Break1"]]
    assert stated_contacts(rows, ["", *names[1:]]) == {2: ("1", "L1")}
    rises = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
    noise = 0.1 * np.random.default_rng(1).standard_normal(TIME.size)
    ohms = np.full(TIME.size, 8000.0)
    layout = Sheet("a.csv", names, [rises, noise, ohms], ["mm", "mm", ""])
    assert first_by_contacts(layout, Travel(0, "mm", Course(TIME, rises))) == {}


def test_coils_of_poles_whose_channels_have_other_numbers_go_in_their_order():
    names = [f"Travel T{k} (mm)" for k in (2, 4, 6)] + [f"C{k} Current (A)" for k in range(1, 4)]
    rises = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
    coils = [3.0 * ((TIME > 20.0) & (TIME < 45.0)) for _ in range(3)]
    layout = Sheet("a.csv", names, [rises, rises, rises, *coils])
    found = columns_beside(layout, [Travel(k, "mm", Course(TIME, rises)) for k in range(3)])
    taken = [each["closing"].settings["trigger_column"] for each in found]
    assert taken == names[3:]


RESISTANCE = np.where(SIGNAL, 50.0, 4000.0)
NOISE = np.random.default_rng(0).normal(0.0, 0.05, TIME.size)


@pytest.mark.parametrize(
    ("columns", "settings"),
    [
        # 52a follows the main contact and 52b is its opposite; a contact goes before both.
        ({"52a": SIGNAL, "52b": ~SIGNAL}, {"contact_column": "52a"}),
        ({"52b": ~SIGNAL}, {"contact_column": "52b"}),
        ({"CB 52a": SIGNAL, "Contact": LATE}, {"contact_column": "Contact"}),
        (
            {"DCRM Res CH1": RESISTANCE, "DCRM Current CH1": 50.0 * LATE},
            {"contact_column": "DCRM Res CH1", "current_column": "DCRM Current CH1"},
        ),
        (
            {"DCRM Current CH1": 50.0 * LATE, "x": NOISE, "DCRM Res CH1": RESISTANCE},
            {"contact_column": "DCRM Res CH1", "current_column": "DCRM Current CH1"},
        ),
        # Of a current that is constant, of a coil, or another channel, is no contact.
        ({"Main contact current (A)": 100.0 + NOISE}, {}),
        ({"Contact coil current (A)": 4.0 * SIGNAL}, {}),
        ({"Contact (V)": 24.0 + NOISE}, {}),
        ({"DCRM Res CH1": RESISTANCE, "DCRM Current CH2": 50.0 * LATE}, "DCRM Res CH1"),
    ],
)
def test_contacts_go_with_their_test_current_and_currents_are_no_contacts(columns, settings):
    travel = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
    sheet = Sheet("a", ["Travel 1", *columns], [travel, *(1.0 * each for each in columns.values())])
    found = columns_beside(sheet, [Travel(0, "mm", Course(TIME, travel))])[0]["closing"].settings
    found = {key: value for key, value in found.items() if key != "trigger_column"}
    assert found == ({"contact_column": settings} if isinstance(settings, str) else settings)


@pytest.mark.parametrize(
    ("name", "values", "first"),
    [
        ("52a", SIGNAL, "closing"),
        ("52b", SIGNAL, "opening"),
        ("Res 1", RESISTANCE, "closing"),
        ("Contact", TIME > 95.0, "closing"),
        ("Contact", TIME > 60.0, "opening"),
        ("Current 1", SIGNAL, None),
    ],
)
def test_contacts_show_which_motion_is_the_first(name, values, first):
    travel = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
    sheet = Sheet("a", ["Travel 1", name], [travel, 1.0 * values])
    found = first_by_contacts(sheet, Travel(0, "mm", Course(TIME, travel)))
    assert {*found.values()} == {first} - {None}
