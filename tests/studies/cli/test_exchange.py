"""Tests of ``solar-uav export`` and ``schema``, and of tables in other formats."""

import importlib.util
import json
import zipfile

import pandas as pd
import pytest
from command_line import files

AS2, DESIGN = "atlantiksolar-as2", "atlantiksolar-design"


def leave_out(library, monkeypatch):
    """As where a library is not installed."""
    find = importlib.util.find_spec
    for module in ("importlib.util", "studies.exchange.airplane"):
        monkeypatch.setattr(
            f"{module}.find_spec",
            lambda name, *rest: None if name == library else find(name, *rest),
        )


def test_export_of_numbers(run, tmp_path):
    names = ("d.tex", "d.csv", "d.py")
    done = run("export", DESIGN, *(word for name in names for word in ("--out", name))).good()
    assert [line.rpartition(" ")[2] for line in done.out.splitlines()] == list(names)
    assert files(tmp_path) == set(names)
    table = pd.read_csv(tmp_path / "d.csv").set_index("key")["value"]
    analysed = run("analyse", DESIGN, "--json").json()
    assert float(table["excess_time_h"]) == pytest.approx(analysed["excess_time_h"])
    assert float(table["total_mass_kg"]) == pytest.approx(analysed["total_mass_kg"])
    compile((tmp_path / "d.py").read_text(), "d.py", "exec")


def test_export_of_a_workbook(run, tmp_path):
    pytest.importorskip("xlsxwriter")
    assert run("export", AS2, "--out", "d.xlsx").code == 0
    with zipfile.ZipFile(tmp_path / "d.xlsx") as book:
        sheets = book.read("xl/workbook.xml").decode()
    for name in ("design", "scenarios", "cycle"):
        assert f'name="{name}"' in sheets


def test_export_of_several_files_writes_those_that_it_can(run, tmp_path, monkeypatch):
    leave_out("aerosandbox", monkeypatch)
    names = ("w.avl", "d.csv", "nowhere/d.tex", "d.py")
    done = run("export", DESIGN, *(word for name in names for word in ("--out", name)))
    assert done.code == 1
    assert done.out.splitlines() == ["written to d.csv", "written to d.py"]
    assert "w.avl is not written: .avl needs AeroSandbox: pip install aerosandbox" in done.err
    assert "nowhere/d.tex is not written: " in done.err
    assert files(tmp_path) == {"d.csv", "d.py"}
    # A name that no format has is a mistake, before anything is written.
    assert run("export", DESIGN, "--out", "e.csv", "--out", "e.doc").code == 2
    assert files(tmp_path) == {"d.csv", "d.py"}
    assert run("export", DESIGN, "--out", "w.avl", "--out", "w.vspscript").code == 2


@pytest.mark.extra
def test_export_for_avl_and_openvsp(run, tmp_path):
    pytest.importorskip("aerosandbox")
    names = ("w.avl", "w.vspscript", "w.py")
    run("export", "sky-sailor", *(word for name in names for word in ("--out", name))).good()
    assert files(tmp_path) == set(names)
    texts = [(tmp_path / name).read_text(encoding="utf-8") for name in names]
    assert all("(areas 0.0679 and 0.00873 m²," in text for text in texts)
    # AVL reads no other file: none could be missing.
    assert "AIRFOIL" in texts[0]
    assert "AFIL" not in texts[0]


@pytest.mark.parametrize(
    ("library", "arguments"),
    [
        ("aerosandbox", ("export", AS2, "--out", "a.avl")),
        ("xlsxwriter", ("export", AS2, "--out", "a.xlsx")),
        ("xlsxwriter", ("analyse", AS2, "--table", "a.xlsx")),
        ("pyarrow", ("sweep", DESIGN, "--vary", "battery_mass_kg=2,3", "--out", "s.parquet")),
    ],
)
def test_libraries_that_are_missing_are_named(run, tmp_path, library, arguments, monkeypatch):
    leave_out(library, monkeypatch)
    done = run(*arguments)
    assert done.code == 2
    assert f"pip install {library}" in done.err
    assert files(tmp_path) == set()


def test_schema_is_printed_and_written(run, tmp_path):
    printed = json.loads(run("schema", "mission").out)
    assert run("schema", "mission", "--out", "m.json").code == 0
    assert json.loads((tmp_path / "m.json").read_text()) == printed


def test_tables_by_the_ending_of_their_name(run, tmp_path):
    assert run("analyse", AS2, "--table", "a.csv").code == 0
    expected = pd.read_csv(tmp_path / "a.csv")
    if importlib.util.find_spec("pyarrow") is not None:
        assert run("analyse", AS2, "--table", "a.parquet").code == 0
        read = pd.read_parquet(tmp_path / "a.parquet")
        pd.testing.assert_frame_equal(read, expected, check_dtype=False)
    if importlib.util.find_spec("xlsxwriter") is not None:
        assert run("analyse", AS2, "--table", "a.xlsx").code == 0
        assert zipfile.is_zipfile(tmp_path / "a.xlsx")
