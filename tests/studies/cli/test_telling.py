"""What is told: no message steers a terminal, and none goes on for pages."""

import io

import pytest
from rich.console import Console

from studies.cli import telling as progress
from studies.cli.telling import brief

ESCAPES = "\x1b]0;title\x07\x9b31m\u202e"


@pytest.mark.parametrize(
    "words",
    [
        *[(verb, ESCAPES) for verb in ("show", "init", "validate", "analyse")],
        ("show", "sky-sailor", ESCAPES),
        ("analyse", "sky-sailor", f"--{ESCAPES}"),
        *[("analyse", "sky-sailor", f"--{name}", ESCAPES) for name in ("model", "weather", "plot")],
        *[("analyse", "sky-sailor", "--set", f"{key}=1") for key in (ESCAPES, f"name={ESCAPES}")],
        ("analyse", "sky-sailor", "--csv", f"{ESCAPES}/a.csv"),
        ("map", "sky-sailor", "--latitudes", ESCAPES),
        ("verify", "sky-sailor", ESCAPES),
        (ESCAPES,),
    ],
)
def test_no_control_character_of_the_command_line_is_printed(run, words):
    outcome = run(*words)
    found = outcome.out + outcome.err
    assert found.replace("\n", "").isprintable()
    assert found.strip()


def test_no_control_character_of_a_file_is_printed(run, tmp_path):
    (tmp_path / "w.csv").write_text(f"# name: {ESCAPES}\n# latitude_deg: {ESCAPES}\n{ESCAPES},1\n")
    (tmp_path / "a.yaml").write_text(f'name: "\\e[31m"\n"{ESCAPES[1:8]}": "\\e"\n', "utf-8")
    for words in (("analyse", "sky-sailor", "--weather", "w.csv"), ("validate", "a.yaml")):
        outcome = run(*words)
        assert (outcome.out + outcome.err).replace("\n", "").isprintable()


def test_words_of_any_language_stay_readable():
    assert brief("Zürich\xa0日本\x1b[0m") == "Zürich\\xa0日本\\x1b[0m"


# ---- progress


def test_lines_are_rare_and_leave_standard_output_alone(monkeypatch, capsys):
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    with progress.progress_of("cells") as update:
        clock[0] += 10.0  # a cluster starts
        update(10, 100)  # kept from an earlier run
        for done in range(11, 101):
            clock[0] += 0.5
            update(done, 100)
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.splitlines()
    # After 5 s, then every 15 s; the rate is that of this run, 2 cells per second.
    assert lines[0] == "20 of 100 cells, 2/s, 40 s left"
    assert lines[1] == "50 of 100 cells, 2/s, 25 s left"
    assert lines[2:] == ["80 of 100 cells, 2/s, 10 s left", "100 of 100 cells"]


def test_what_is_quick_is_silent(capsys):
    with progress.progress_of("cells") as update:
        for done in range(3):
            update(done, 2)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_gets_a_bar_with_the_rate(monkeypatch):
    screen = io.StringIO()
    terminal = Console(file=screen, force_terminal=True, width=100)
    monkeypatch.setattr("rich.console.Console", lambda **options: terminal)
    clock = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: clock[0])
    with progress.progress_of("cells") as update:
        update(0, 100)
        clock[0] = 4.0
        update(20, 100)
    assert "20/100" in screen.getvalue()
    assert "5/s" in screen.getvalue()
