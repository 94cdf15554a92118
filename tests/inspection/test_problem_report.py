"""The report of a misread file: whatever the file, without names, serial numbers, dates, travel."""

import re

import numpy as np
import pytest

from breaker.cli import main
from breaker.reading.inspection.problem_report import Hidden, problem_report
from breaker.reading.instruments.dialects import DIALECTS

SECRETS = ("Quxborough", "Zwieselmann", "VX73519", "845127", "Жуковкин", "覃某某")
DATES = ("17.03.2024", "2024-03-17", "03/17/24", "14:22:05", "March")
HEAD = """Company;Quxborough Energie AG
Station;Quxborough\tOperator: Zwieselmann, Жуковкин
CB Serial No.;845127;Type;VX73519
Prüfer = 覃某某;Datum: 17.03.2024 14:22:05
Printed;2024-03-17;by zwieselmann on 03/17/24, March
Sampling rate: 10 kHz;Stroke: 18 mm
time;Travel Quxborough [VX73519]
ms;mm
"""


@pytest.fixture
def curve():
    time = np.round(0.1 * np.arange(1000), 1)
    share = np.clip((time - 20.0) / 25.0, 0.0, 1.0)
    noise = 0.01 * np.random.default_rng(1).standard_normal(time.size)
    return time, np.round(13.0 * share * share * (3.0 - 2.0 * share) + noise, 4)


@pytest.fixture
def file(tmp_path, curve):
    folder = tmp_path / "Zwieselmann" / "Quxborough 845127"
    folder.mkdir(parents=True)
    rows = (f"{t};{x}\n" for t, x in zip(*curve, strict=True))
    path = folder / "VX73519 closing.csv"
    path.write_text(HEAD + "".join(rows), encoding="utf-8")
    return path


def report(file, defaults):
    return problem_report(file, defaults["sensor"])[0]


def assert_nothing_told(text):
    for secret in (*SECRETS, *DATES):
        assert secret.lower() not in text.lower(), secret
    assert text.isascii() or all(sign.isprintable() or sign == "\n" for sign in text)


def test_nobody_and_nothing_is_named(file, defaults):
    text = report(file, defaults)
    assert_nothing_told(text)
    head = text.partition("== settings")[0]
    assert "'Xxxxxxx;Xxxxxxxxxx Xxxxxxx XX\\n'" in head  # signs, cells and cases are as they were
    assert "Sampling rate: 10 kHz;Stroke: 18 mm" in head
    assert "'CB Serial No.;000000;Type;XX00000\\n'" in head
    assert "'ms;mm\\n'" in head


def test_travel_is_not_in_it(file, defaults, curve):
    values = {f"{x:.4f}" for x in curve[1] if x > 2.0}
    text = report(file, defaults)
    assert not [each for each in values if each in text]
    assert text.count("'0.0;") + text.count("'00.0;") <= 3


def test_dates_beside_the_samples_are_never_told(tmp_path, defaults, curve):
    file = tmp_path / "a.csv"
    rows = (f"17.03.2024 14:22:05;{t};{x};Zwieselmann\n" for t, x in zip(*curve, strict=True))
    file.write_text("Datum;time;travel;who\n;ms;mm;\n" + "".join(rows), encoding="utf-8")
    assert_nothing_told(report(file, defaults))


@pytest.mark.parametrize("name", DIALECTS)
def test_of_every_kind_of_file(tmp_path, defaults, name, curve):
    """Their own words stay, and what is written into their name does not."""
    dialect = DIALECTS[name]
    folder = tmp_path / "Quxborough"
    folder.mkdir()
    file = folder / dialect.file_name("closing", 1)
    dialect.write(file, time=curve[0], travel=curve[1], motion="closing", operation=1)
    text = report(file, defaults)
    assert_nothing_told(text)
    assert "accepted" in text, text
    values = {f"{x:.4f}" for x in curve[1] if x > 2.0}
    assert not [each for each in values if each in text]


HOSTILE = {
    "nothing": b"",
    "zeros": b"\0" * 5000,
    "noise": bytes(np.random.default_rng(1).integers(0, 256, 20_000, dtype=np.uint8)),
    "a line": b"Quxborough;" * 500_000,
    "lines": b"Quxborough;845127\n" * 100_000,
    "escapes": b"\x1b[2J\x1b]0;Quxborough\x07\n" + "\u202eQuxborough\u200b\n".encode(),
    "utf-16": ("\ufeff" + HEAD).encode("utf-16-le"),
    "gb18030": HEAD.encode("gb18030"),
    "cp1251": "Станция: Жуковкин\n".encode("cp1251"),
    "latin-1": "Prüfer: Quxborough ÄÖÜ\n".encode("latin-1"),
    "accents": "Z\u0308wieselmann Quxborough\n".encode(),
    "digits": "Serial: ٨٤٥١٢٧ ８４５１２７ 845127\n".encode(),
    "glued": b"SerialQuxborough845127VX73519;travelZwieselmann_17.03.2024\n",
    "a unit behind": b"CB No: 845127 mm\n845127 kHz Quxborough ms\n845127s;845127 A\n",
    "a packed file": b"PK\x03\x04Quxborough 845127",
    "a formula": b'=HYPERLINK("http://quxborough/845127");@Zwieselmann\n',
}


@pytest.mark.parametrize("ending", [".csv", ".xlsx", ".cfg", ".nc"])
@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_file_tells_nothing_either(tmp_path, defaults, kind, ending):
    file = tmp_path / f"Quxborough 17.03.2024{ending}"
    file.write_bytes(HOSTILE[kind])
    text = report(file, defaults)
    told = text.replace("845127 mm", "").replace("845127 kHz", "")
    assert_nothing_told(told if kind == "a unit behind" else text)
    assert "８" not in text
    assert "٨" not in text
    assert len(text) < 200_000


def test_random_words_anywhere_in_a_head_are_not_told():
    rng = np.random.default_rng(5)
    letters = np.array([*"bcdfghjklmnpqrtvwxyz"])
    signs = np.array([*";:,=[]() \t/-_.#'\""])
    for _ in range(300):
        words = ["".join(rng.choice(letters, 9)) for _ in range(6)]
        line = "".join(w + rng.choice(signs) for w in ["Station", *words, "10 kHz"])
        text = Hidden().text(line)
        assert not [each for each in words if each in text]
        assert re.sub(r"\w", "", text) == re.sub(r"\w", "", line)


def test_the_command_writes_it_and_says_what_was_replaced(file, tmp_path, capsys):
    output = tmp_path / "problem.txt"
    assert main(["inspect", str(file), "--report-problem", str(output)]) == 0
    said = capsys.readouterr()
    assert "Read it before you send it." in said.err
    assert "quxborough" in said.err
    assert_nothing_told(output.read_text(encoding="utf-8"))
    assert main(["inspect", str(file), "--report-problem", str(output)]) == 1  # never replaced


def test_the_command_writes_it_of_a_file_that_cannot_be_read(tmp_path, capsys):
    file = tmp_path / "a.csv"
    file.write_text("nothing\n")
    assert main(["inspect", str(file), "--report-problem", str(tmp_path / "problem.txt")]) == 1
    assert "LayoutError" in (tmp_path / "problem.txt").read_text(encoding="utf-8")
