"""What the structure of an airframe is sized from."""

from __future__ import annotations

from typing import NamedTuple

from sizing.smooth import Value


class StructureInputs(NamedTuple):
    """Wing, masses and flight that a model of the structure is asked about.

    Attributes
    ----------
    wingspan_m, aspect_ratio
        Span [m] and aspect ratio [-] of the wing.
    total_mass_kg
        Take-off mass [kg].
    span_load_kg
        Mass spread evenly along the span, battery and modules, which relieves the spar [kg].
    airspeed_m_per_s, density_kg_per_m3
        True airspeed of level flight [m/s], taken as cruise, and density of the air [kg/m3].
    """

    wingspan_m: Value
    aspect_ratio: Value
    total_mass_kg: Value
    span_load_kg: Value
    airspeed_m_per_s: Value
    density_kg_per_m3: Value
