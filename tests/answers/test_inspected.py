"""What `inspect` accepts of an export, `infer` reads with the settings that were proposed."""

from itertools import cycle, product

import numpy as np
import pytest
import yaml

from breaker.answers.operations import read_operations
from breaker.files.manifest import Operation
from breaker.inspection.proposals import inspect_file
from breaker.inspection.wording import overlay_of
from breaker.workflow.configuration import merge
from tests.exports import way

MADE = [*product(["C", "O", "CO", "OCO", "COCO"], [5.0, 10.0, 20.0])]
PARTS = {"C": "closing", "O": "opening"}
LAYOUTS = {  # ways of a stroke, mm; where the open breaker rests; 1 if the reading rises to closed
    "by mm": (178.0, 0.0, 1),
    "falling, off zero": (210.0, 12.0, -1),
    "by a longer linkage": (292.0, 5.0, 1),
}


@pytest.fixture
def export(tmp_path):
    """Write an export: a preamble in pairs, no times, three travels, an unused one, a contact."""

    def write(motions, rate, layout):
        stroke, zero, sign = layout
        time = np.arange(0.0, 250.0 + 150.0 * len(motions), 1.0 / rate)
        rng = np.random.default_rng(len(motions))
        coil, position = np.zeros(time.size), np.full(time.size, float(motions[0] == "O"))
        for k, motion in enumerate(motions):
            moved = way(time, 55.0 + 150.0 * k, 62.0 if motion == "C" else 38.0)
            position += moved if motion == "C" else -moved
            coil += 4.0 * ((time > 30.0 + 150.0 * k) & (time < 90.0 + 150.0 * k))
        mm = [sign * stroke * (1.0 + 0.002 * i) * position + zero for i in range(3)]
        mm = [each + 0.1 * rng.standard_normal(time.size) for each in mm]
        columns = [coil, *mm, np.zeros(time.size), position > 0.45]
        above = ["Test Report,,,", "Serial No :,HV-1,,,Rated Voltage (kV) :,420,,"]
        above += [f"Sampling rate :,{rate:g} kHz,,,Resistance Range (uOhm) :,8000,,"]
        above += [",,,"] * 40 + ["Coil 1 (A),Travel 1 (mm),Travel 2 (mm),Travel 3 (mm),"]
        above[-1] += "Travel 4 (mm),Contact 1,"
        rows = [",".join(f"{cell:.2f}" for cell in row) + "," for row in np.transpose(columns)]
        file = tmp_path / "export.csv"
        file.write_text("\n".join([*above, *rows, ""]), encoding="latin-1")
        return file

    return write


@pytest.mark.parametrize(
    ("motions", "rate", "layout"),
    [(*each, layout) for each, layout in zip(MADE, cycle(LAYOUTS), strict=False)],
)
def test_what_is_accepted_when_looked_at_is_read(export, defaults, motions, rate, layout):
    file = export(motions, rate, LAYOUTS[layout])
    proposal = inspect_file(file, defaults["sensor"])
    config = merge(defaults, yaml.safe_load(overlay_of(proposal)))
    form = config["endurance"]["format"]
    assert form["rate"] == rate
    assert len({each.column for each in proposal.motions}) == 3
    for column in dict.fromkeys(each.column for each in proposal.motions):
        accepted = [each for each in proposal.motions if each.column == column and each.record]
        loose = [Operation(1, file, channel=str(column))]
        read = read_operations(dict.fromkeys(PARTS.values(), loose), form, loose=True)
        assert [each.reason for each in read] == [""] * len(motions)
        assert len(accepted) == len(motions)
        first = sorted((each.record.moves, each.motion) for each in accepted)
        found = sorted((each.raw.moves, each.motion) for each in read)
        assert [motion for _, motion in found] == [motion for _, motion in first]
        assert [at for at, _ in found] == pytest.approx([at for at, _ in first], abs=0.01)
        numbers = [(each.motion, each.operation.number) for each in read]
        assert len(set(numbers)) == len(numbers)
