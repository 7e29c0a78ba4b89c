"""The page on performance is what was measured, with a line for every part of the benchmarks."""

from source_tree import ROOT

from benchmarks import report

COMMANDS = ("--help", "list", "analyse", "size", "map", "sweep", "report")


def test_page_is_what_was_measured():
    page = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    assert page == report.markdown(report.measured_before())


def test_commands_are_on_the_page():
    rows = [r for part in report.measured_before().values() for r in part["rows"]]
    told = [r["work"] for r in rows]
    assert {f"solar-uav {name}" for name in COMMANDS} <= {
        " ".join(work.split()[:2]) for work in told
    }


def test_parts_keep_the_machine_they_were_measured_on():
    line = {"name": "map", "work": "w", "ours_s": 1.0, "peer": None, "peer_s": None, "ratio": None}
    old, new = {"machine": "old", "rows": [line]}, {"machine": "new", "rows": [line]}
    assert "Measured on old." in report.markdown({"a": old, "b": old})
    assert "Measured `a` on old; `b` on new." in report.markdown({"a": old, "b": new})
