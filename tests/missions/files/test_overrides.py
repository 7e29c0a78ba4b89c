import pytest

from missions.files.errors import InputError
from missions.files.overrides import with_overrides
from missions.files.yaml import parse_yaml


def test_aliases_give_independent_copies():
    document = parse_yaml("a: &x {b: [1]}\nc: *x", "a.yaml")
    assert document.data == {"a": {"b": [1]}, "c": {"b": [1]}}
    changed = with_overrides(document, ["c.b.0=2"])
    assert changed.data == {"a": {"b": [1]}, "c": {"b": [2]}}
    # A value stands where it is written.
    assert document.places["c",] == ((2, 1), (1, 4), "")
    assert document.places["c", "b"].value == (1, 11)
    assert parse_yaml("a: &x b\n*x : c", "a.yaml").data == {"a": "b", "b": "c"}


def overridden(text, *overrides):
    return with_overrides(parse_yaml(text, "a.yaml"), overrides).data


@pytest.mark.parametrize(
    ("override", "value"),
    [
        ("a=2.5", 2.5),
        ("a=-3", -3),
        ("a = 1e-3", 1e-3),
        ("a=true", True),
        ("a=null", None),
        ("a=12:30", "12:30"),
        ("a=no", "no"),
        ("a='2'", "2"),
        ("a=''", ""),
        ("a=x=y", "x=y"),
        ("a=[1, 2.5, [x]]", [1, 2.5, ["x"]]),
        ("a={b: 1}", {"b": 1}),
    ],
)
def test_override_values_follow_the_rules_of_files(override, value):
    assert overridden("a: 1", override) == {"a": value}


def test_overrides_reach_into_lists_and_new_mappings():
    data = overridden("a: [{b: 1}, 2]\nn:\n", "a.0.b=5", "a.1=6", "c.d.e=7", "c.f=8", "n.x=9")
    assert data == {"a": [{"b": 5}, 6], "c": {"d": {"e": 7}, "f": 8}, "n": {"x": 9}}


def test_later_override_wins_and_the_document_is_not_changed():
    document = parse_yaml("a: {b: 1}", "a.yaml")
    assert with_overrides(document, ["a.b=2", "a.b=3"]).data == {"a": {"b": 3}}
    assert document.data == {"a": {"b": 1}}
    assert not any(place.override for place in document.places.values())


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("a", "--set a: write an override as KEY=VALUE, for example a.b=2.5"),
        ("=1", "--set =1: write an override as KEY=VALUE, for example a.b=2.5"),
        ("a..b=1", "--set a..b=1: write an override as KEY=VALUE, for example a.b=2.5"),
        ("a=", "--set a: no value after the = sign (write null for no value)"),
        ("a=#x", "--set a: no value after the = sign (write null for no value)"),
        ("s.b.c=1", "--set s.b.c: s is the single value 3 and has no keys"),
        ("l.x=1", "--set l.x: l is a list and takes an index from 0 to 1 (got 'x')"),
        ("l.2=1", "--set l.2: l is a list and takes an index from 0 to 1 (got '2')"),
        ("l.-1=1", "--set l.-1: l is a list and takes an index from 0 to 1 (got '-1')"),
        ("e.0=1", "--set e.0: e is a list and takes no index: it is empty (got '0')"),
        ("a=!!int 3", "--set a: the value explicit tags (!!int) are not allowed"),
        ("\udcff=1", r"--set \udcff: the key holds a character that is not allowed"),
    ],
)
def test_bad_overrides(override, message):
    with pytest.raises(InputError) as caught:
        overridden("s: 3\nl: [1, 2]\ne: []\n", override)
    assert str(caught.value) == message
    # Those of several overrides come together.
    with pytest.raises(InputError) as both:
        overridden("s: 3\nl: [1, 2]\ne: []\n", "x", override)
    assert str(both.value).splitlines()[1:] == [message]


@pytest.mark.parametrize(
    "value", ["[1", "@x", "- 1", "b: 1", "--- 1\n--- 2", "\udcff", "[" * 999], ids=ascii
)
def test_unreadable_override_values(value):
    with pytest.raises(InputError) as caught:
        overridden("a: 1", f"a={value}")
    assert str(caught.value).startswith("--set a: ")
    str(caught.value).encode("utf-8")


@pytest.mark.parametrize("wrong", [None, 3, "a=1", b"a=1", ["a=1", 2], {1: 2}, [("a", 1)]])
def test_overrides_of_another_type_are_told(wrong):
    with pytest.raises(TypeError, match=r"^overrides are (a mapping|texts, such)"):
        with_overrides(parse_yaml("a: 1", "a.yaml"), wrong)
