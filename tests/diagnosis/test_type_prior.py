"""The prior of a type: from drives whose medians and spread are known; `breaker fit-prior`."""

import shutil
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.data_files import family_of
from breaker.configuration.loading import load
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.type_prior import DrawnType, fit_type, list_type, warnings_of
from breaker.family.drive_family import Family
from breaker.family.endurance import write_curve
from breaker.model.parameters import MOTIONS, NAMES, UNIT, Size
from breaker.model.prior import Prior
from breaker.records.curves import Grid, read_curves
from breaker.records.folder import list_operations

USUAL = np.array([0.2, 0.15, 0.2, 0.2, 0.4, 0.1, 0.05])
HEAD = "file,motion,operation,breaker"
SHARE = 0.5  # spread between breakers of a type, in log-sds of the default prior

pytestmark = pytest.mark.usefixtures("a_quarter_of_the_draws")


def type_of(prior, rng, off=0.7):
    """Prior of a type: medians that a draw of the default prior has, less spread."""
    while True:
        medians = prior.medians * np.exp(off * prior.log_sds * rng.standard_normal(7))
        drawn = Prior(medians, SHARE * prior.log_sds)
        if drawn.log_support > np.log(0.95):
            return drawn


def breakers_of(drawn, count, rng):
    """Drives of a type, each with what the model lacks on top."""
    family = Family(drawn, family_of("medium_voltage"))
    return [family.new(rng) for _ in range(count)]


def write_breakers(folder, drives, rng, size=UNIT):
    """Write two operations of breakers Q0, Q1 ... with their table."""
    folder.mkdir(parents=True, exist_ok=True)
    time, lines = np.arange(0.0, 72.0 * size.times, 0.1 * size.times), [HEAD]
    for (number, drive), motion, k in product(enumerate(drives), MOTIONS, (1, 2)):
        begins = size.times * (10.0 + 0.3 * rng.standard_normal())
        curve = drive.scaled(size).travel(motion, time - begins)
        curve += 0.1 * size.lengths * rng.standard_normal(time.size)
        file = folder / f"{motion}_{number}_{k}.csv"
        write_curve(file, time, curve, motion=motion, operation=k)
        lines.append(f"{file.name},{motion},{k + 100 * number},Q{number}")
    (folder / "operations.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def learned(seed, n=30, deviating=()):
    """A type of drives with three operations each, and with an error that all of them share."""
    rng = np.random.default_rng(seed)
    own = 0.5 + 0.03 * rng.standard_normal((n, 7))
    own[list(deviating), 3] += 0.5
    means = own[:, None] + 0.02 * rng.standard_normal((n, 3, 7))
    logs = means[:, :, None] + 0.15 * rng.standard_normal((n, 3, 100, 7))
    return DrawnType.of(np.exp(logs), USUAL)


def test_deviating_drives_do_not_widen_the_type_and_one_drive_shows_no_spread():
    several, same = learned(1, deviating=[0, 1, 2]), learned(1)
    assert several.log_sds == pytest.approx(same.log_sds, rel=0.1)
    # Spread of the drives, and 60 % of the variance of draws, which all drives may share.
    assert same.log_sds == pytest.approx(np.full(7, np.hypot(0.03, np.sqrt(0.6) * 0.15)), rel=0.1)
    assert np.log(several.medians) == pytest.approx(np.full(7, 0.5), abs=0.04)
    assert (learned(1, n=1).log_sds > USUAL).all()


# ---- records -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def asked(defaults, levels):
    return Diagnosis(defaults, families=lambda: [levels])


@pytest.fixture(scope="module")
def written(tmp_path_factory, prior):
    """Two breakers with two operations of both motions."""
    rng = generator(6, "test recorded")
    drives = breakers_of(type_of(prior, rng), 2, rng)
    return write_breakers(tmp_path_factory.mktemp("type"), drives, generator(1, "test files"))


@pytest.fixture(scope="module")
def fitted(written, asked):
    return fit_type(list_type([written], MOTIONS), asked)


def codes(fitted, **changes):
    return {remark.code for remark in warnings_of(replace(fitted, **changes))}


def test_breakers_of_a_table(fitted):
    """Those that are left out, and openings of drives with dampers, are warnings."""
    first, second = fitted.estimates["Q0"], fitted.estimates["Q1"]
    assert (len(first), len(second)) == (4, 4)
    assert {estimate.motions for estimate in first} == {MOTIONS}  # of an operation, together
    assert (fitted.rejected, fitted.names) == ([], ["Q0", "Q1"])
    assert fitted.sensor.noise_sd == pytest.approx(0.1, rel=0.15)
    assert fitted.size.lengths == pytest.approx(1.0, abs=0.3)
    assert codes(fitted) == set()
    outside = [replace(estimate, draws=None, misfit=True) for estimate in first]
    left_out = {"estimates": {"Q0": outside, "Q1": second}, "names": ["Q1"]}
    assert codes(fitted, **left_out) == {"type-one-breaker", "type-left-out"}
    some = {"Q0": [*outside[1:], first[0]], "Q1": second}
    assert codes(fitted, estimates=some) == {"type-left-out"}
    levels = SimpleNamespace(usual=fitted.levels.usual, settings={"family": "any"})
    assert codes(fitted, levels=levels) == {"type-damped"}


def test_operations_of_one_type_are_chosen_and_a_copy_counts_once(tmp_path, written, asked):
    """A record of Q0 that was saved again as one of Q1, a folder twice, and a damaged file."""
    folder = shutil.copytree(written, tmp_path / "type")
    (folder / "closing_1_1.csv").write_bytes((folder / "closing_0_1.csv").read_bytes() + b"\n")
    (folder / "closing_1_2.csv").write_text("time,travel\n0,1\n", encoding="utf-8")
    again = shutil.copytree(folder, tmp_path / "again")
    fitted = fit_type(list_type([folder, again], ["closing"]), asked)
    assert {name: len(estimates) for name, estimates in fitted.estimates.items()} == {"Q0": 2}
    assert len(fitted.rejected) == 2 + 4
    table = folder / "operations.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    rows = [f"{row},{'GL 314' if 'Q1' in row else 'GL318'}" for row in rows]
    table.write_text("\n".join([f"{head},type", *rows]), encoding="utf-8")
    own = list_type([folder], MOTIONS, "gl-314")
    assert {one.breaker for operations in own.values() for one in operations} == {"Q1"}
    with pytest.raises(ValueError, match=r"GL 314, GL318"):
        list_type([folder], MOTIONS, "")
    with pytest.raises(FileNotFoundError):
        list_type([folder, tmp_path / "nowhere"], MOTIONS)  # not left out in silence


# ---- the command ---------------------------------------------------------------------------------

SIZE = Size(10.0, 4.0)


def test_the_configuration_takes_the_lines(tmp_path, prior):
    """Prior and size are those of the drives, and the grid of the sensor is within the records."""
    rng = generator(5, "test written")
    true = type_of(prior, rng, off=0.3)
    folder = write_breakers(tmp_path / "type", breakers_of(true, 3, rng), rng, SIZE)
    file, rest = tmp_path / "type.yaml", tmp_path / "rest.yaml"
    rest.write_text("endurance: {format: {zero: rest}}\n", encoding="utf-8")
    command = ["fit-prior", str(folder), "--config", str(rest), "--output", str(file)]
    assert main(command) == 0
    config = load([file])
    assert config["size"]["lengths"] == pytest.approx(SIZE.lengths, rel=0.3)
    medians = np.array([config["prior"][name]["median"] for name in NAMES])
    log_sds = np.array([config["prior"][name]["log_sd"] for name in NAMES])
    off = np.log(medians / (true.medians * SIZE.factors)) / log_sds
    assert np.abs(off).max() < 3.0
    sensor, form = config["sensor"], config["endurance"]["format"]
    noise = np.hypot(0.1 * SIZE.lengths, 0.02 * SIZE.lengths)
    assert sensor["noise_sd"] == pytest.approx(noise, rel=0.2)
    assert form["zero"] == "rest"
    grid = Grid(np.linspace(sensor["start"], sensor["stop"], sensor["samples"]))
    for motion in MOTIONS:
        operations = list_operations(folder, motion, breaker="Q0")
        curves = read_curves(operations, form, grid, motion)
        assert curves.accepted.all(), curves.reason.values
        assert curves.missing.max() == 0
