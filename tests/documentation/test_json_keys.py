"""Tables of JSON keys in the documentation name what the commands print, and all of it."""

import re
import shlex
from pathlib import Path
from string import Template

import pytest
import yaml

pytestmark = pytest.mark.slow

DOCS = Path(__file__).resolve().parents[2] / "docs"
TABLE = yaml.safe_load(Path(__file__).with_name("json_keys.yaml").read_text("utf-8"))
COMMON = {"aircraft", "mission", "mission_is_default"}
# Whose keys are quantities, items or places, described as a whole.
OPEN = {
    *("sobol", "spar_caps", "spar_web", "balance", "drag_coefficients", "others", "masses_kg"),
    *("power_budget", "quantities", "points", "status", "latitudes", "extrapolations"),
}


def keys(record, inside=""):
    """Names of all keys, at any depth."""
    if isinstance(record, list):
        for entry in record:
            yield from keys(entry, inside)
    elif isinstance(record, dict) and inside not in OPEN:
        for key, value in record.items():
            yield key
            yield from keys(value, key)


def section(page, command):
    """Part of a page on a command: under its heading, or all of a page of its own."""
    text = (DOCS / page).read_text(encoding="utf-8")
    if page != "cli.md":
        return text
    found = re.search(rf"^## `{command}`$.*?(?=^## |\Z)", text, re.M | re.S)
    return found[0]


def names(text):
    """Keys in code."""
    return {span.rstrip("[]") for span in re.findall(r"`(\w+(?:\[\])?)`", text)}


def first_columns(text):
    """First cells of the tables of keys."""
    tables = re.findall(r"^\| key.*\n\|[-:|\s]+\n((?:\|.*\n)+)", text, re.M)
    return "\n".join(row.split("|")[1] for table in tables for row in table.splitlines())


def test_keys_of_what_lies_outside_a_range_are_those_of_its_page(run):
    record = run(
        "analyse", "atlantiksolar-as2", "--set", "mission.wind_m_per_s=50", "--json"
    ).json()
    (one,) = record["extrapolations"]
    page = (DOCS / "validity.md").read_text(encoding="utf-8")
    assert set(one) == names(first_columns(page))


@pytest.mark.parametrize("row", TABLE["commands"], ids=lambda row: row["command"])
def test_keys_of_the_json_are_those_of_the_page(row, run):
    printed = set()
    verb, _, option = row["command"].partition(" --")
    for call in row["calls"]:
        words = shlex.split(Template(call).substitute(TABLE["options"]))
        record = run(verb, *words, "--json").json()
        # An option that adds a record has a page of its own for it.
        printed |= set(keys(record[option] if option else record)) - COMMON
    text = section(row["page"], row["command"])
    assert printed <= names(text), f"not documented: {sorted(printed - names(text))}"
    documented = names(first_columns(text))
    unknown = documented - printed - set(row.get("elsewhere", ()))
    assert not unknown, f"documented, but not printed: {sorted(unknown)}"
