"""Kinds about how a file is written: units, code pages, rates, headers that contradict samples."""

import numpy as np

from studies.wrong_inputs.ask import Kind, Question, off
from studies.wrong_inputs.desk import Desk
from studies.wrong_inputs.drives import Drive, Record

ENCODINGS = ["latin-1", "cp1252", "utf-8", "utf-8-sig", "utf-16", "utf-16-le"]
ANGLES = ["Winkel [°]", "Angle (°)", "Drehwinkel in °", "Angle [deg]", "Winkel (Grad)", "Angle °"]
NAMES = ["Angle", "Rotation", "Voltage", "Spannung", "Counts", "ADC counts", "Winkel", "Pulses"]


def _one(file, false, **options) -> Question:
    command = ["infer", file, "--json"]
    return Question([command], false, layout=file, look=True, **options)


def _in_mm(wrong: bool, motion: str, truth: dict):
    """Return a test whether a reading that is none in mm was told in mm."""

    def false(said):
        found = [r["quantities"]["stroke"]["median"] for each in said for r in each.records]
        found = [value for value in found if value is not None]
        return f"stroke {found[0]:.4g} told in mm" if found else ""

    return false if wrong else off(motion, truth)


def time_scale(desk: Desk, wrong: bool) -> Question:
    """One record whose times are 10 times too long or too short, such as 13.5 mm in 89 ms."""
    motion, scale = desk.pick(["closing", "opening"]), desk.pick([0.1, 10.0])
    record = desk.record(motion)
    file = desk.write("a.csv", record, time_scale=scale if wrong else 1.0)
    return _one(file, off(motion, record.truth))


def other_unit(desk: Desk, wrong: bool) -> Question:
    """A drive of 100 to 200 mm in inches or cm, without a unit in the file."""
    drive, motion = Drive.high(desk.rng), desk.pick(["closing", "opening"])
    record, scale = desk.record(motion, drive), desk.pick([1 / 25.4, 0.1])
    name = desk.style.words["travel"]
    options = {"travel": name, "scale": scale} if wrong else {"travel": f"{name} [mm]"}
    return _one(desk.write("a.csv", record, **options), off(motion, record.truth))


def angle_column(desk: Desk, wrong: bool) -> Question:
    """Degrees in any code page, beside signs of degree and micro above the samples."""
    motion, record = "closing", desk.record("closing")
    desk.style = desk.style.__class__(**vars(desk.style) | {"encoding": desk.pick(ENCODINGS)})
    angle, span = desk.pick(ANGLES), desk.rng.uniform(8.0, 70.0)
    header = [("Temperatur (°C)", 21), ("R (µOhm)", 38)]
    column = angle if wrong else f"{desk.style.words['travel']} [mm]"
    scale = span / record.truth["stroke"] if wrong else 1.0
    file = desk.write("a.csv", record, header, travel=column, scale=scale)
    return _one(file, _in_mm(wrong, motion, record.truth))


def named_quantity(desk: Desk, wrong: bool) -> Question:
    """A column named angle, voltage or counts, without a unit."""
    record, name = desk.record("closing"), desk.pick(NAMES)
    span = desk.rng.uniform(6.0, 90.0) if "ount" not in name else desk.rng.uniform(50, 290)
    column = name if wrong else f"{desk.style.words['travel']} [mm]"
    scale = span / record.truth["stroke"] if wrong else 1.0
    file = desk.write("a.csv", record, travel=column, scale=scale)
    return _one(file, _in_mm(wrong, "closing", record.truth))


def time_unit(desk: Desk, wrong: bool) -> Question:
    """Times in ms below a header that says s or µs, or in s below one that says ms."""
    motion, record = desk.pick(["closing", "opening"]), desk.record("closing")
    said, scale = desk.pick([("s", 1.0), ("µs", 1.0), ("ms", 1e-3), ("ms", 1e3), ("s", 1e-1)])
    record = desk.record(motion)
    desk.style = desk.style.__class__(**vars(desk.style) | {"digits": 6})
    name = desk.style.words["time"]
    options = {"time": f"{name} [{said}]", "time_scale": scale} if wrong else {}
    return _one(desk.write("a.csv", record, **options), off(motion, record.truth))


def header_rate(desk: Desk, wrong: bool) -> Question:
    """A rate above the samples that is right, beside times that contradict it."""
    motion, factor = desk.pick(["closing", "opening"]), desk.pick([0.1, 0.5, 0.8, 1.25, 2, 5, 10])
    record = desk.record(motion)
    header = desk.header(rate=f"{desk.bench.rate:g}")
    file = desk.write("a.csv", record, header, time_scale=factor if wrong else 1.0)
    return _one(file, off(motion, record.truth))


def _comtrade(desk: Desk, record: Record, rate: float, stamps: float) -> None:
    """Write a record as COMTRADE of 1999: kHz of the header, factor on the stamps."""
    low, high = float(record.travel.min()), float(record.travel.max())
    gain = (high - low) / 60000.0
    counts = np.round((record.travel - low) / gain).astype(int) - 30000
    channel = f"1,Travel,,,mm,{gain:.9g},{low + 30000 * gain:.9g},0,-32767,32767,1,1,P"
    lines = ["Bay,Recorder,1999", "1,1A,0D", channel, "50", "1", f"{1000 * rate:g},{counts.size}"]
    lines += ["03/05/2019,10:00:00.000000"] * 2 + ["ASCII", "1"]
    (desk.folder / "a.cfg").write_text("\r\n".join(lines) + "\r\n", encoding="ascii")
    times = np.round(record.time * 1000.0 * stamps).astype(int)
    rows = [f"{i + 1},{t},{c}" for i, (t, c) in enumerate(zip(times, counts, strict=True))]
    (desk.folder / "a.dat").write_text("\r\n".join(rows) + "\r\n", encoding="ascii")


def comtrade_rate(desk: Desk, wrong: bool) -> Question:
    """COMTRADE whose rate contradicts its stamps; either of them is right."""
    motion, factor = desk.pick(["closing", "opening"]), desk.pick([0.5, 0.8, 1.25, 2.0, 5.0])
    stamps = desk.rng.random() < 0.5
    record, factor = desk.record(motion), factor if wrong else 1.0
    rate = desk.bench.rate * (1.0 if stamps else factor)
    _comtrade(desk, record, rate, factor if stamps else 1.0)
    return _one(desk.folder / "a.cfg", off(motion, record.truth))


def lost_decimals(desk: Desk, wrong: bool) -> Question:
    """Decimal commas that were lost: 1,3 became 13, and 1,25 became 125."""
    record, digits = desk.record("closing"), desk.pick([1, 1, 2, 3])
    travel = np.round(record.travel, digits)
    lost = np.round(travel * 10.0**digits)
    file = desk.write("a.csv", record.changed(travel=lost if wrong else travel))
    return _one(file, off("closing", record.truth))


def comma_in_commas(desk: Desk, wrong: bool) -> Question:
    """Decimal commas between cells that are separated by commas, too; the twin has semicolons."""
    record, words = desk.record("closing"), vars(desk.style)
    separator = "," if wrong else ";"
    desk.style = desk.style.__class__(**words | {"separator": separator, "decimal": ","})
    return _one(desk.write("a.csv", record), off("closing", record.truth))


def printed_stroke(desk: Desk, wrong: bool) -> Question:
    """A stroke above the samples that is 5 to 20 % off the samples' own."""
    drive, factor = Drive.high(desk.rng), desk.pick([0.8, 0.9, 0.95, 1.05, 1.11, 1.2])
    record = desk.record("closing", drive)
    true = record.truth["stroke"]
    name = desk.pick(["Stroke (mm)", "Total Travel [mm]", "Contact Travel(T1)(mm)", "Hub [mm]"])
    header = [(name, f"{true:.1f}")]
    file = desk.write("a.csv", record, header, scale=factor if wrong else 1.0)
    return _one(file, off("closing", record.truth))


def states_other_motion(desk: Desk, wrong: bool) -> Question:
    """A header that says one motion, of samples counted from the other end, told as the other."""
    motion = desk.pick(["closing", "opening"])
    other = {"closing": "opening", "opening": "closing"}[motion]
    record = desk.record(motion)
    header = desk.header(operation=desk.style.words[motion])
    if wrong:
        record = record.changed(travel=record.travel.max() - record.travel)
    file = desk.write("a.csv", record, header)
    plain = desk.write("b.csv", record)  # of the same layout, and states nothing
    command = ["infer", file, "--json", "--motion", other if wrong else motion]
    return Question([command], off(motion, record.truth), layout=plain)


def _limits(desk: Desk, wrong: bool, line: str) -> Question:
    record = desk.record("closing")
    file = desk.write("a.csv", record)
    own = f"limits:\n  - {line}\n".replace("STROKE", f"{record.truth['stroke']:.1f}")

    def false(said):
        found = [v for each in said for r in each.records for v in r.get("limits") or []]
        found = [v["verdict"] for v in found if v["verdict"] in ("pass", "fail")]
        return f"judged: {found}" if found and wrong else ""

    return Question([["infer", file, "--json"]], false, layout=file, own=own)


def limits_off(desk: Desk, wrong: bool) -> Question:
    """Limits a thousand times off: m for mm, µs for ms, or the other way."""
    factor = desk.pick([1e3, 1e-3]) if wrong else 1.0
    name, value = desk.pick([("stroke", 16.0), ("travel_time", 20.0), ("closing_speed", 3.0)])
    side = "upper" if factor > 1.0 or not wrong else "lower"
    return _limits(
        desk, wrong, f"{{name: own, motion: closing, {side}: {{{name}: {factor * value:g}}}}}"
    )


def wide_tolerance(desk: Desk, wrong: bool) -> Question:
    """A tolerance of 100 to 300 %, where 3 % was meant."""
    tolerance = desk.pick([100, 200, 300]) if wrong else 20
    line = f"{{quantity: stroke, reference: STROKE, tolerance: {tolerance} %}}"
    return _limits(desk, wrong, line)


TEXTS = {
    "time scale, one record": Kind(
        time_scale,
        r"\brate\b|time[ _]unit|time scale|too (fast|slow)|speed|\btimes?\b.*\b(10|unit)",
    ),
    "inch or cm, no unit": Kind(other_unit, r"unit of the travel|speed|unit .*not stated"),
    "angle in a code page": Kind(angle_column, r"degree|angle|FILL IN|deg\b|°"),
    "angle, voltage, counts": Kind(
        named_quantity,
        r"FILL IN|needs the mm|not mm\b|no length|is an angle|in degrees|in volts|in counts",
    ),
    "time unit in header": Kind(
        time_unit, r"\brate\b|kHz|time[ _]unit|unit of the time|\btimes?\b"
    ),
    "rate in header": Kind(header_rate, r"\brate\b|kHz"),
    "COMTRADE rate": Kind(comtrade_rate, r"\brate\b|stamps?|kHz"),
    "lost decimals": Kind(lost_decimals, r"speed|too fast|unit|scale|decimal|stroke"),
    "comma in commas": Kind(comma_in_commas, r"decimal|column|comma|cells|separat"),
    "printed stroke": Kind(printed_stroke, r"stroke.*(differ|states|printed|%)|<$|printed"),
    "states other motion": Kind(states_other_motion, r"operation|states?|header|says|sign|motion"),
    "limits off": Kind(limits_off, r"limit|unit|off\b|thousand"),
    "wide tolerance": Kind(wide_tolerance, r"tolerance|wide|limit"),
}
