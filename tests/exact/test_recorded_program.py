"""A recorded program does what the function did, with slopes; what it does not know it refuses."""

import numpy as np
import pytest
from scipy.special import ndtr, ndtri

from breaker.common.randomness import generator
from breaker.drive.exact.recorded_program import Program


def every_operation(row):
    """Of three numbers: all that a family does to its own."""
    first, second, third = row.T
    shares = ndtr(row)
    there = shares[:, :1] > shares[:, 1:]
    sizes = 3.0 - 2.0 * np.sqrt(1.0 - shares)
    rows = row * 2.0
    rows += (-ndtri(0.9 * (1.0 - shares[:, 0])) - row @ np.array([1.0, 2.0, 0.0]))[:, None]
    waves = row.T * np.sqrt(2.0 / np.square(row.T).sum(axis=0))
    products = (there * sizes[:, 1:]).T
    return [np.exp(first) / second, 0.5 + third, 7.0, *rows.T, *waves, *products, first - 1.0]


@pytest.fixture(scope="module")
def rows():
    """More than a block of rows, and no whole number of blocks."""
    return generator(1, "program").standard_normal((300, 3))


def expected(rows):
    return np.column_stack([np.broadcast_to(each, len(rows)) for each in every_operation(rows)])


def test_results_are_those_of_the_function(rows):
    found, _ = Program.of(every_operation, 3).run(rows)
    assert np.allclose(found, expected(rows), rtol=1e-12)


def test_slopes_are_those_by_differences(rows):
    rows = rows[np.abs(rows[:, 1]) > 0.1]
    found, back = Program.of(every_operation, 3).run(rows)
    by = generator(2, "program").standard_normal(found.shape)
    slopes = back(by)
    for j in range(3):
        beside = 1e-6 * np.eye(3)[j]
        moved = expected(rows + beside) - expected(rows - beside)
        # Of a few rows a decision lies between the two.
        close = np.isclose((moved * by).sum(axis=1) / 2e-6, slopes[:, j], rtol=1e-4, atol=1e-5)
        assert close.mean() > 0.99
    assert np.array_equal(slopes, back(by))  # again


def test_a_row_does_not_depend_on_those_beside_it(rows):
    program = Program.of(every_operation, 3)
    assert np.array_equal(program.run(rows)[0][200:201], program.run(rows[200:201])[0])


def test_what_moves_no_result_is_left_out():
    program = Program.of(lambda row: [ndtr(row)[:, 0], 2.0], 3)
    assert len(program.lines) == 1


@pytest.mark.parametrize("unknown", [np.sin, np.abs])
def test_an_unknown_operation_is_refused(unknown):
    with pytest.raises(TypeError):
        Program.of(lambda row: [unknown(row[:, 0])], 1)


def test_a_branch_is_refused():
    with pytest.raises(TypeError, match="no branches"):
        Program.of(lambda row: [row[:, 0] if row[0, 0] > 0.0 else 1.0], 1)
