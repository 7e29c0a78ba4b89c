"""The same numbers and files on any machine: language, encoding, time zone, folders, Windows."""

import json
import os
import shutil
import subprocess
import sys

import pytest

from missions.files.shipped import shipped_text
from missions.files.writing import names_a_device
from missions.library import load_mission
from sizing.library import load_aircraft

pytestmark = pytest.mark.slow

AS2 = "atlantiksolar-as2"


@pytest.fixture(scope="module")
def locales(tmp_path_factory):
    """Languages with a decimal comma and with a dotless i; None where they cannot be made."""
    folder = tmp_path_factory.mktemp("locales")
    if shutil.which("localedef") is None:
        return None
    for name in ("de_DE", "tr_TR"):
        command = ["localedef", "-i", name, "-f", "UTF-8", str(folder / f"{name}.UTF-8")]
        if subprocess.run(command, capture_output=True, check=False).returncode not in (0, 1):
            return None
    return folder


def analysed(folder, *before, **variables):
    """Record, text and messages of a process of its own."""
    code = "; ".join([*before, "from studies.cli.__main__ import main", "main()"])
    arguments = ["analyse", AS2, "--json", "--table", "day.csv"]
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=folder,
        env={**os.environ, **variables},
        capture_output=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    table = (folder / "day.csv").read_bytes()
    return json.loads(done.stdout), table.decode("ascii"), done.stderr.decode("ascii")


@pytest.fixture(scope="module")
def usual(tmp_path_factory):
    """What comes out where nothing is odd."""
    return analysed(tmp_path_factory.mktemp("usual"))


def test_a_poor_environment_changes_nothing(tmp_path, usual):
    """No UTF-8, no home, nowhere to keep settings, a day ahead of Greenwich."""
    found = analysed(
        tmp_path,
        LC_ALL="C",
        PYTHONUTF8="0",
        PYTHONCOERCECLOCALE="0",
        PYTHONIOENCODING="ascii",
        HOME="/dev/null/none",
        MPLCONFIGDIR="/dev/null/none",
        XDG_CACHE_HOME="/dev/null/none",
        TZ="Pacific/Kiritimati",
    )
    assert found == usual


@pytest.mark.parametrize("language", ["de_DE", "tr_TR"])
def test_another_language_changes_nothing(language, locales, tmp_path, usual):
    if locales is None:
        pytest.skip("localedef is missing, or has no source of these languages")
    # Set as a program does that embeds Python: C libraries then read and write decimal commas.
    setting = "import locale; locale.setlocale(locale.LC_ALL, '')"
    point = "assert locale.localeconv()['decimal_point'] == ','"
    variables = {"LOCPATH": str(locales), "LC_ALL": f"{language}.UTF-8"}
    assert analysed(tmp_path, setting, point, **variables) == usual


def test_files_with_line_ends_of_windows_are_the_same(tmp_path):
    for name, load in ((AS2, load_aircraft), ("rafz-july", load_mission)):
        path = tmp_path / f"{name}.yaml"
        path.write_bytes(shipped_text(name).replace("\n", "\r\n").encode("utf-8-sig"))
        assert load(path) == load(name)  # type: ignore[operator]


@pytest.mark.parametrize("name", ["console", "com", "com10", "nullarbor", "my.con", "aux-1"])
def test_what_only_resembles_a_device_is_a_name(name):
    assert not names_a_device(name)


@pytest.mark.skipif(os.name != "posix", reason="closed by a shell")
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&- <&-"])
def test_closed_streams_are_no_reason_to_fail(closed, tmp_path):
    code = "from studies.cli.__main__ import main; main()"
    words = [sys.executable, "-c", code, "analyse", AS2, "--csv", "day.csv"]
    done = subprocess.run(
        ["sh", "-c", f'exec "$@" {closed}', "-", *words],
        cwd=tmp_path,
        env={name: value for name, value in os.environ.items() if name != "COLUMNS"},
        capture_output=True,
        timeout=300,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, b"")
    # What a library prints does not end in a file that was opened in the place of a stream.
    assert (tmp_path / "day.csv").read_text().splitlines()[0].count(",") > 3
