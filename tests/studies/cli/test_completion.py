"""Shell completion: what is offered, how bash divides words, and that it is light."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from benchmarks.completion_keys import keys_of_classes, to_text
from studies.cli import __main__ as main
from studies.cli import completion
from studies.cli.completion import KEYS_FILE, known_keys
from studies.sweeps.points import BLANKS, SIZED_BLANKS

AGEING = [key.key + "=" for key in known_keys() if key.key.startswith("battery.ageing.")]
DIVIDED = ["solar-uav", "sweep", "x", "--vary", "wingspan_m", *"=3:8:1", "--vary"]
TURBULENCE = ["mission.turbulence.all_day=", "mission.turbulence.thermal="]


def offered(*words: str) -> list[str]:
    """What click's interface offers for the last of some words."""
    *before, incomplete = words
    complete = ShellComplete(main.cli, {}, "solar-uav", "_SOLAR_UAV_COMPLETE")
    return [item.value for item in complete.get_completions(list(before), incomplete)]


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("an",), ["analyse"]),
        (("analyse", "sky"), ["sky-sailor", "sky-sailor-2008"]),
        (("size", "x", "-m", "central"), ["central-europe-summer"]),
        (("analyse", "x", "--weather", "col"), ["colorado-2023"]),
        (("show", "rafz-2"), ["rafz-28h"]),
        (("analyse", "x", "--set", "mission.turb"), TURBULENCE),
        (("sweep", "x", "--vary", "mission.turb"), TURBULENCE),
        (("analyse", "x", "--set", "battery.charge_limit.k"), ["battery.charge_limit.kind="]),
        (
            ("analyse", "x", "--set", "mission.climb.strategy="),
            ["mission.climb.strategy=battery_full", "mission.climb.strategy=surplus"],
        ),
        (("sweep", "x", "--vary", "wing"), ["wingspan_m="]),
        (("sweep", "x", "--vary", "battery.charge_limit.k"), []),
        (("sweep", "x", "--sort", "end"), ["endurance"]),
        (("sweep", "x", "--pareto", "total_mass", "exc"), ["excess_time"]),
        (("compare", "x", "--models", "CDM,f"), ["CDM,FM"]),
        (("sweep", "x", "--resize", "min_m"), ["min_mass"]),
        (("sweep", "--keep"), ["--keep-parts"]),
        (("analyse", "x", "--set", "nobody.knows="), []),
    ],
)
def test_what_is_offered(words: tuple[str, ...], wanted: list[str]) -> None:
    assert offered(*words) == wanted


def test_keys_are_offered_part_by_part() -> None:
    parts = offered("analyse", "x", "--set", "")
    assert {"airframe.", "battery.", "mission.", "name="} <= set(parts)
    assert len(parts) < 12


def test_files_and_folders_are_offered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    logs = ("mine-log.csv", "mine-log.bin")
    for name in ("mine.yaml", *logs, "mine.txt", "results/run.json", "more/mine.yml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert offered("analyse", "mi") == ["mine.yaml"]
    assert offered("analyse", "re") == ["results"]
    assert offered("validate", "mo") == ["more/"]
    assert offered("validate", "more/") == ["more/mine.yml"]
    assert offered("verify", "x", "mine") == ["mine-log.bin", "mine-log.csv"]
    assert offered("analyse", "nowhere/") == []


def test_keys_that_are_written_down_are_those_of_the_classes() -> None:
    made_anew = f"python -m benchmarks.completion_keys writes {KEYS_FILE} anew"
    assert to_text(known_keys()) == to_text(keys_of_classes()), made_anew


def test_columns_of_studies_are_all_offered() -> None:
    numbers = {n for b in (BLANKS, SIZED_BLANKS) for n, v in b.items() if isinstance(v, float)}
    assert set(completion.COLUMNS) <= numbers
    assert set(BLANKS) & numbers <= set(completion.COLUMNS)


@pytest.mark.long
@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["solar-uav", "ana"], ["analyse"]),
        (["solar-uav", "analyse", "x", "--set", "battery.a"], AGEING),
        # As bash divides KEY=VALUE and first:last:step.
        (["solar-uav", "analyse", "x", "--set", "battery.charge_limit.kind", "=", "t"], ["table"]),
        (["solar-uav", "analyse", "x", "--set", "battery.charge_limit.kind", "=n"], ["none"]),
        (
            [
                *[
                    "solar-uav",
                    "sweep",
                    "x",
                    "--vary",
                    "wingspan_m",
                    "=",
                    "3",
                    ":",
                    "8",
                    ":",
                    "1",
                    "--vary",
                ],
                "asp",
            ],
            ["aspect_ratio="],
        ),
    ],
)
def test_bash_divides_words_at_signs(words: list[str], wanted: list[str]) -> None:
    script = (
        'eval "$(_SOLAR_UAV_COMPLETE=bash_source solar-uav)"\n'
        f"COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}\n"
        "_solar_uav_completion solar-uav\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    env = dict(os.environ, PATH=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    done = subprocess.run(
        ["bash", "--norc", "-c", script], env=env, capture_output=True, text=True, check=False
    )
    assert done.stdout.split() == wanted, done.stderr


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts_of_the_shells(shell: str) -> None:
    env = dict(os.environ, _SOLAR_UAV_COMPLETE=f"{shell}_source")
    done = subprocess.run(
        [sys.executable, "-m", "studies.cli"], env=env, capture_output=True, text=True, check=True
    )
    assert "solar-uav" in done.stdout
    if shell == "bash":
        assert "compopt -o nospace" in done.stdout
    if shell == "zsh":
        assert done.stdout.count("open") == 3 + 1


def test_completion_imports_nothing_heavy() -> None:
    code = (
        "import sys\n"
        "from click.shell_completion import ShellComplete\n"
        "from studies.cli.__main__ import cli\n"
        "complete = ShellComplete(cli, {}, 'solar-uav', '_SOLAR_UAV_COMPLETE')\n"
        "for words in (['a'], ['sweep', 'x', '--vary', 'b'], ['analyse', 's']):\n"
        "    assert complete.get_completions(words[:-1], words[-1])\n"
        "heavy = {'numpy', 'pydantic', 'pandas', 'casadi', 'matplotlib', 'rich'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
@pytest.mark.parametrize("place", ["", "-1", "x", "99", "9" * 5000, None])
def test_a_request_that_no_shell_makes_is_no_mistake_of_ours(
    shell: str, place: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("_SOLAR_UAV_COMPLETE", f"{shell}_complete")
    monkeypatch.setenv("COMP_WORDS", "solar-uav ana")
    if place is None:
        monkeypatch.delenv("COMP_CWORD", raising=False)
        monkeypatch.delenv("COMP_WORDS")
    else:
        monkeypatch.setenv("COMP_CWORD", place)
    monkeypatch.setattr(sys, "argv", ["solar-uav"])
    with pytest.raises(SystemExit):
        main.main()
