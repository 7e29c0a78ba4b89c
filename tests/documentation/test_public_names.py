"""What ``dir()`` of the four packages offers is there, documented, and light to import."""

import importlib
import inspect
import pkgutil
import subprocess
import sys

import pytest

PACKAGES = ("solar", "missions", "sizing", "studies")


def public_names():
    return [(p, name) for p in PACKAGES for name in dir(importlib.import_module(p))]


@pytest.mark.parametrize(("package", "name"), public_names())
def test_public_name_is_there_and_documented(package, name):
    found = getattr(importlib.import_module(package), name)
    if inspect.isclass(found) or inspect.isfunction(found):
        assert inspect.getdoc(found)


@pytest.mark.parametrize("package", PACKAGES)
def test_no_public_name_is_hidden_by_a_module(package):
    # Importing a submodule sets an attribute of its package, whatever was there before.
    module = importlib.import_module(package)
    modules = {one.name for one in pkgutil.iter_modules(module.__path__)}
    assert not modules & set(dir(module))


# Sun, sky and modules need NumPy and pydantic, but no optimiser, no figures and no polygons.
POWER = """\
import solar
for name in dir(solar):
    getattr(solar, name)
place = {"altitude_m": 500.0, "cell": solar.SolarCell(), "module_temperature_c": 40.0}
assert solar.horizontal_specific_power(47.0, 172, 12.0, **place) > 100.0"""
# What a report needs is imported by the worker that makes one.
REPORT_TASK = """\
import studies.explorer.app
from studies.explorer.session import Session
from studies.case import Case
from studies.cli.files import opened
made = Session(Case(opened("aircraft", "sky-sailor"), opened("mission", "rafz-july")))
made.inputs(made.settings()).inputs()"""
WITHOUT_REPORT = """\
from studies.cli import commands, files, options
from studies.cli.outputs import check_report
check_report(None)"""


@pytest.mark.parametrize(
    ("code", "absent"),
    [
        (f"import {', '.join(PACKAGES)}", "numpy casadi pandas xarray matplotlib"),
        ("import missions.files.validation", "numpy pandas casadi scipy"),
        ("import sizing.parameters as p; p.label('battery_mass_kg')", "numpy pydantic casadi"),
        (POWER, "casadi matplotlib shapely"),
        pytest.param(REPORT_TASK, "studies.report", marks=pytest.mark.long),
        (WITHOUT_REPORT, "studies.report.document jinja2 matplotlib"),
    ],
    ids=["packages", "files", "parameters", "solar", "explorer", "commands"],
)
def test_no_more_is_imported_than_is_needed(code, absent):
    code += "\nimport sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    modules = done.stdout.split()
    assert not [m for name in absent.split() for m in modules if f"{m}.".startswith(f"{name}.")]


@pytest.mark.parametrize("package", ["missions", "sizing", "studies"])
def test_a_file_of_the_users_that_hides_the_package_is_named(tmp_path, package):
    (tmp_path / "solar.py").write_text("power = 1\n", encoding="utf-8")
    script = tmp_path / "mine.py"
    script.write_text(f"import {package}\n", encoding="utf-8")
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert f"ImportError: {tmp_path / 'solar.py'} hides the package 'solar'" in ran.stderr
