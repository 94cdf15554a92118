"""Which columns of contact, current and coil belong to a column of travel."""

import numpy as np
import pytest

from breaker.records.channels import Travel, Wiring
from breaker.records.motion import Course
from breaker.records.sheet import Sheet
from tests.exports import way

TIME = np.arange(0.0, 400.0, 0.2)
RISES = 100.0 * (way(TIME, 50.0, 60.0) - way(TIME, 240.0, 40.0))
SIGNAL = 1.0 * ((TIME > 80.0) & (TIME < 260.0))  # closes and opens
LATE = 1.0 * ((TIME > 85.0) & (TIME < 255.0))  # closes later, opens earlier
OHMS = np.where(SIGNAL, 50.0, 4000.0)
NOISE = np.random.default_rng(0).normal(0.0, 0.05, TIME.size)


def paired(columns, travels=1, preamble=()):
    """What belongs to each of the first columns, by motion."""
    sheet = Sheet("a.csv", [*columns], [*columns.values()], preamble=preamble)
    of = [Travel(k, "mm", Course(TIME, sheet.columns[k])) for k in range(travels)]
    return Wiring(sheet, of).paired()


# Columns of a record, and those that belong to the closing of the first of its travels.
RES = "DCRM Res CH1"
BELONGS = [
    *[
        (dict.fromkeys(names, SIGNAL) | {names[0]: RISES}, {"contact_column": contact})
        for *names, contact in (
            ("Travel L2", "Contact L1", "Contact L2", "Contact L2"),
            ("Travel 1 (mm)", "Res 1 (uOhm)", "Contact", "Contact"),
            ("Travel T1", "Res 2 (uOhm)", "Res 2"),  # of the only travel
            ("Travel 1", "Res 1", "Res 2", None),  # channels of resistance are not those of travel
            ("Travel", "Contact 1", "Contact 2", None),
            ("Travel R", "Résistance B", "Résistance R", "Résistance R"),  # its R is no phase
            ("Travel A", "Main A", "Arcing A", "Main B", "Arcing B", "Arcing A"),
            ("Travel A", "Main A", "PIR A", "Resistor contact A", "Main A"),
        )
    ],
    ({"Contact 52a": SIGNAL, "52b": 1.0 - SIGNAL}, {}),  # auxiliary switches
    ({RES: OHMS, "DCRM Current CH2": 50.0 * LATE}, {"contact_column": RES}),
    # A current, a coil and a reading that is constant are no contact.
    ({"Main contact current (A)": 100.0 * SIGNAL}, {}),
    ({"Contact coil current (A)": 4.0 * SIGNAL}, {}),
    ({"Contact (V)": 24.0 + NOISE}, {}),
]


@pytest.mark.parametrize(("columns", "settings"), BELONGS)
def test_a_contact_belongs_to_the_travel_of_its_number_or_phase(columns, settings):
    travel = {} if next(iter(columns)).startswith("Travel") else {"Travel 1": RISES}
    result = paired(travel | columns)[0]["closing"]
    wanted = {key: name for key, name in settings.items() if name}
    assert {key: name for key, name in result.items() if key != "trigger_column"} == wanted


@pytest.mark.parametrize(("motion", "last"), [("closing", 1), ("closing", 2), ("opening", 1)])
@pytest.mark.parametrize("names", [("Travel A", "C1A", "C2A", "C1B"), ("", "Break 1", "Break 2")])
def test_of_breaks_in_series_the_last_to_touch_and_the_first_to_part_counts(names, last, motion):
    columns = dict.fromkeys(names, SIGNAL) | {names[0]: RISES, names[last]: LATE}
    assert paired(columns)[0][motion]["contact_column"] == names[last]


def pulses(*at):
    """Current of a coil, A, from each of these times on."""
    return sum(4.0 * (np.abs(TIME - t - 20.0) < 20.0) for t in at) + 0.0 * TIME


@pytest.mark.parametrize(
    ("coils", "taken"),
    [
        # A second coil of all poles is not that of a second pole.
        ({"Close Coil 1": [20], "Close Coil 2": [35]}, ["Close Coil 1", None]),
        ({"Trip Coil 1": [], "Trip Coil 2": [200]}, [None, "Trip Coil 2"]),
        # Each motion has its own, by the name or by the time.
        ({"Close Coil": [20], "Trip Coil": [200]}, ["Close Coil", "Trip Coil"]),
        ({"Spulenstrom": [20, 200]}, ["Spulenstrom", "Spulenstrom"]),
        ({"Courant moteur": [20, 200]}, [None, None]),
    ],
)
def test_a_coil_of_all_poles_belongs_to_each_of_them(coils, taken):
    columns = {f"Travel T{k}": RISES for k in (1, 2, 3)}
    result = paired(columns | {name: pulses(*at) for name, at in coils.items()}, travels=3)
    for one in result:
        assert [one[m].get("trigger_column") for m in ("closing", "opening")] == taken


def test_of_as_many_coils_as_poles_each_has_one_in_their_order():
    """C1 to C3 close and C4 to C6 trip; the C of their names is no phase."""
    names = [f"Coil Current C{k} (A)" for k in range(1, 7)]
    coils = {n: pulses(20 + k if k < 3 else 197 + k) for k, n in enumerate(names)}
    result = paired({f"Travel T{k}": RISES for k in (2, 4, 5)} | coils, travels=3)
    assert [one["closing"]["trigger_column"] for one in result] == names[:3]
    assert [one["opening"]["trigger_column"] for one in result] == names[3:]


def test_rows_above_the_columns_state_which_contact_belongs_to_which_travel():
    """Contacts are resistances, by turns with the current of their test; CH3 is not connected."""
    columns = {"Travel T1 (mm)": RISES, "Travel T2 (mm)": RISES}
    for k in (1, 2, 3, 4):
        closed = LATE if k == 2 else SIGNAL
        columns |= {f"DCRM Res CH{k} in uOhm": np.where(closed, 300.0, 8000.0)}
        columns |= {f"DCRM Current CH{k} in Amp": 50.0 * closed}
    rows = [["", "", "TR1", "", "TR1", "", "TR2", "", "TR2", ""]]
    rows += [["", "", "RBreak1", "", "RBreak2", "", "NA", "", "YBreak2", ""]]
    first, second = (one["closing"] for one in paired(columns, travels=2, preamble=rows))
    assert first["contact_column"] == "DCRM Res CH2"  # touches last
    assert first["current_column"] == "DCRM Current CH2 in Amp"
    assert second["contact_column"] == "DCRM Res CH4"
    assert not any("contact_column" in one["closing"] for one in paired(columns, travels=2))


@pytest.mark.parametrize(
    ("names", "switching", "expected"),
    [
        ("R S T", "R S T", "S"),
        ("R S T", "R T", ""),  # an unused channel
        ("1 2 3", "1 2 3", "2"),
        ("1 2 3 4", "1 2 3 4", ""),  # a second break of a pole
    ],
)
@pytest.mark.parametrize("share", [0.0, 0.05, np.nan])
def test_a_pole_whose_contact_alone_switches(names, switching, expected, share):
    """Planted fault: a column without samples was not recorded."""
    still = names.split()[1 if expected or "S" in names else 3]
    columns = {f"Travel {n} (mm)": RISES * (share if n == still else 1.0) for n in names.split()}
    columns |= {f"Contact {n}": SIGNAL * (n in switching.split()) for n in names.split()}
    sheet = Sheet("a.csv", [*columns], [*columns.values()])
    course, numbers = Course(TIME, RISES), range(len(names.split()))
    phases = dict(enumerate("RST")) if "R" in names else {}
    moving = [Travel(k, "mm", course, phases.get(k, "")) for k in numbers]
    moving = [travel for travel in moving if names.split()[travel.place] != still]
    unmoved = [sheet.names[travel.place] for travel, _ in Wiring(sheet, moving).still_poles(1)]
    assert unmoved == [f"Travel {expected} (mm)"] * bool(expected and share == share)
