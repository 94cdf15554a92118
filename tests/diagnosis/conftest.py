"""Answers that the tests of the room share: a record of both motions of the reference drive."""

from dataclasses import replace

import numpy as np
import pytest

from breaker.configuration.loading import defaults
from breaker.diagnosis.estimate import Given
from breaker.diagnosis.inference import Inference
from breaker.diagnosis.reading import read_operations
from breaker.diagnosis.session import Diagnosis
from breaker.model.quantities import speeds_at
from breaker.records.contacts import ContactTimes
from breaker.records.named import ANY
from breaker.records.operations import Operation
from tests.cli.conftest import written

SETTINGS = {"draws": 400, "misfit_p_value": 1e-3, "seed": 1}
STROKE = 13.5  # mm, of the reference drive
TOUCH = 20.09  # ms in the record, of the model that it is of


@pytest.fixture(scope="package")
def records(tmp_path_factory, prior):
    """Closing and opening of an operation, a closing of another, and one that is not there."""
    folder = tmp_path_factory.mktemp("answers")
    for name, motions in {"both.csv": ["closing", "opening"], "a.csv": ["closing"]}.items():
        written(folder / name, prior, *motions)
    files = ["both.csv", "a.csv", "gone.csv"]
    result = [Operation(k, folder / name, phase="L1") for k, name in enumerate(files, start=1)]
    return read_operations({ANY: result}, {})


@pytest.fixture(scope="package")
def infer(levels, records):
    """Infer the records, or others, with what is given."""

    def infer(given=None, some=records, families=(levels,)):
        inference = Inference(lambda: families, given or Given(), **SETTINGS)
        return inference.infer(some, speeds_at({}, STROKE))

    return infer


@pytest.fixture(scope="package")
def answers(infer):
    return infer()


@pytest.fixture(scope="package")
def timed(records):
    """The first closing, with the touch that a contact's voltage would show, and its sd."""

    def timed(switching, sd=0.1):
        raw = replace(records[0].raw, contact=ContactTimes(switching, sd))
        return replace(records[0], raw=raw)

    return timed


def result_of(estimates, verdicts=None, **given):
    """The result of estimates, with verdicts of each."""
    diagnosis = Diagnosis(defaults(), given=Given(**given))
    judged = verdicts or [[]] * len(estimates)
    vars(diagnosis).update(estimates=estimates, judge=lambda _: judged)
    return diagnosis.result


def spread(draws):
    """Half of a central 95 % interval."""
    return np.diff(np.quantile(draws, [0.025, 0.975]))[0] / 2
