"""Drives of a fleet, and their visits."""

from breaker.prognosis.members import Member, members_of
from breaker.records.folder import list_fleet
from breaker.records.operations import Operation


def test_operations_without_a_date_belong_to_the_visit_before():
    dates = {1: "2012-05-01", 2: "", 3: "2012-05-20T10:00:00", 7: "2020-01-01", 8: ""}
    rows = [Operation(n, "a.csv", date=date) for n, date in dates.items()]
    assert Member("A", "", "", {"closing": rows}).visits() == [[1, 2, 3], [7, 8]]
    assert Member("A", "", "", {"closing": [rows[1], rows[4]]}).visits() == [[2, 8]]


def test_each_phase_is_a_drive_and_the_table_names_its_type(tmp_path):
    lines = ["file,motion,operation,breaker,phase,type"]
    for breaker in "BA":
        for phase in "RS":
            lines.append(f"{breaker}.csv,closing,1,{breaker},{phase},T{breaker}")
        (tmp_path / f"{breaker}.csv").touch()
    (tmp_path / "operations.csv").write_text("\n".join(lines), encoding="utf-8")
    rows = list_fleet(tmp_path)
    found = [each[:3] for each in members_of(rows, ["closing", "opening"])]
    assert found == [("B", "R", "TB"), ("B", "S", "TB"), ("A", "R", "TA"), ("A", "S", "TA")]
    assert [*list_fleet(tmp_path, breakers=["A"], phase="R")] == ["A"]
