"""One value of a quantity on all pages, over made-up visits; what the model has a part in is said.

Visits are drawn with a fixed seed, and nothing is left to chance but the visits themselves.
"""

from dataclasses import replace

import numpy as np
import pytest

from breaker.common.numerals import in_digits
from breaker.diagnosis.report import report_of
from breaker.diagnosis.session import Diagnosis
from breaker.model.quantities import EVENTS, INFERRED
from breaker.records.named import ANY
from breaker.records.operations import Operation
from tests.exports import write

LIMITS = [{"quantity": "stroke", "reference": 178, "tolerance": 5}]
LIMITS += [{"name": "late", "motion": "closing", "of": "model", "upper": {"touch_time": 60.0}}]
LIMITS += [{"name": "slow", "motion": "closing", "of": "record", "upper": {"closing_time": 90.0}}]
FEW = {"draws": 50}


def visit_of(seed, folder):
    """Some records of a visit: C-O or one motion, with contact and trigger or without."""
    rng = np.random.default_rng(seed)
    motions = [("closing",), ("closing", "opening"), ("opening", "closing")][rng.integers(3)]
    noise, stroke = rng.uniform(0.02, 0.4), rng.uniform(120, 190)
    form = {"time_column": None, "rate": 5.0}
    form |= {"contact_column": "Contact 1" if rng.random() < 0.5 else "Aux 1"}  # without signal
    form |= {"trigger_column": "Coil 1 (A)"} if rng.random() < 0.5 else {}
    operations = []
    for number in (1, 2):
        file = folder / f"{number}.csv"
        write(file, rate=5.0, seed=seed + number, motions=motions, noise=noise, stroke=stroke)
        operations.append(Operation(number, file, "Travel 1"))
    return {ANY: operations}, form


@pytest.mark.parametrize("seed", range(4))
def test_a_quantity_has_one_value_on_all_pages(seed, tmp_path, levels, defaults):
    operations, form = visit_of(100 * seed, tmp_path)
    config = defaults | {"endurance": defaults["endurance"] | FEW | {"format": form}}
    diagnosis = Diagnosis(config, LIMITS, families=lambda: [levels])
    diagnosis = replace(diagnosis, records=diagnosis.read(operations))
    entries = [e for e in diagnosis.result["records"] if e["accepted"]]
    found = report_of(diagnosis)
    tables = [each for each in found.parts if "± 95 %" in each.head]
    assert len(tables) == len(entries) > 1
    for entry in entries:
        told = entry["quantities"]
        assert not told.keys() & entry["parameters"].keys()
        for part in (part for limit in entry["limits"] for part in limit["parts"]):
            if part["value"] is not None:  # a verdict is on the value that stands above it
                assert part["value"] == told[part["quantity"]]["median"]
        event = EVENTS[entry["motion"]]
        (table,) = (
            each
            for each in tables
            if each.title.endswith(entry["file"].rpartition("/")[2])
            and each.title.startswith(entry["motion"])
        )
        names = [row[0] for row in table.rows if not row[0].startswith(" ")]
        assert len({*names}) == len(names)
        shown = {row[0]: row[2] for row in table.rows}
        for name, each in told.items():
            if name not in INFERRED and each["median"] is not None:
                star = "*" * (each["source"] == "mixed")
                assert shown[name] == in_digits(each["median"], 4) + star
        star = any(f"contact {event}" in note for note in table.notes)
        assert star == any("*" in text for text in shown.values())
        assert not (star and "contact_column" in form)
