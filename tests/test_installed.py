"""The distribution as installed: where it is imported from and what it ships.

``SOLAR_UAV_TEST_INSTALLED=1`` states that the tests must run against an installed wheel;
without it the tests also accept an editable install.
"""

import importlib
import json
import os
import sysconfig
from importlib import metadata, resources
from pathlib import Path

import pytest

DISTRIBUTION = "solar-uav-sizing"
PACKAGES = ("solar", "missions", "sizing", "studies")
SOURCE_ROOT = Path(__file__).resolve().parents[1]

must_be_installed = os.environ.get("SOLAR_UAV_TEST_INSTALLED") == "1"


def is_editable():
    direct_url = metadata.distribution(DISTRIBUTION).read_text("direct_url.json")
    return direct_url is not None and json.loads(direct_url).get("dir_info", {}).get(
        "editable", False
    )


def shipped_files():
    """Return the installed files of the four packages, by their path in the wheel."""
    files = metadata.files(DISTRIBUTION)
    assert files is not None, "the installed distribution has no RECORD"
    return {
        file.as_posix(): Path(str(file.locate()))
        for file in files
        if file.parts[0] in PACKAGES and file.suffix != ".pyc"
    }


def source_files(package):
    """Return the files of a package in the source tree, by their path in the wheel."""
    return {
        path.relative_to(SOURCE_ROOT).as_posix(): path
        for path in (SOURCE_ROOT / package).rglob("*")
        if path.is_file() and path.suffix != ".pyc" and not path.name.startswith(".")
    }


def skip_unless_wheel():
    if is_editable():
        assert not must_be_installed, "SOLAR_UAV_TEST_INSTALLED=1, but the install is editable"
        pytest.skip("editable install: the source tree is what is installed")


@pytest.mark.skipif(not must_be_installed, reason="SOLAR_UAV_TEST_INSTALLED is not 1")
@pytest.mark.parametrize("package", PACKAGES)
def test_package_is_imported_from_site_packages(package):
    module_file = importlib.import_module(package).__file__
    assert module_file is not None
    assert Path(module_file).resolve().is_relative_to(Path(sysconfig.get_path("purelib")).resolve())


def test_version_matches_the_metadata():
    assert importlib.import_module("solar").__version__ == metadata.version(DISTRIBUTION)


def test_command_is_registered():
    (script,) = metadata.distribution(DISTRIBUTION).entry_points.select(group="console_scripts")
    assert (script.name, script.value) == ("solar-uav", "studies.cli.start:start")


@pytest.mark.parametrize("package", PACKAGES)
def test_package_is_marked_as_typed(package):
    assert resources.files(package).joinpath("py.typed").is_file()


def test_only_the_four_packages_are_shipped():
    skip_unless_wheel()
    files = metadata.files(DISTRIBUTION)
    assert files is not None
    top_levels = {file.parts[0] for file in files if file.parts[0] != ".."}
    assert {name for name in top_levels if not name.endswith(".dist-info")} == set(PACKAGES)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_file_of_the_source_tree_is_shipped(package):
    skip_unless_wheel()
    sources = source_files(package)
    if not sources:
        pytest.skip("no source tree beside the tests")
    shipped = {name for name in shipped_files() if name.split("/")[0] == package}
    assert shipped == set(sources)


@pytest.mark.parametrize("package", PACKAGES)
def test_installed_files_are_those_of_the_source_tree(package):
    skip_unless_wheel()
    shipped = shipped_files()
    stale = [
        name
        for name, path in source_files(package).items()
        if name in shipped and shipped[name].read_bytes() != path.read_bytes()
    ]
    assert not stale, "older than the source tree: install the project again, then test"
