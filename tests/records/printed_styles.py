"""Styles in which analysers print results, with made-up values and what each value is.

In a style ``<closing_time R>`` is a value of phase R that is to be compared, ``<-closing_time>``
one like it that is not, and ``<closing_time *>`` a cell for each phase. ``C``, ``O`` or ``?``
(either) before a quantity is its motion. P is the phase of a block, K its number.
"""

import re
from pathlib import Path

import numpy as np

from tests.exports import way

LIKE = {"stroke": 178.0, "over_travel": 10.0, "opening_over_travel": 11.0, "closing_time": 58.0}
LIKE |= {"opening_time": 31.0, "closing_speed": 4.2, "opening_speed": 6.8, "bounce_time": 2.0}
LIKE |= {"closing_wipe": 90.0, "coil_current": 4.0}
STARTS = {"closing": 30.0, "opening": 240.0}
ZONES = {"10": "from 10 to 90 % of stroke", "20": "from 20 to 80 % of stroke"}
ZONES |= {"30": "from 30 to 60 % of stroke"}
ZONES |= {"touch": "from 10 ms before touch to touch"}
ZONES |= {"separation": "from separation to 10 ms after separation"}


def each(text, phases="RYB"):
    """Repeat lines for each phase, P, and its number, K."""
    lines = (re.sub(r"\bP\b", p, text).replace("K)", f"{k})") for k, p in enumerate(phases, 1))
    return "\n".join(lines)


STYLES = {
    "a column for each phase": """Test Results
Parameter,Unit,R,Y,B
Closing Time,ms,<closing_time *>
Opening Time,ms,<opening_time *>
Contact Travel,mm,<?stroke *>
Over Travel,mm,<over_travel *>
Opening Over Travel,mm,<opening_over_travel *>
Close Velocity 10-90 %,m/s,<closing_speed * 10>
Contact Wipe,mm,<closing_wipe *>
Close Velocity,m/s,<-closing_speed *>
Max. Velocity,m/s,<-closing_speed *>
Rebound,mm,<-opening_over_travel *>
Rated Travel,mm,<-stroke *>
Reference Closing Time,ms,<-closing_time *>
Close Time Spread,ms,<-bounce_time>""",
    "headings": each("""CLOSE - Phase P
Contact Time (ms) : <closing_time P>
Travel (mm) : <Cstroke P>
Over Travel (mm) : <over_travel P>
Velocity (m/s) : <-closing_speed>
Closing Time nominal (ms) : <-closing_time>

OPEN - Phase P
Contact Time (ms) : <opening_time P>
Travel (mm) : <Ostroke P>
Over Travel (mm) : <opening_over_travel P>
Avg. Velocity (m/s) : <-opening_speed>
"""),
    "two lines of heads": """Close Velocity Point 1 (%) :,20,,Close Velocity Point 2 (%) :,80
,CLOSE,,,OPEN,,,
Pole,Time (ms),Travel (mm),Velocity (m/s),Time (ms),Travel (mm),Velocity (m/s),Max. Time (ms)
"""
    + each(
        "P,<closing_time P>,<Cstroke P>,<closing_speed P 20>,<opening_time P>,<Ostroke P>,"
        "<-opening_speed>,<-opening_time>"
    ),
    "limits": each("""Pole P,,,,,
Parameter,Unit,Min,Actual,Max,Result
Close Time,ms,<-closing_time>,<closing_time P>,<-closing_time>,PASS
Open Time,ms,<-opening_time>,<opening_time P>,<-opening_time>,PASS
Stroke,mm,<-stroke>,<?stroke P>,<-stroke>,PASS
,,,,,""")
    + each("\nLIMITS\nClose\nBounce P (ms) : <-bounce_time>\nTravel P (mm) : <-stroke>")
    + each("\nMEASURED\nOpen\nTravel P (mm) : <Ostroke P>"),
    "unit of points": "Velocity Points In :,%\nClose1 :,30,,Close2 :,60\n"
    + each("Close - Velocity P (m/s) :,<closing_speed P 30>,,Open - Velocity P :,<-opening_speed>"),
    "row of units": """Phase,Close Time,Open Time,Travel,Max Travel,Close Time 10-90 %
,ms,ms,mm,mm,ms
"""
    + each("P,<closing_time P>,<opening_time P>,<?stroke P>,<-stroke>,<-bounce_time>"),
    "lines": each("""P-phase opening time <opening_time P> ms
Pole P,Closing time,<closing_time P>,ms,OK
Pole P,Closing time,<-closing_time> (max),ms"""),
    "brackets": """Velocity Points :
Close1 :,30,,Open1 :,30,,DefClose :,10
Close2 :,60,,Open2 :,60,,DefOpen :,10
"""
    + each("""Mechanism Travel(TK)(mm) :,<-stroke>,,Contact Travel(TK)(mm) :,<?stroke P>
Close - Over Travel(TK)(mm) :,<over_travel P>,,Open -Rebound(TK)(mm) :,<-opening_over_travel>
Close - Datum Velocity (m/s)(TK) :,<-closing_speed>,,Coil Current (A)(CK) :,<-coil_current>""")
    + "\n,,,"
    + ",".join("Close -Velocity (m/s) :,<-closing_speed>" for p in "RYB")
    + "\n,,,"
    + ",".join("Open -Velocity (m/s) :,<-opening_speed>" for p in "RYB")
    + "\n,,,TR1,,TR2,,TR3,\n,,,RBreak1,,YBreak1,,BBreak1,",
    "german": each(
        """Einschaltzeit P [ms],<closing_time P>
Ausschaltzeit P [ms],<opening_time P>
Hub P [mm],<?stroke P>
Überhub Einschaltung P [mm],<over_travel P>
Sollwert Hub P [mm],<-stroke>
Einschaltgeschwindigkeit P [m/s],<-closing_speed>""",
        ["L1", "L2", "L3"],
    ),
    "phases behind a name": """Ranges
Closing Time (ms)  R: <closing_time R>  Y: <closing_time Y>  B: <closing_time B>
Opening Time (ms) : R=<opening_time R>; Y=<opening_time Y>; B=<opening_time B>
Stroke (mm) : R=<?stroke R>; Y=<?stroke Y>; B=<?stroke B>
Stroke (mm) : <-stroke>; <-stroke>; <-stroke>
Rated Closing Time (ms) : <-closing_time>
Closing Time Tolerance (ms) : <-bounce_time>""",
    "contacts": """Timing,Phase R,Phase Y,Phase B
Main Contact Closing Time (ms),<-closing_time *>
Arcing Contact Closing Time (ms),<-closing_time *>
PIR Closing Time (ms),<-closing_time *>
Aux. Contact 52a Closing Time (ms),<-closing_time *>
Main Contact Opening Time (ms),<-opening_time *>
Close Coil Current (A),<Ccoil_current *>
Trip Coil Peak Current (A),<Ocoil_current *>
Close Coil Resistance (Ohm),<-coil_current *>
Average Close Coil Current (A),<-coil_current *>""",
    "zones behind values": each("""PHASE P,,,
CLOSE TIME,<closing_time P>,MS,OVER-TRAVEL,<over_travel P>,MM,BOUNCE-BACK,<-bounce_time>,MM
CLOSE VELOCITY : <closing_speed P 10> M/S (10%-90%)
CLOSE VELOCITY (from 20 to 80 %) : <closing_speed P 20> M/S"""),
    "remarks": each("""Phase P Closing Time = <closing_time P> ms (max <-closing_time> ms)
Phase P Opening Time = <opening_time P> ms [<-opening_time> .. <-opening_time>]
Phase P Closing Speed (10 ms before touch) = <closing_speed P touch> m/s
Phase P Close-Open Time = <-closing_time> ms"""),
}
OF_FILE = {"german": {"phases": ["L1", "L2", "L3"], "sign": ";"}}
OF_FILE |= {"brackets": {"travel": "Contact Travel T{k} (mm)", "contact": "DCRM Res CH{k} in uOhm"}}
USUAL = {"phases": "RYB", "sign": ",", "breaks": 1, "travel": "Travel {p} (mm)"}
USUAL |= {"contact": "Contact {p}"}


def filled(text, phases, seed):
    """Return the lines of a style, and by value what it is: phase, motion, quantity and zone."""
    rng, truth = np.random.default_rng(seed), {}

    def draw(found):
        no, of, quantity, phase, zone = found.groups()
        cells = []
        for p in phases if phase == "*" else [phase]:
            value = 0.0
            while not value or value in truth:
                value = round(LIKE[quantity] * rng.uniform(0.9, 1.1), 2)
            opens = of == "O" or quantity.startswith(("opening", "opening_over_travel"))
            motion = "" if of == "?" else "opening" if opens else "closing"
            truth[value] = None if no else (p, motion, quantity, ZONES.get(zone, ""))
            cells.append(f"{value:.2f}")
        return ",".join(cells)

    return re.sub(r"<(-?)([CO?]?)(\w+)(?: ([\w*]+))?(?: (\w+))?>", draw, text), truth


def write_style(path, name, seed=0):
    """Write a C-O of three poles below results in a style; return what its values are."""
    of = USUAL | OF_FILE.get(name, {})
    text, truth = filled(STYLES[name], of["phases"], seed)
    rng, t = np.random.default_rng(seed), np.arange(0.0, 450.0, 0.2)
    resists, columns, others = "Res" in of["contact"], {}, {}
    for k, phase in enumerate(of["phases"], 1):
        since = {m: t - start - 0.3 * k for m, start in STARTS.items()}
        y = way(since["closing"], 25.0, 62.0) - way(since["opening"], 15.0, 38.0)
        columns[of["travel"].format(p=phase, k=k)] = 178.0 * y
        for b in range(of["breaks"]):
            closed = y > 0.45 + 0.04 * b
            called = f"Break {b + 1} {phase}" if of["breaks"] > 1 else of["contact"]
            others[called.format(p=phase, k=k)] = (
                np.where(closed, 60, 8000) if resists else 1.0 * closed
            )
            if resists:
                others[f"DCRM Current CH{k} in Amp"] = 50.0 * closed
        for word, (motion, x) in zip(("Close", "Trip"), since.items(), strict=True):
            pulse = 4.0 * ((x > 0) & (x < 40)) * (1 - np.exp(-np.clip(x, 0, None) / 5))
            if not resists:
                others[f"{word} coil {phase} [A]"] = pulse
            elif motion == "closing":
                columns[f"Coil Current C{k} (A)"] = pulse
    columns |= others
    rows = [x + 0.02 * rng.standard_normal(t.size) * (np.ptp(x) > 1.0) for x in columns.values()]
    lines = [",".join(f"{v:.3f}" for v in row) for row in np.stack(rows, axis=1)]
    lines = ["Sampling Speed (kC) :,5", *text.split("\n"), ",".join(columns), *lines]
    if of["sign"] == ";":
        lines = [line.replace(",", ";").replace(".", ",") for line in lines]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return truth, of["phases"]
