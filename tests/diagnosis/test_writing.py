"""`breaker fit-prior`: the lines of configuration that it writes, and what it says."""

from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.configuration.loading import load
from breaker.diagnosis.prior_report import _table, overlay_of
from breaker.diagnosis.session import given_by
from breaker.diagnosis.type_records import Span
from breaker.model.parameters import NAMES, Size
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers

SIZE = Size(10.0, 4.0)


@pytest.fixture(scope="module")
def drawn(prior):
    return type_of(prior, generator(5, "test written"), off=0.3)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, drawn, defaults):
    rng = generator(5, "test files")
    drives = breakers_of(drawn, family_of(HELD_BACK), 3, rng)
    return write_breakers(tmp_path_factory.mktemp("type"), drives, 2, rng, SIZE)


@pytest.fixture(scope="module")
def written(folder, tmp_path_factory):
    """The overlay, and a picture."""
    file = tmp_path_factory.mktemp("written") / "type.yaml"
    plot = file.with_suffix(".png")
    assert main(["fit-prior", str(folder), "--output", str(file), "--plot", str(plot)]) == 0
    return file, plot


def test_the_configuration_takes_it(written, drawn):
    file, plot = written
    config = load([file])
    assert config["size"]["lengths"] == pytest.approx(SIZE.lengths, rel=0.3)
    medians = np.array([config["prior"][name]["median"] for name in NAMES])
    log_sds = np.array([config["prior"][name]["log_sd"] for name in NAMES])
    off = np.log(medians / (drawn.medians * SIZE.factors)) / log_sds
    assert np.abs(off).max() < 3.0  # the fitted prior's sd, of which 3 are hardly exceeded by any
    assert config["sensor"]["noise_sd"] == pytest.approx(0.1 * SIZE.lengths, rel=0.2)
    assert 60.0 < config["sensor"]["stop"] < 58.0 * config["size"]["times"]
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_what_a_model_leaves_out_is_of_the_size_of_the_drive(prior, defaults):
    levels = SimpleNamespace(settings={"family": "medium_voltage"})
    about = {"noise_sd": 0.15, "span": Span(20.0, 99.0, 200.0, 0.1), "levels": levels}
    recorded = SimpleNamespace(size=SIZE, motions=["closing"], **about)
    found = overlay_of(
        recorded, SimpleNamespace(prior=prior, contact_lag={}), defaults["sensor"], {}
    )
    assert found["sensor"]["noise_sd"] == pytest.approx(np.hypot(0.15, 0.2), rel=1e-5)


def test_the_lag_of_contacts_is_written_where_there_is_one(prior, defaults, tmp_path):
    levels = SimpleNamespace(settings={"family": "medium_voltage"})
    about = {"noise_sd": 0.15, "span": Span(20.0, 99.0, 200.0, 0.1), "levels": levels}
    recorded = SimpleNamespace(size=SIZE, motions=["closing", "opening"], **about)
    fitted = SimpleNamespace(prior=prior.sized(SIZE), contact_lag={"opening": (0.123456, 0.2)})
    found = overlay_of(recorded, fitted, defaults["sensor"], {})
    assert found["contact_lag"] == {"opening": [0.1235, 0.2]}
    file = tmp_path / "type.yaml"
    file.write_text(yaml.safe_dump(found), encoding="utf-8")
    given, words = given_by(load([file]))
    assert given.contact_lag == found["contact_lag"]
    assert len(words) == 1


def test_the_parts_of_a_log_sd_are_under_their_names(prior):
    parts = {
        name: np.full(7, value) for name, value in (("spread", 3), ("known", 4), ("shared", 5))
    }
    learned, room = SimpleNamespace(**parts), np.full(7, 6)
    table = _table(SimpleNamespace(prior=prior, reference=prior, learned=learned, room=room))
    assert [*table.head[4:8]] == ["of it: between", "not known", "shared", "wear"]
    assert [*table.rows[0][4:8]] == [f"{part:.3f}" for part in (3, 4, 5, 6)]


def test_what_the_files_need_is_written_along(folder, tmp_path, capsys):
    overlay = tmp_path / "format.yaml"
    of_infer = "known: {mu: [2.0, 0.1]}\n"  # facts, which the workflow alone refuses
    overlay.write_text("endurance: {format: {zero: rest}}\nmotions: [closing]\n" + of_infer)
    table = (folder / "operations.csv").read_text(encoding="utf-8")
    one = tmp_path / "one"
    one.mkdir()
    for file in folder.glob("closing_0_*.csv"):
        (one / file.name).symlink_to(file)
    head, *rows = table.splitlines()
    chosen = [head, *(row for row in rows if row.startswith("closing_0"))]
    (one / "operations.csv").write_text("\n".join(chosen), encoding="utf-8")
    output = tmp_path / "prior.yaml"
    assert main(["fit-prior", str(one), "--config", str(overlay), "--output", str(output)]) == 0
    printed = capsys.readouterr().out + output.read_text(encoding="utf-8")
    lines = yaml.safe_load(output.read_text(encoding="utf-8"))
    assert lines["endurance"] == {"format": {"zero": "rest"}}
    assert lines["motions"] == ["closing"]
    assert printed.count("WARNING: ") == 2  # on the terminal, and in the lines
