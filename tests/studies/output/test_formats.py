"""Tests of tables as bytes of a file."""

from __future__ import annotations

import io

import pandas as pd

from studies.output.formats import csv_bytes


def test_text_that_a_spreadsheet_would_compute_is_quoted() -> None:
    texts = ["=cmd|'/c calc'!A0", "+1", "-1", "@SUM(A1)", "\tx", "plain", ""]
    table = pd.DataFrame({"text": texts, "number": [-1.0, 2.0, -3.0, 4.0, 5.0, 6.0, 7.0]})
    read = pd.read_csv(io.BytesIO(csv_bytes(table)), keep_default_na=False)
    assert read["text"].tolist() == [*(f"'{text}" for text in texts[:5]), "plain", ""]
    assert read["number"].tolist() == table["number"].tolist()
    assert table["text"].tolist() == texts
