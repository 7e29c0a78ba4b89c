"""Settings of all tests."""

from __future__ import annotations

import os

from hypothesis import settings

# The same examples every time, so that a change is judged and not the dice; without a deadline,
# because a busy machine is no fault. HYPOTHESIS_PROFILE=explore tries other examples, and more.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", max_examples=500, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
