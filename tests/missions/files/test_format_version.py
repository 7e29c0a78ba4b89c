"""The version of a file's format: written first, read if known, refused with its line if newer."""

import pytest

from missions.files.errors import InputError
from missions.files.shipped import find_document, shipped_names, shipped_text
from missions.files.validation import validate
from missions.files.writing import file_text
from missions.files.yaml import parse_yaml
from missions.library import load_mission
from missions.mission import Mission

PLAIN = "name: m\nlatitude_deg: 47.6\ndates: {on: 07-15}\n"


def mission(text):
    return validate(parse_yaml(text, "m.yaml"), Mission)


def test_a_file_without_it_is_of_the_first_format():
    assert mission(PLAIN).format_version == 1
    assert mission(PLAIN) == mission(f"format_version: 1\n{PLAIN}")


def test_a_newer_file_is_refused_for_that_alone():
    with pytest.raises(InputError) as refused:
        mission(f"# head\nformat_version: 2\n{PLAIN}latitude_rad: 0.8\nwind: calm\n")
    (problem,) = refused.value.problems
    assert str(problem).startswith("m.yaml:2:17: format_version: must be at most 1 (got 2): ")


@pytest.mark.parametrize("wrong", ["0", "1.0", "true", "'1'", "null", "[1]"])
def test_what_is_no_version_is_refused_at_its_place(wrong):
    with pytest.raises(InputError, match=r"^m.yaml:1:\d+: format_version: must be 1 \(got "):
        mission(f"format_version: {wrong}\n{PLAIN}")


def test_an_override_is_judged_as_the_file_is():
    with pytest.raises(InputError, match=r"^--set mission\.format_version: must be at most 1"):
        load_mission("rafz-july", ["format_version=2"])


@pytest.mark.parametrize("data", [{"name": "m"}, {"name": "m", "format_version": 1}])
def test_written_files_begin_with_it(data):
    text = file_text("Written by a test", data)
    assert text.startswith("# Written by a test\nformat_version: 1\nname: m\n")
    assert parse_yaml(text, "m.yaml").data == {"format_version": 1, "name": "m"}


@pytest.mark.parametrize("kind", ["aircraft", "mission"])
def test_shipped_files_state_it_first(kind):
    for name in shipped_names(kind):
        assert next(iter(find_document(kind, name).data)) == "format_version"
        assert "\nformat_version: 1\nname: " in shipped_text(name)
