"""What the site is built from is whole: tree of pages, functions, settings, notebook, checker."""

import importlib
import json
import re
import runpy
import tomllib

import pytest
from documented import DOCS, PAGES, ROOT

PACKAGES = ("solar", "missions", "sizing", "studies")
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def listed_pages():
    """Names in the toctrees, as they stand from ``docs/``."""
    found = set()
    for page in [*DOCS.glob("*.rst"), *(DOCS / "api").glob("*.rst")]:
        for tree in re.findall(
            r"^\.\. toctree::\n((?:   .*\n|\n)+)", page.read_text("utf-8"), re.M
        ):
            for entry in re.findall(r"^   ([^:\s].*)$", tree, re.M):
                found.add(re.sub(r"^.*<(.+)>$", r"\1", entry))
    return found


def test_every_page_is_in_the_tree_of_the_site():
    pages = [page for page in PAGES if DOCS in page.parents and page.name != "index.md"]
    pages += [*NOTEBOOKS, *DOCS.glob("*.rst"), *(DOCS / "api").glob("*.rst")]
    names = {page.relative_to(DOCS).with_suffix("").as_posix() for page in pages} - {"index"}
    assert names - listed_pages() == set()
    beside = {f"development/{name}" for name in ("contributing", "changelog", "security")}
    assert listed_pages() - names == {"gallery/index", *beside}


def test_pages_beside_the_documentation_are_in_the_source_distribution():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    included = settings["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    assert {f"/{page.name}" for page in ROOT.glob("*.md")} <= set(included)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_is_on_its_page(package):
    text = (DOCS / "api" / f"{package}.rst").read_text(encoding="utf-8")
    listed = re.findall(r"^   (\w+)$", text, re.M)
    public = {name for name in dir(importlib.import_module(package)) if not name.startswith("__")}
    assert set(listed) == public
    assert len(listed) == len(set(listed))


def test_settings_of_the_site_need_nothing_but_the_project():
    settings = runpy.run_path(str(DOCS / "conf.py"))
    assert settings["version"] == importlib.import_module("solar").__version__
    for name in (settings["mathjax_path"], *settings["html_css_files"], *settings["html_js_files"]):
        assert (DOCS / "_static" / name).is_file(), name


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, monkeypatch):
    pytest.importorskip("IPython", reason="the extra docs brings it")
    monkeypatch.chdir(tmp_path)
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_kept_without_output(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert code
    assert not any(cell["outputs"] or cell["execution_count"] for cell in code)


def test_messages_that_the_answers_quote_are_those_of_the_code():
    text = (DOCS / "faq.md").read_text(encoding="utf-8")
    quoted = re.findall(r"^\| `([^`]+)` \|", text, re.M)
    assert quoted
    code = "".join(path.read_text("utf-8") for path in (ROOT / "missions").rglob("*.py"))
    assert [message for message in quoted if message not in code] == []


def test_vendored_script_has_its_licence():
    folder = DOCS / "_static" / "mathjax"
    assert "Apache License" in (folder / "LICENSE").read_text(encoding="utf-8")
    assert "MathJax" in (folder / "tex-svg.js").read_text(encoding="utf-8")[:20000]


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ('<a href="other.html#there">x</a><img src="a.png" alt="">', None),
        ('<a href="https://example.org">x</a>', None),
        ('<a href="missing.html">x</a>', "leads nowhere"),
        ('<a href="other.html#missing">x</a>', "has no such anchor"),
        ('<a href="#missing">x</a>', "has no such anchor"),
        ('<script src="https://example.org/a.js"></script>', "loads https"),
        ('<link rel="stylesheet" href="//example.org/a.css">', "loads //"),
    ],
)
def test_site_checker(body, problem, tmp_path):
    problems = runpy.run_path(str(ROOT / "docs" / "check_site.py"))["problems"]
    (tmp_path / "index.html").write_text(f"<html><body>{body}</body></html>")
    (tmp_path / "other.html").write_text('<h1 id="there">x</h1>')
    (tmp_path / "a.png").touch()
    found, _ = problems(tmp_path)
    assert [problem in one for one in found] == [True] if problem else found == []
