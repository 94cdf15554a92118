"""The page on evidence says where the time of a run goes as the table beside it does."""

from tests.scripts import script

times = script("docs/times.py")

HEAD = "s\th:m:s\tmax_rss\tcpu_time\n"


def test_the_page_has_the_table():
    text, rows = times.PAGE.read_text(encoding="utf-8"), times.read()
    assert times.placed(text, rows) == text
    more = str(int(rows[0]["processor_s"]) + 1)
    assert times.placed(text, [rows[0] | {"processor_s": more}, *rows[1:]]) != text


def test_jobs_of_a_rule_are_added(tmp_path):
    """Also where one ended before Snakemake looked at its processor time."""
    for name, wall, processor in (
        ("train_closing", 30, 25.0),
        ("train_opening", 50, 45.0),
        ("infer_family_closing_000", 4, 3.0),
        ("family_validate_shipped_changes_both", 2, "NA"),
        ("figures_sbc_family_shipped_both", 3, 1.5),
        ("figures_health", 2, 0.6),
    ):
        (tmp_path / f"{name}.tsv").write_text(f"{HEAD}{wall}\t0:00:00\t9.0\t{processor}\n")
    rows = times.by_rule(sorted(tmp_path.iterdir()))
    assert [tuple(row.values()) for row in rows] == [
        ("train", "2", "70", "50"),
        ("infer_family", "1", "3", "4"),
        ("family_validate", "1", "2", "2"),
        ("figures", "2", "2", "3"),
    ]
    small = {"rule": "first_page", "jobs": "1", "processor_s": "0", "longest_s": "1"}
    assert times.lines([*rows, small])[2:] == [
        "| `train` | 2 | 70 | 91 % | 50 |",
        "| `infer_family` | 1 | 3 | 4 % | 4 |",
        "| `family_validate` | 1 | 2 | 3 % | 2 |",
        "| `figures` | 2 | 2 | 3 % | 3 |",
        "| 1 others | 1 | 0 | 0 % | 1 |",
        "| all | 7 | 77 | 100 % | 50 |",
    ]
