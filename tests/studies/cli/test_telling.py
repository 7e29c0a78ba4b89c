"""What is told: no message steers a terminal, and none goes on for pages."""

import pytest

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
