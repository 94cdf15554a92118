"""The number in a name counts operations where the names leave no doubt; else there is a reason."""

import random

import pytest

from breaker.records.file_names import numbers_in

CLEAR = [
    (["operation_0001"], [1]),
    (["12"], [12]),
    (["op-12"], [12]),
    (["op_0005_closing"], [5]),
    (["closing_00030", "closing_00031"], [30, 31]),
    (["00001", "00059", "10203"], [1, 59, 10203]),
    (["operation_2024", "operation_2025"], [2024, 2025]),
    (["operation_0007_10kHz", "operation_0008_10kHz"], [7, 8]),
    (["2024-03-05_breaker7_0310", "2024-03-05_breaker7_0311"], [310, 311]),
    (["op_1_2024-11-20", "op_2_2024-11-20"], [1, 2]),
    (["record (1)", "record (2)"], [1, 2]),
    (["op_1", "op_2_after_service"], [1, 2]),
    (["Nr. 2024"], [2024]),
    (["#2024"], [2024]),
    (["1999", "2000", "2061"], [1999, 2000, 2061]),
    (["02000", "02001"], [2000, 2001]),
    (["0999", "2000"], [999, 2000]),
    (["12_marked"], [12]),
    (["closing_may_0007"], [7]),
]
UNCLEAR = [
    (["closing"], "has no number"),
    (["op_٣"], "has no number"),
    (["op_²"], "has no number"),
    (["closing_20-11-2024_15-13-07"], "has 6 numbers, 20, 11, 2024, 15, 13 and 7, and no other"),
    (["a_20-11-2024_15-13-07", "a_20-11-2024_15-14-09"], "2 of them vary"),
    (["a_20-11-2024_15-13-07", "a_20-11-2024_15-13-09"], "part of a date or time"),
    (["operation_0007_10kHz"], "has 2 numbers, 7 and 10, and no other name shows which one"),
    (["op_0007_10kHz", "op_0008_20kHz"], "has 2 numbers, 7 and 10, and 2 of them vary"),
    (["2024-11-20", "2024-11-21"], "part of a date or time"),
    (["20241120", "20241121"], "more than 5 digits"),
    (["241120", "241121"], "more than 5 digits"),
    (["000001"], "more than 5 digits"),
    (["20241120T151307", "20241120T151309"], "more than 5 digits"),
    (["2024-11-20_0907", "2024-11-20_0908"], "part of a date or time"),
    (["20-Nov-2024_7", "21-Nov-2024_7"], "part of a date or time"),
    (["20-11-24_7", "21-11-24_7"], "part of a date or time"),
    (["run_15h13", "run_15h14"], "part of a date or time"),
    (["2023"], "looks like a year"),
    (["2021", "2022", "2023"], "looks like a year"),
    (["closing_1950", "closing_2060"], "looks like a year"),
    (["nov2023"], "looks like a year"),
    *(
        ([name], "part of a date or time")
        for name in ("nov20", "20nov", "mar-05_x", "5. März", "Oktober 20", "3_août", "sept_3")
    ),
    (["2023-03", "2023-04"], "part of a date or time"),
    (["1732115587", "1732115599"], "more than 5 digits"),
    (["9" * 200], "more than 5 digits"),
    *(
        ([name], "belongs to")
        for name in ("closing_L1", "x_ch2", "phase_1", "breaker7", "v2", "220V", "10 kHz", "90%")
    ),
    (["gap_0.5", "gap_0.6"], "belongs to"),
    (["op_5.v2"], "has 2 numbers, 5 and 2"),
    (["op_1_05", "op_1_5"], "has 2 numbers, 1 and 5"),
]


@pytest.mark.parametrize(("stems", "numbers"), CLEAR)
def test_a_name_without_doubt_says_its_number(stems, numbers):
    assert numbers_in(stems) == numbers


@pytest.mark.parametrize(("stems", "reason"), UNCLEAR)
def test_a_name_with_a_doubt_says_no_number(stems, reason):
    found = numbers_in(stems)
    assert all(isinstance(each, str) for each in found), found
    assert reason in found[0]


def test_no_name_that_is_added_changes_the_number_of_another_one():
    """Random folders of names of a few fields: a number that a name says stays or becomes a
    doubt."""
    rng = random.Random(0)
    forms = [
        "op_{}",
        "{}_{}",
        "a{}-{}_{}",
        "{:04d}_{}kHz",
        "2024-11-{:02d}_{}",
        "nov{}",
        "200{}",
        "x {} ({})",
    ]
    changed = 0
    for _ in range(500):
        stems = [
            rng.choice(forms[: rng.randint(1, 8)]).format(*(rng.randint(1, 3) for _ in range(3)))
            for _ in range(8)
        ]
        before = numbers_in(stems[:4])
        for old, new in zip(before, numbers_in(stems), strict=False):
            if isinstance(old, int) and isinstance(new, int):
                assert old == new, stems
            changed += isinstance(old, int) != isinstance(new, int)
    assert changed > 20  # the folders are such that names do become ambiguous
