"""``CITATION.cff`` names this software, its version and the works that it stands on."""

import re
from pathlib import Path

import pytest
import yaml

from solar._version import __version__

ROOT = Path(__file__).resolve().parents[2]
CITATION = ROOT / "CITATION.cff"
CHANGELOG = ROOT / "CHANGELOG.md"
pytestmark = pytest.mark.skipif(not CITATION.is_file(), reason="tests run without the clone")


def test_citation_has_what_the_format_requires():
    """Citation File Format 1.2.0: required keys, and those of references."""
    cited = yaml.safe_load(CITATION.read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= cited.keys()
    assert cited["cff-version"] == "1.2.0"
    assert cited["version"] == __version__
    heading = re.search(r"^## \[(\d\S*)\] - (\S+)$", CHANGELOG.read_text(encoding="utf-8"), re.M)
    assert (heading[1], heading[2]) == (__version__, str(cited["date-released"]))
    assert cited["license"] == "MIT"
    assert cited["authors"] == [{"name": "The solar-uav-sizing developers"}]
    assert cited["references"]
    for work in cited["references"]:
        assert {"type", "title", "authors"} <= work.keys()
        assert work["type"] in {"report", "article", "thesis"}
        assert re.fullmatch(r"10\.\d{4,9}/\S+", work.get("doi", "10.1000/x"))
