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


def test_importing_the_packages_imports_nothing_heavy():
    code = f"import {', '.join(PACKAGES)}, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "casadi", "pandas", "xarray", "matplotlib"} & set(done.stdout.split())


@pytest.mark.parametrize("package", ["missions", "sizing", "studies"])
def test_a_file_of_the_users_that_hides_the_package_is_named(tmp_path, package):
    (tmp_path / "solar.py").write_text("power = 1\n", encoding="utf-8")
    script = tmp_path / "mine.py"
    script.write_text(f"import {package}\n", encoding="utf-8")
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert f"ImportError: {tmp_path / 'solar.py'} hides the package 'solar'" in ran.stderr
