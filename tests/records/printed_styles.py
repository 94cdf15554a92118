"""Styles in which analysers print results, with made-up values and what each value is.

In a style ``<closing_time R>`` is a value of phase R that is to be compared, ``<-closing_time>``
one like it that is not, and ``<closing_time *>`` a cell for each phase. ``C``, ``O`` or ``?``
(either) before a quantity is its motion. P is the phase of a block, K its number.
"""

import re
from pathlib import Path

import numpy as np

from tests.exports import way

LIKE = {"stroke": 178.0, "over_travel": 10.0, "rebound": 11.0, "closing_time": 58.0}
LIKE |= {"opening_time": 31.0, "closing_speed": 4.2, "opening_speed": 6.8, "bounce_time": 2.0}
LIKE |= {"wipe_at_touch": 90.0, "coil_current": 4.0}
STARTS = {"closing": 30.0, "opening": 240.0}


def each(text):
    """Repeat lines for each phase, P, and its number, K."""
    lines = (re.sub(r"\bP\b", p, text).replace("K)", f"{k})") for k, p in enumerate("RYB", 1))
    return "\n".join(lines)


STYLES = {
    "a column for each phase": """Test Results
Parameter,Unit,R,Y,B
Closing Time,ms,<closing_time *>
Contact Travel,mm,<?stroke *>
Closing Over Travel,mm,<over_travel *>
Opening Over Travel,mm,<rebound *>
Over Travel,mm,<-over_travel *>
Close Contact Wipe,mm,<wipe_at_touch *>
Close Velocity,m/s,<-closing_speed *>
Close Velocity 10-90 %,m/s,<-closing_speed *>
Max. Velocity,m/s,<-closing_speed *>
Rebound,mm,<-rebound *>
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
Over Travel (mm) : <rebound P>
Avg. Velocity (m/s) : <-opening_speed>
"""),
    "two lines of heads": """Close Velocity Point 1 (%) :,20,,Close Velocity Point 2 (%) :,80
,CLOSE,,,OPEN,,,
Pole,Time (ms),Travel (mm),Velocity (m/s),Time (ms),Travel (mm),Velocity (m/s),Max. Time (ms)
"""
    + each(
        "P,<closing_time P>,<Cstroke P>,<closing_speed P>,<opening_time P>,<Ostroke P>,"
        "<-opening_speed>,<-opening_time>"
    ),
    "limits": each("""Pole P,,,,,
Parameter,Unit,Min,Actual,Max,Result
Close Time,ms,<-closing_time>,<closing_time P>,<-closing_time>,PASS
Stroke,mm,<-stroke>,<?stroke P>,<-stroke>,PASS
,,,,,""")
    + each("\nLIMITS\nClose\nOpening Time P (ms) : <-opening_time>")
    + each("\nMEASURED\nOpen\nOpening Time P (ms) : <opening_time P>"),
    "brackets": """Velocity Points In :,%,,Open1 :,30,,DefClose :,10
Close1 :,30,,Close2 :,60,,DefOpen :,10
"""
    + each("""Mechanism Travel(TK)(mm) :,<-stroke>,,Contact Travel(TK)(mm) :,<?stroke P>
Close - Over Travel(TK)(mm) :,<over_travel P>,,Open -Rebound(TK)(mm) :,<-rebound>
Close - Velocity (m/s)(TK) :,<closing_speed P>,,Open - Velocity (m/s)(TK) :,<-opening_speed>
Close - Datum Velocity (m/s)(TK) :,<-closing_speed>,,Coil Current (A)(CK) :,<-coil_current>""")
    + "\nClose - Datum Velocity (m/s)(T3) :,\nClose  -Velocity (m/s) :,<-closing_speed>"
    + "\n,,,TR1,,TR2,,TR3,\n,,,RBreak1,,YBreak1,,BBreak1,",
    "phases behind a name": """Ranges
Closing Time (ms)  R: <closing_time R>  Y: <closing_time Y>  B: <closing_time B>
Stroke (mm) : R=<?stroke R>; Y=<?stroke Y>; B=<?stroke B>
Stroke (mm) : <-stroke>; <-stroke>; <-stroke>
Closing Time Tolerance (ms) : <-bounce_time>""",
    "contacts": """Timing,Phase R,Phase Y,Phase B
Main Contact Closing Time (ms),<-closing_time *>
Arcing Contact Closing Time (ms),<-closing_time *>
PIR Closing Time (ms),<-closing_time *>
Aux. Contact 52a Closing Time (ms),<-closing_time *>
Close Coil Current (A),<Ccoil_current *>
Average Close Coil Current (A),<-coil_current *>""",
    "lines": each("""P-phase opening time <opening_time P> ms
Pole P,Closing time,<closing_time P>,ms,OK
Pole P,Closing time,<-closing_time> (max),ms"""),
}


def filled(text, seed):
    """Return the lines of a style, and by value what it is: phase, motion and quantity."""
    rng, truth = np.random.default_rng(seed), {}

    def draw(found):
        no, of, quantity, phase = found.groups()
        cells = []
        for p in "RYB" if phase == "*" else [phase]:
            value = 0.0
            while not value or value in truth:
                value = round(LIKE[quantity] * rng.uniform(0.9, 1.1), 2)
            opens = of == "O" or quantity.startswith(("opening", "rebound"))
            motion = "" if of == "?" else "opening" if opens else "closing"
            truth[value] = None if no else (p, motion, quantity)
            cells.append(f"{value:.2f}")
        return ",".join(cells)

    return re.sub(r"<(-?)([CO?]?)(\w+)(?: ([\w*]+))?>", draw, text), truth


def write_style(path, name, seed=0):
    """Write a C-O of three poles below results in a style; return what its values are."""
    text, truth = filled(STYLES[name], seed)
    rng, t = np.random.default_rng(seed), np.arange(0.0, 450.0, 0.2)
    columns, others = {}, {}
    for k, phase in enumerate("RYB", 1):
        since = {m: t - start - 0.3 * k for m, start in STARTS.items()}
        y = way(since["closing"], 25.0, 62.0) - way(since["opening"], 15.0, 38.0)
        columns[f"Travel T{k} (mm)" if name == "brackets" else f"Travel {phase} (mm)"] = 178.0 * y
        others[f"Contact {phase}"] = 1.0 * (y > 0.45)
        for word, x in zip(("Close", "Trip"), since.values(), strict=True):
            pulse = 4.0 * ((x > 0) & (x < 40)) * (1 - np.exp(-np.clip(x, 0, None) / 5))
            others[f"{word} coil {phase} [A]"] = pulse
    columns |= others
    rows = [x + 0.02 * rng.standard_normal(t.size) * (np.ptp(x) > 1.0) for x in columns.values()]
    lines = [",".join(f"{v:.3f}" for v in row) for row in np.stack(rows, axis=1)]
    lines = ["Sampling Speed (kC) :,5", *text.split("\n"), ",".join(columns), *lines]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return truth
