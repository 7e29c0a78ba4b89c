"""The nomenclature lists the symbols of all formulas, and the units that names end in."""

import csv
import re

import pytest
from documented import DOCS, without_code

PAGE = DOCS / "nomenclature.md"
with (DOCS / "symbols.csv").open(encoding="utf-8") as symbols_file:
    ROWS = list(csv.DictReader(symbols_file))
FORMULA = re.compile(r"\$\$(.+?)\$\$|\$([^$\n]+(?:\n[^$\n]+)?)\$", re.S)
# Words, and units, which are set upright and are no symbols.
NO_SYMBOL = re.compile(
    r"\\text\{[^}]*\}|\\(?:begin|end)\{[^}]*\}"
    r"|(?<!_)\\mathrm\{(?:[CKh]|[^}]*[/\\][^}]*)\}"
)
SYMBOL = re.compile(
    r"(?:\\(?:vec|bar|dot)\s*)?(?:\\mathrm\{[A-Za-z]+\}|\\[A-Za-z]+|[A-Za-z])"
    r"(?:_(?:\{(?:[^{}]|\{[^{}]*\})*\}|\\[A-Za-z]+(?:\{[^}]*\})?|[A-Za-z0-9]))?"
)
OPERATORS = re.compile(
    r"t?frac|sqrt|sum|o?int|partial|min|max|left|right|big[lr]|[lr]vert|[lr]ceil|sin|cos|tan"
    r"|arccos|ln|exp|pi|circ|cdot|times|approx|[lg]e|pm|mp|dots|q?quad"
)
# Of differentials and powers of ten in the text.
PLAIN = {"d"}


def symbols(text):
    """Symbols of the formulas of a text, with their indices as plain letters."""
    found = set()
    for formula in FORMULA.finditer(text):
        for match in SYMBOL.findall(NO_SYMBOL.sub(" ", formula[1] or formula[2])):
            name = re.sub(r"\\mathrm\s*|\\,|[{} ]", "", match)
            command = re.match(r"\\([a-z]+)(?![A-Za-z])", name)
            if command is None or not OPERATORS.fullmatch(command[1]):
                found.add(name)
    return found - PLAIN


def listed_symbols():
    """Symbols of the table that the site shows."""
    return symbols("\n\n".join(row["symbol"] for row in ROWS))


def test_pages_of_symbols_exist():
    assert {page for row in ROWS for page in row["pages"].split()} <= {
        path.stem for path in DOCS.glob("*.md")
    }


def table(heading):
    """First cells of the table under a heading."""
    text = PAGE.read_text(encoding="utf-8").partition(f"## {heading}\n")[2].partition("\n## ")[0]
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    return [row.split("|")[1] for row in rows[1:]]


@pytest.mark.parametrize(
    "page", [path for path in sorted(DOCS.glob("*.md")) if path != PAGE], ids=lambda path: path.stem
)
def test_symbols_of_the_page_are_listed(page):
    listed = listed_symbols()
    text = re.sub(r"`[^`]*`", "", without_code(page))
    assert symbols(text) <= listed, sorted(symbols(text) - listed)


def test_every_symbol_that_is_listed_is_used():
    pages = [path for path in DOCS.glob("*.md") if path != PAGE]
    used = set().union(*(symbols(without_code(page)) for page in pages))
    listed = listed_symbols()
    assert listed <= used, sorted(listed - used)


def keys():
    """Keys of files and JSON in the tables of the pages."""
    found = set()
    for page in DOCS.glob("*.md"):
        rows = re.findall(r"^\| (`[^|]*) \|", without_code(page), re.M)
        found |= {key for row in rows for key in re.findall(r"`[\w.\[\]]*?(\w+)`", row)}
    return found


def test_units_that_keys_end_in_are_listed():
    endings = {unit for row in table("Units in names") for unit in re.findall(r"`_(\w+)`", row)}
    units = {unit for ending in endings for unit in ending.split("_") if unit != "per"}
    # What is longer is a word.
    short = {key for key in keys() if re.search(r"_[a-z]{1,2}\d?$", key)}
    assert short
    assert {key for key in short if key.rpartition("_")[2] not in units} <= {"found_by", "held_by"}
