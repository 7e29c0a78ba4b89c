import re

import pytest

from solar._version import __version__
from solar.versions import FORMAT_VERSION, format_trouble, software_record

NEWER = rf"must be at most {FORMAT_VERSION} \(got \d{{1,60}}\): .*"
NEWER += rf"than this one, {re.escape(__version__)}; install a newer one"


@pytest.mark.parametrize(
    ("told", "trouble"),
    [
        *((known, None) for known in range(1, FORMAT_VERSION + 1)),
        *((newer, NEWER) for newer in (FORMAT_VERSION + 1, 10**400)),
        *((x, r"must be .*\(got .{1,60}\)") for x in (0, -1, True, 1.0, "1", None, [1], "x" * 999)),
    ],
)
def test_formats_are_known_or_refused_in_words(told, trouble):
    found = format_trouble(told)
    assert found is None if trouble is None else re.fullmatch(trouble, found)


def test_results_say_what_made_them():
    assert software_record() == {"version": __version__, "format_version": FORMAT_VERSION}
