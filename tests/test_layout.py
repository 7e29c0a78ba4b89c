"""The folders of the tests are those of the packages, so that the tests of a module are found."""

from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parent
# Without a package: tests of the documentation, and what the tests share.
OTHERS = ("documentation", "support")
FOLDERS = sorted({path.parent.relative_to(TESTS) for path in TESTS.rglob("test_*.py")})


@pytest.mark.parametrize("folder", FOLDERS, ids=str)
def test_folder_of_tests_is_that_of_a_package(folder):
    if folder.parts and folder.parts[0] not in OTHERS:
        assert (TESTS.parent / folder / "__init__.py").exists()
