"""One word for one thing: what people read has none of the words that the nomenclature replaces."""

import ast
import re

import pytest
from documented import PAGES, ROOT, without_code

PACKAGES = ("solar", "missions", "sizing", "studies")
_ROW = re.compile(r"^\| (.+?) \| .+ \| ((?:`[^`]+`(?:, )?)+) \|$", re.M)
# In these words are quoted: those to avoid, and what earlier versions did or printed.
_QUOTING = {"CONTRIBUTING.md", "CHANGELOG.md", "upgrade.md", "changelog.md", "reliability.md"}


def replaced_words():
    """Words of the last column of the table."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = page.partition("\n## Words\n")[2].partition("\n## ")[0]
    return [word for row in _ROW.finditer(table) for word in re.findall(r"`([^`]+)`", row[2])]


def pattern_of(word):
    """A word by itself; a number stands for any, and N is no newton."""
    text = re.escape(word).replace(re.escape("47.6"), r"\d+(?:\.\d+)?")
    # A force goes on with what it is a force of.
    end = r"(?=[,.;:)]|$| on | and | to | in )" if word.startswith("47.6") else r"\b"
    return re.compile(rf"(?<![\w/]){text}{end}", re.M)


def texts_of_python():
    """Sentences in string literals; names and units are single words, docstrings are code's.

    Tables of keys are none.
    """
    for path in sorted(one for name in PACKAGES for one in (ROOT / name).rglob("*.py")):
        if path.name == "serialise.py":
            continue
        tree = ast.parse(path.read_text(encoding="utf-8"))
        statements = [node.value for node in ast.walk(tree) if isinstance(node, ast.Expr)]
        docstrings = {id(value) for value in statements if isinstance(value, ast.Constant)}
        for node in ast.walk(tree):
            if not isinstance(node, ast.Constant) or id(node) in docstrings:
                continue
            if isinstance(node.value, str) and " " in node.value.strip():
                yield f"{path.relative_to(ROOT)}:{node.lineno}", node.value


def texts_of_pages():
    """Strings and elements of the explorer's page."""
    for path in sorted((ROOT / "studies" / "explorer").rglob("*.[jh]*")):
        if path.suffix in (".js", ".html") and "vendor" not in path.parts:
            text = re.sub(r"^\s*(?://|\*|/\*).*$", "", path.read_text(encoding="utf-8"), flags=re.M)
            for found in re.finditer(r'"[^"\n]* [^"\n]*"|`[^`]* [^`]*`|>[^<>{}]+<', text):
                yield str(path.relative_to(ROOT)), found[0]


def texts_of_documents():
    """Prose of the documentation."""
    for page in PAGES:
        if page.name not in _QUOTING:
            text = re.sub(r"`[^`]*`|<!--.*?-->|\]\([^)]*\)", "", without_code(page), flags=re.S)
            yield str(page.relative_to(ROOT)), text


SOURCES = {
    "program": texts_of_python,
    "explorer": texts_of_pages,
    "documentation": texts_of_documents,
}


@pytest.mark.parametrize("source", SOURCES)
def test_people_read_one_word_for_one_thing(source):
    texts, words = list(SOURCES[source]()), replaced_words()
    assert min(len(texts), len(words)) > 20
    wrong = [
        f"{place}: {word}: ...{text[max(found.start() - 40, 0) : found.end() + 20]!r}"
        for word in words
        for place, text in texts
        for found in pattern_of(word).finditer(text)
    ]
    assert not wrong, "\n".join(wrong)
