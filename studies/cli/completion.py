"""Shell completion: names, files, keys and their values; imported when a shell asks, and light.

The shells' scripts are click's; see "Shell Completion" in its documentation.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from click.shell_completion import BashComplete, CompletionItem, ZshComplete, add_completion_class

from missions.files.shipped import shipped_names, shipped_records

YAML, LOGS = (".yaml", ".yml"), (".csv", ".ulg", ".bin")
_SHORT_NAMES = ("wingspan_m", "aspect_ratio", "battery_mass_kg", "module_area_m2")
# Columns of trade studies; a test compares them with the studies' own.
COLUMNS = (
    *("wingspan", "aspect_ratio", "battery_mass", "module_area", "total_mass", "payload_mass"),
    *("payload_power", "excess_time", "charge_margin", "endurance", "minimum_state_of_charge"),
    *("power", "worst_latitude", "worst_day", "shortfall"),
)

KEYS_FILE = "completion_keys.csv"

Items = list[CompletionItem[str]]


class Key(NamedTuple):
    """A key as ``--set`` takes it, the values it allows if those are few, and what it is."""

    key: str
    values: tuple[str, ...]
    number: bool
    label: str


def known_keys() -> list[Key]:
    """All keys, as they are written down."""
    text = resources.files("studies.cli").joinpath(KEYS_FILE).read_text(encoding="utf-8")
    rows = csv.reader(text.splitlines())
    return [Key(k, tuple(v.split("|")) if v else (), n == "number", la) for k, v, n, la in rows]


def values_for(name: str, incomplete: str) -> Items:
    """What may stand for an argument or option."""
    if name == "aircraft":
        return [*_names(shipped_names("aircraft"), incomplete), *_files(YAML, incomplete)]
    if name == "mission":
        return [*_names(shipped_names("mission"), incomplete), *_files(YAML, incomplete)]
    if name == "weather_file":
        return [*_names(shipped_records(), incomplete), *_files(None, incomplete)]
    if name == "shipped":
        every = [*shipped_names("aircraft"), *shipped_names("mission"), *shipped_records()]
        return _names(every, incomplete)
    if name == "files":
        return _files(YAML, incomplete)
    if name == "log_file":
        return _files(LOGS, incomplete)
    if name == "overrides":
        return _keys(known_keys(), incomplete)
    if name == "axes":
        numbers = [key for key in known_keys() if key.number]
        return [*_names((f"{n}=" for n in _SHORT_NAMES), incomplete), *_keys(numbers, incomplete)]
    if name in ("pareto", "sort"):
        sign = "-" * incomplete.startswith("-")
        return _names((f"{sign}{column}" for column in COLUMNS), incomplete)
    return []


def _names(names: Iterable[str], incomplete: str) -> Items:
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


def _keys(keys: Iterable[Key], incomplete: str) -> Items:
    """Keys up to their next dot, or the values of a key that is written out."""
    typed, equals, value = incomplete.partition("=")
    if equals:
        (values,) = [key.values for key in keys if key.key == typed] or [()]
        return [CompletionItem(f"{typed}={one}") for one in values if one.startswith(value)]
    found: dict[str, str] = {}
    for key in keys:
        if key.key.startswith(incomplete):
            part, dot, _ = key.key[len(incomplete) :].partition(".")
            found.setdefault(f"{incomplete}{part}{dot or '='}", "" if dot else key.label)
    if len(found) == 1 and next(iter(found)).endswith("."):
        return _keys(keys, next(iter(found)))
    return [CompletionItem(text, help=label or None) for text, label in found.items()]


def _files(endings: tuple[str, ...] | None, incomplete: str) -> Items:
    """Files of some endings, folders that lead on, and folders of results."""
    head, _, tail = incomplete.rpartition("/")
    folder = Path(f"{head}/" if "/" in incomplete else ".").expanduser()
    try:
        entries = sorted(folder.iterdir(), key=lambda path: path.name)
    except OSError:
        return []
    names = []
    for path in entries:
        if not path.name.startswith(tail) or (path.name.startswith(".") and not tail):
            continue
        text = f"{head}/{path.name}" if "/" in incomplete else path.name
        if path.is_dir():
            names.append(text if (path / "run.json").is_file() else f"{text}/")
        elif endings is None or path.name.lower().endswith(endings):
            names.append(text)
    return [CompletionItem(text) for text in names]


class Bash(BashComplete):
    """Bash, which takes ``key=value`` for three words, and would end every word with a space."""

    name = "bash"
    # No space follows what must go on.
    source_template = BashComplete.source_template.replace(
        "COMPREPLY+=($value)",
        'COMPREPLY+=("$value")\n            [[ $value == *[./=,] ]] && compopt -o nospace',
    ).replace("COMP_CWORD=", 'COMP_WORDBREAKS="$COMP_WORDBREAKS" COMP_CWORD=')

    def get_completion_args(self) -> tuple[list[str], str]:
        """Words before the one that is completed, and that word as it was typed."""
        parts = os.environ["COMP_WORDS"].split("\n")
        parts = parts if len(parts) > 1 else os.environ["COMP_WORDS"].split(" ")
        words: list[str] = []
        for place, part in enumerate(parts[: _word_index() + 1]):
            glued = part[:1] in ("=", ":") or (place > 0 and parts[place - 1][-1:] in ("=", ":"))
            if glued and words:
                words[-1] += part
            else:
                words.append(part)
        incomplete = words.pop() if len(words) > 1 else ""
        # Bash replaces what stands behind the last sign at which it divides words.
        signs = os.environ.get("COMP_WORDBREAKS", "=:")
        breaks = [incomplete.rfind(sign) for sign in "=:" if sign in signs]
        self._kept = max(breaks, default=-1) + 1
        return words[1:], incomplete.strip("'\"")

    def format_completion(self, item: CompletionItem[str]) -> str:
        """Completion as the script reads it, without what the shell keeps."""
        return f"{item.type},{item.value[self._kept :]}"


class Zsh(ZshComplete):
    """Zsh, which would end every word with a space."""

    name = "zsh"
    source_template = (
        ZshComplete.source_template.replace(
            '            if [[ "$descr" == "_" ]]; then',
            '            if [[ "$key" == *[./=,] ]]; then\n'
            '                open+=("$key")\n'
            '            elif [[ "$descr" == "_" ]]; then',
        )
        .replace("    local -a response\n", "    local -a response open\n")
        .replace(
            '    if [ -n "$completions" ]; then',
            '    if [ -n "$open" ]; then\n'
            "        compadd -U -S '' -V unsorted -a open\n"
            "    fi\n\n"
            '    if [ -n "$completions" ]; then',
        )
    )


def _word_index() -> int:
    """Number of the word that is completed."""
    return int(os.environ["COMP_CWORD"])


def prepare() -> None:
    """Register what the shells ask with; a request that no shell makes asks for nothing."""
    fish = os.environ["_SOLAR_UAV_COMPLETE"].startswith("fish")  # gives the word, not its number
    os.environ.setdefault("COMP_WORDS", "")
    os.environ.setdefault("COMP_CWORD", "" if fish else "0")
    try:
        usable = fish or _word_index() >= 0
    except ValueError:
        usable = False
    if not usable:
        os.environ["COMP_CWORD"] = "0"
    add_completion_class(Bash)
    add_completion_class(Zsh)
