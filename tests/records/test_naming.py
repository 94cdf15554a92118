"""The number in a name counts operations where the names leave no doubt; else none."""

from pathlib import Path

import pytest

from breaker.records.file_names import numbers_in, phases_in_names

PHASES = {
    "108-R 24-12-2020|108-Y 24-12-2020|108-B 24-12-2020": "R|Y|B",
    "108-R-1|108-R-2|108-Y-1|108-Y-2": "R|R|Y|Y",  # a counter
    "R-1 CT|R-2 CT|X-1 CT": "",
}
CLEAR = [
    (["op_0005_closing"], [5]),
    (["00001", "00059", "10203"], [1, 59, 10203]),
    (["record (1)", "record (2)"], [1, 2]),
    (["op_1", "op_2_after_service"], [1, 2]),
    (["1949", "2000", "2061"], [1949, 2000, 2061]),
]
UNCLEAR = [
    *("closing", "op_٣", "closing_20-11-2024_15-13-07", "operation_0007_10kHz", "000001", "2023"),
    *("nov2023", "20nov", "1732115587", "9" * 200, "x_ch2", "phase_1", "breaker7", "v2", "220V"),
    *("a_20-11-2024_15-13-07 a_20-11-2024_15-14-09", "op_0007_10kHz op_0008_10kHz"),
    *("op_10-kHz op_20-kHz", "2024-11-20 2024-11-21", "20241120 20241121", "2021 2022"),
    *("2024-11-20_0907 2024-11-20_0908", "20-Nov-2024_7 21-Nov-2024_7", "run_15h13 run_15h14"),
    *("2023-03 2023-04", "gap_0.5 gap_0.6", "op_1_05 op_1_5", "20-11-24_7 21-11-24_7"),
]


@pytest.mark.parametrize(("stems", "numbers"), CLEAR)
def test_a_name_without_doubt_states_its_number(stems, numbers):
    assert numbers_in(stems) == numbers


@pytest.mark.parametrize("stems", UNCLEAR)
def test_a_name_with_a_doubt_states_no_number(stems):
    assert {*numbers_in(stems.split())} == {None}


@pytest.mark.parametrize(("stems", "phases"), PHASES.items())
def test_names_that_differ_in_a_phase_state_it(stems, phases):
    result = phases_in_names(map(Path, stems.split("|")))
    assert "|".join(result.values()) == phases
