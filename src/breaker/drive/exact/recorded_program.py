"""What a function does to random numbers, recorded once, and run for many rows with slopes.

A family makes a drive by a few hundred operations of numpy, which each take longer to be called
than to compute. They are recorded on symbols, and run on blocks of rows by compiled code, which
other threads need not wait for. Slopes are those of reverse differentiation (Griewank and Walther
2008, Evaluating Derivatives). An operation that is not known here is refused.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partialmethod
from typing import Any

import numpy as np
from scipy.special import ndtr, ndtri

from breaker.common.compiling import compiled

_ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _GREATER, _SQRT, _EXP, _NDTR, _NDTRI = range(9)
_OF_SCIPY = {_NDTR: ndtr, _NDTRI: ndtri}
_COMPARED = (np.greater, np.less)
_ROWS = 128  # at a time, so that all registers stay near the processor


class Symbol:
    """A number that is not known yet: a register of the program that is recorded."""

    __hash__ = object.__hash__

    def __init__(self, lines: list, constants: dict, code: tuple | None = None) -> None:
        self.lines, self.constants, self.register = lines, constants, len(lines)
        lines.append(code)

    def _new(self, *code: Any) -> "Symbol":
        return Symbol(self.lines, self.constants, code)

    def _register_of(self, other: Any) -> int:
        if isinstance(other, Symbol):
            return other.register
        value = float(other)
        if value not in self.constants:
            self.constants[value] = self._new().register
        return self.constants[value]

    def _with(self, other: Any, code: int, turned: bool = False) -> "Symbol":
        two = self.register, self._register_of(other)
        return self._new(code, *(two[::-1] if turned else two))

    def _alone(self, code: int) -> "Symbol":
        return self._new(code, self.register, self.register)

    __add__ = __radd__ = partialmethod(_with, code=_ADD)
    __mul__ = __rmul__ = partialmethod(_with, code=_MULTIPLY)
    __sub__ = partialmethod(_with, code=_SUBTRACT)
    __rsub__ = partialmethod(_with, code=_SUBTRACT, turned=True)
    __truediv__ = partialmethod(_with, code=_DIVIDE)
    __rtruediv__ = partialmethod(_with, code=_DIVIDE, turned=True)
    __gt__ = partialmethod(_with, code=_GREATER)
    __lt__ = partialmethod(_with, code=_GREATER, turned=True)
    sqrt = partialmethod(_alone, code=_SQRT)
    exp = partialmethod(_alone, code=_EXP)
    ndtr = partialmethod(_alone, code=_NDTR)
    ndtri = partialmethod(_alone, code=_NDTRI)

    def __neg__(self) -> "Symbol":
        return self * -1.0

    def __bool__(self) -> bool:
        raise TypeError("a program has no branches")


class SymbolArray(np.ndarray):
    """Symbols, on which functions of scipy can be called, and comparisons give symbols."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        plain = [np.asarray(each) for each in inputs]
        if "out" in options:
            options["out"] = tuple(np.asarray(each) for each in options["out"])
        if ufunc in _COMPARED:
            options["dtype"] = object
        if ufunc in _OF_SCIPY.values():
            ufunc = np.frompyfunc(getattr(Symbol, ufunc.__name__), 1, 1)
        found = getattr(ufunc, method)(*plain, **options)
        return found.view(SymbolArray) if isinstance(found, np.ndarray) else found


@dataclass(frozen=True, eq=False)
class Program:
    """A function of rows of numbers.

    Attributes:
        inputs: How many numbers a row has.
        lines: Operation, its two arguments and its result, as registers, ``(l, 4)``. The first
            registers are the inputs.
        constants, values: Registers of constants, and these.
        results: Register of each result.
        registers: How many.

    Example:
        >>> program = Program.of(lambda row: [np.exp(row[:, 0]) * row[:, 1], 3.0], 2)
        >>> results, back = program.run(np.array([[1.0, 2.0]]))
        >>> results.round(2), back(np.ones((1, 2))).round(2)
        (array([[5.44, 3.  ]]), array([[5.44, 2.72]]))
    """

    inputs: int
    lines: np.ndarray
    constants: np.ndarray
    values: np.ndarray
    results: np.ndarray
    registers: int

    @classmethod
    def of(cls, function: Callable[[np.ndarray], list], inputs: int) -> "Program":
        """Record a function.

        Args:
            function: Of rows ``(n, inputs)``: a list of results, each ``(n,)`` or one number.
        """
        lines: list = []
        constants: dict[float, int] = {}
        row = np.array([[Symbol(lines, constants) for _ in range(inputs)]], dtype=object)
        one = row[0, 0]
        found = [np.asarray(each).ravel()[0] for each in function(row.view(SymbolArray))]
        results = np.array([one._register_of(each) for each in found])
        needed = np.zeros(len(lines), dtype=bool)
        needed[results] = True
        for k in range(len(lines) - 1, -1, -1):
            if needed[k] and lines[k]:
                needed[list(lines[k][1:])] = True
        code = [(*line, k) for k, line in enumerate(lines) if line and needed[k]]
        registers, values = list(constants.values()), list(constants)
        about = np.array(registers, dtype=int), np.array(values), results, len(lines)
        return cls(inputs, np.array(code, dtype=np.int64).reshape(-1, 4), *about)

    def run(self, rows: np.ndarray) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
        """Results of rows ``(n, i)``, ``(n, r)``; and what takes slopes by these, of the same
        shape, to slopes by the rows.
        """
        blocks, results = [], np.empty((len(rows), self.results.size))
        for begin in range(0, len(rows), _ROWS):
            some = slice(begin, begin + _ROWS)
            registers = np.empty((self.registers, len(rows[some])))
            registers[: self.inputs] = rows[some].T
            registers[self.constants] = self.values[:, None]
            for function, lines in self._parts:
                if function is None:
                    _forward(lines, registers)
                else:
                    registers[lines[:, 3]] = function(registers[lines[:, 1]])
            results[some] = registers[self.results].T
            blocks.append((some, registers))

        def back(by: np.ndarray) -> np.ndarray:
            found = np.empty(rows.shape)
            for some, registers in blocks:
                slopes = np.zeros(registers.shape)
                _backward(self.lines, registers, self.results, by[some].T, slopes)
                found[some] = slopes[: self.inputs].T
            return found

        return results, back

    @property
    def _parts(self) -> list[tuple[Callable | None, np.ndarray]]:
        """The lines in parts, which compiled code runs, or a function of scipy."""
        codes = np.where(self.lines[:, 0] >= _NDTR, self.lines[:, 0], -1)
        parts = np.split(self.lines, np.flatnonzero(np.diff(codes)) + 1)
        return [(_OF_SCIPY.get(int(each[0, 0])), each) for each in parts if len(each)]


@compiled(nogil=True)
def _forward(lines, registers):
    """Run lines on registers ``(r, n)``."""
    for k in range(len(lines)):
        code, left, right, to = lines[k]
        a, b, out = registers[left], registers[right], registers[to]
        if code == _ADD:
            np.add(a, b, out)
        elif code == _SUBTRACT:
            np.subtract(a, b, out)
        elif code == _MULTIPLY:
            np.multiply(a, b, out)
        elif code == _DIVIDE:
            np.divide(a, b, out)
        elif code == _SQRT:
            np.sqrt(a, out)
        elif code == _EXP:
            np.exp(a, out)
        else:
            out[:] = np.where(a > b, 1.0, 0.0)


@compiled(nogil=True)
def _backward(lines, registers, results, by, slopes):
    """Add to the slopes of registers, from those of the results, ``(r, n)``, to the inputs."""
    root = np.sqrt(2.0 * np.pi)
    for k in range(len(results)):
        slopes[results[k]] += by[k]
    for k in range(len(lines) - 1, -1, -1):
        code, left, right, to = lines[k]
        a, b, out, slope = registers[left], registers[right], registers[to], slopes[to]
        if code == _ADD:
            slopes[left] += slope
            slopes[right] += slope
        elif code == _SUBTRACT:
            slopes[left] += slope
            slopes[right] -= slope
        elif code == _MULTIPLY:
            slopes[left] += slope * b
            slopes[right] += slope * a
        elif code == _DIVIDE:
            slopes[left] += slope / b
            slopes[right] -= slope * out / b
        elif code == _SQRT:
            slopes[left] += 0.5 * slope / out
        elif code == _EXP:
            slopes[left] += slope * out
        elif code == _NDTR:
            slopes[left] += slope * np.exp(-0.5 * a * a) / root
        elif code == _NDTRI:
            slopes[left] += slope * np.exp(0.5 * out * out) * root
