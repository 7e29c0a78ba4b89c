"""What is said where OpenMDAO is missing."""

import pytest
from builders import DESIGN, mission

from studies.exchange import openmdao_component


def test_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(openmdao_component, "find_spec", lambda _: None)
    with pytest.raises(ImportError, match=r"needs OpenMDAO: .* 'openmdao'"):
        openmdao_component.to_openmdao(DESIGN, mission())
