"""Each question of a reader names the definition that answers: where is the excess time computed.

A reader who knows the tree of files should guess the file of most of them in ten seconds.
"""

import ast
import csv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
with (Path(__file__).parent / "where.csv").open(encoding="utf-8") as table:
    ANSWERS = list(csv.DictReader(table))


def test_there_are_thirty_different_questions():
    assert len({answer["question"] for answer in ANSWERS}) == len(ANSWERS) == 30


@pytest.mark.parametrize("answer", ANSWERS, ids=lambda answer: answer["question"])
def test_definition_that_answers_exists(answer):
    body = ast.parse((ROOT / answer["file"]).read_text(encoding="utf-8")).body
    for name in answer["definition"].split("."):
        nodes = [node for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
        definition = next((node for node in nodes if node.name == name), None)
        assert definition, f"no {answer['definition']} in {answer['file']}"
        assert ast.get_docstring(definition)
        body = definition.body
