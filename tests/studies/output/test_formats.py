import io
import zipfile

import pandas as pd
import pytest

from missions.files.writing import OutputError
from studies.output import formats
from studies.output.formats import csv_bytes, format_of, table_bytes, workbook_bytes


def test_text_that_a_spreadsheet_would_compute_is_quoted():
    texts = ["=cmd|'/c calc'!A0", "+1", "-1", "@SUM(A1)", "\tx", "plain", ""]
    table = pd.DataFrame({"text": texts, "number": [-1.0, 2.0, -3.0, 4.0, 5.0, 6.0, 7.0]})
    read = pd.read_csv(io.BytesIO(csv_bytes(table)), keep_default_na=False)
    assert read["text"].tolist() == [*(f"'{text}" for text in texts[:5]), "plain", ""]
    assert read["number"].tolist() == table["number"].tolist()
    assert table["text"].tolist() == texts


def test_text_of_a_workbook_is_never_a_formula():
    pytest.importorskip("xlsxwriter")
    texts = ["=1+1", "https://example.org", "plain"]
    table = pd.DataFrame({"text": texts, "number": [1.5, float("inf"), 3.0]})
    with zipfile.ZipFile(io.BytesIO(workbook_bytes({"a/b:c": table}))) as book:
        sheet = book.read("xl/worksheets/sheet1.xml").decode()
        strings = book.read("xl/sharedStrings.xml").decode()
        assert 'name="abc"' in book.read("xl/workbook.xml").decode()
    assert "<f>" not in sheet
    assert "<hyperlink" not in sheet
    for text in (*texts, "unlimited"):
        assert f"<t>{text}</t>" in strings


def test_format_of_a_name():
    found = {"a.csv": "csv", "a.XLSX": "xlsx", "a.parquet": "parquet", "a.txt": None}
    for path, kind in (found | {"/dev/stdout": "csv", "a.b/c": "csv"}).items():
        assert format_of(path, formats.TABLE_FORMATS, "csv") == kind


def test_a_sheet_has_room_for_a_million_rows(monkeypatch):
    pytest.importorskip("xlsxwriter")
    monkeypatch.setattr(formats, "_MOST_ROWS", 2)
    with pytest.raises(OutputError, match="3 rows; a sheet of Excel holds 2: write CSV"):
        table_bytes(pd.DataFrame({"a": [1, 2, 3]}), "a.xlsx")
