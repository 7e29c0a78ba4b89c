import re

import pytest

from solar._version import __version__
from solar.versions import FORMAT_VERSION, format_trouble, software_record


@pytest.mark.parametrize("known", range(1, FORMAT_VERSION + 1))
def test_every_format_up_to_the_own_is_read(known):
    assert format_trouble(known) is None


@pytest.mark.parametrize("newer", [FORMAT_VERSION + 1, 10**400])
def test_a_newer_format_is_refused_with_what_to_do(newer):
    trouble = format_trouble(newer)
    assert trouble.startswith(f"must be at most {FORMAT_VERSION} (got {str(newer)[:60]}): ")
    assert trouble.endswith(f"than this one, {__version__}; install a newer one")


@pytest.mark.parametrize("wrong", [0, -1, True, 1.0, "1", None, [1], "x" * 999])
def test_what_is_no_format_is_refused_with_what_is_allowed(wrong):
    trouble = format_trouble(wrong)
    assert re.fullmatch(r"must be .*\(got .{1,60}\)", trouble)


def test_results_say_what_made_them():
    assert software_record() == {"version": __version__, "format_version": FORMAT_VERSION}
