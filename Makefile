# The steps of .ci/run one by one, in a virtual environment of the clone.
#
# The project is installed non-editable before every test run, so what is tested is what
# would be shipped. `make ci` runs the whole of it in a scratch copy.

PYTHON ?= python3
BIN := .venv/bin

.PHONY: help check ci install tables docs test browser lint format types imports build clean

help:
	@echo "make check    test, lint, types and imports"
	@echo "make test     install the project and run the tests"
	@echo "make browser  install the project and run the tests of its pages in Chromium"
	@echo "make lint     ruff check and ruff format --check"
	@echo "make format   let ruff fix and format"
	@echo "make types    mypy"
	@echo "make imports  the contracts between the layers"
	@echo "make tables   write the tables of docs/ anew"
	@echo "make docs     build the documentation site in docs/_build/html and check its links"
	@echo "make build    sdist and wheel in dist/"
	@echo "make ci       everything, as CI runs it, in a scratch copy"
	@echo "make clean    remove what these commands made"

check: test lint types imports

ci:
	.ci/run

$(BIN)/python:
	$(PYTHON) -m venv .venv

install: $(BIN)/python
	$(BIN)/pip install --quiet ".[dev]"

tables: install
	$(BIN)/python -m benchmarks.doc_tables

docs: install
	$(BIN)/pip install --quiet ".[docs]"
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs docs/_build/html
	$(BIN)/python docs/check_site.py docs/_build/html

test: install
	SOLAR_UAV_TEST_INSTALLED=1 $(BIN)/pytest -n auto --dist loadfile

browser: install
	$(BIN)/pip install --quiet ".[browser]"
	SOLAR_UAV_TEST_INSTALLED=1 SOLAR_UAV_TEST_BROWSER=1 $(BIN)/pytest -m browser

lint: $(BIN)/ruff
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: $(BIN)/ruff
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: $(BIN)/mypy
	$(BIN)/mypy

imports: $(BIN)/lint-imports
	$(BIN)/lint-imports

build: $(BIN)/pyproject-build
	$(BIN)/python -m build

# The tools come with the first install.
$(BIN)/ruff $(BIN)/mypy $(BIN)/lint-imports $(BIN)/pyproject-build:
	$(MAKE) install

clean:
	rm -rf .venv dist build docs/_build docs/api/generated docs/gallery .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
