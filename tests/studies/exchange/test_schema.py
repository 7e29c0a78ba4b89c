"""Tests of the JSON Schemas: they accept what the software accepts, and refuse plain mistakes."""

import copy
import json

import jsonschema
import pytest
from pydantic import ValidationError

from missions.files.shipped import find_document, shipped_names
from missions.mission import Mission
from sizing.aircraft import Aircraft
from studies.exchange.schema import file_schema

CLASSES = {"aircraft": Aircraft, "mission": Mission}
VALIDATORS = {kind: jsonschema.Draft202012Validator(file_schema(kind)) for kind in CLASSES}
SHIPPED = [(kind, name) for kind in CLASSES for name in shipped_names(kind)]


def content(kind, name):
    """File as JSON has it."""
    data = find_document(kind, name).data
    return json.loads(json.dumps(data))


def places(node, path=()):
    """Every key of a file."""
    if isinstance(node, dict):
        for key, inner in node.items():
            yield (*path, key)
            yield from places(inner, (*path, key))


def changed(data, path, value):
    """File with a value replaced, or left out if it is ``...``."""
    new = copy.deepcopy(data)
    node = new
    for key in path[:-1]:
        node = node[key]
    if value is ...:
        del node[path[-1]]
    else:
        node[path[-1]] = value
    return new


@pytest.mark.parametrize("kind", CLASSES)
def test_schema_is_a_schema(kind):
    schema = VALIDATORS[kind].schema
    jsonschema.Draft202012Validator.check_schema(schema)
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema


@pytest.mark.parametrize(("kind", "name"), SHIPPED)
def test_shipped_files_are_valid(kind, name):
    VALIDATORS[kind].validate(content(kind, name))


@pytest.mark.parametrize("kind", CLASSES)
def test_keys_have_labels_and_units(kind):
    schema = VALIDATORS[kind].schema
    if kind == "aircraft":
        field = schema["$defs"]["Battery"]["properties"]["specific_energy_wh_per_kg"]
        assert field["description"] == "Specific energy of the battery [Wh/kg]"
    else:
        assert schema["properties"]["clearness"]["description"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "name"), [("aircraft", "atlantiksolar-design"), ("mission", "rafz-28h")]
)
def test_whatever_is_accepted_is_valid(kind, name):
    # An editor must not underline what the software takes: every key left out, and with values of
    # other types, judged by both.
    data, refused_by_both = content(kind, name), 0
    for path in list(places(data)):
        for value in (..., None, 0, 0.5, 30, "none", "07-15", True, {}, [], {"unknown": 1}):
            try:
                CLASSES[kind].model_validate(changed(data, path, value))
                accepted = True
            except ValidationError:
                accepted = False
            valid = VALIDATORS[kind].is_valid(changed(data, path, value))
            assert valid or not accepted, (path, value)
            refused_by_both += not valid and not accepted
    assert refused_by_both > 5 * len(list(places(data)))


def test_plain_mistakes_are_refused():
    data = content("aircraft", "atlantiksolar-as2")
    for path, value in (
        (("airframe", "wingspan_m"), "5"),
        (("airframe", "wingspan_m"), -1.0),
        (("airframe", "kind"), "imagined"),
        (("batery",), {}),
        (("modules", "efficiency_stc"), 23.7),
    ):
        assert not VALIDATORS["aircraft"].is_valid(changed(data, path, value))
