"""What `inspect` accepts of an export, `infer` reads with the settings that were proposed."""

from itertools import cycle, product

import pytest
import yaml

from breaker.configuration.loading import merge
from breaker.drive.answers.drive_records import read_operations
from breaker.reading.files.operations_table import Operation
from breaker.reading.inspection.proposal_words import overlay_of
from breaker.reading.inspection.setting_proposal import inspect_file
from tests.exports import write

MADE = [*product(["C", "O", "CO", "OCO", "COCO"], [5.0, 20.0])]
PARTS = {"C": "closing", "O": "opening"}
LAYOUTS = {  # ways of a stroke, mm; where the open breaker rests; 1 if the reading rises to closed
    "by mm": (178.0, 0.0, 1),
    "falling, off zero": (210.0, 12.0, -1),
    "by a longer linkage": (292.0, 5.0, 1),
}


@pytest.mark.parametrize(
    ("motions", "rate", "layout"),
    [(*each, layout) for each, layout in zip(MADE, cycle(LAYOUTS), strict=False)],
)
def test_what_is_accepted_when_looked_at_is_read(tmp_path, defaults, motions, rate, layout):
    file, (stroke, zero, sign) = tmp_path / "export.csv", LAYOUTS[layout]
    about = {"stroke": stroke, "zero": zero, "sign": sign, "length": 250.0 + 150.0 * len(motions)}
    write(file, rate=rate, motions=[PARTS[each] for each in motions], **about)
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
