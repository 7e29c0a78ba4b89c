"""Structural mass of the airframe: wing, tails and fuselage without systems.

The formulas use arithmetic only, so that floats, arrays and symbolic expressions pass alike.
"""

from __future__ import annotations

from typing import Annotated, Literal, Protocol

from pydantic import AfterValidator, Field

from sizing.own_models import structure_function
from sizing.smooth import Value
from sizing.structures.loads import StructureInputs
from sizing.structures.rib_wing import RibWingStructure
from sizing.structures.spar import SparStructure
from solar.schema import PositiveReal, Real, Record, Text


class StructureModel(Protocol):
    """Interface of a model of the structure to the mass budget."""

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Structural mass [kg]."""
        ...


class _PowerLaw(Record):
    """Airframe mass as a power law, ``m = k b^x AR^y``."""

    coefficient_kg: PositiveReal
    span_exponent: Real
    aspect_ratio_exponent: Real

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Structural mass [kg]; the masses it carries and how it flies play no part."""
        return (
            self.coefficient_kg
            * inputs.wingspan_m**self.span_exponent
            * inputs.aspect_ratio**self.aspect_ratio_exponent
        )


class PowerLawStructure(_PowerLaw):
    """Airframe mass as a power law of wingspan and aspect ratio.

    ``m = coefficient_kg b^span_exponent AR^aspect_ratio_exponent``. The defaults are the airframe
    law used for Sky-Sailor, which is that of the best 5 % of the sailplanes in a statistic: Noth,
    A. (2008), Design of Solar Powered Airplanes for Continuous Flight, ETH Zurich: weight
    0.44 S^1.55 AR^1.30 = 0.44 b^3.1 AR^-0.25 in newton. It is far too heavy above 4 m of span.
    """

    model: Literal["power_law"] = "power_law"
    coefficient_kg: PositiveReal = 0.44 / 9.81
    span_exponent: Real = 3.1
    aspect_ratio_exponent: Real = -0.25


class AllPowerLawStructure(_PowerLaw):
    """The power law of all 415 sailplanes of the same statistic.

    Noth (2008): weight 5.58 S^1.59 AR^0.71 = 5.58 b^3.18 AR^-0.88 in newton. Far too heavy for
    solar aircraft; for comparison.
    """

    model: Literal["power_law_all"]
    coefficient_kg: PositiveReal = 5.58 / 9.81
    span_exponent: Real = 3.18
    aspect_ratio_exponent: Real = -0.88


class OwnStructure(Record):
    """A model of the user's own, by its name: see :func:`sizing.register_structure`."""

    model: Literal["own"]
    name: Annotated[Text, AfterValidator(lambda name: structure_function(name) and name)]

    def mass_kg(self, inputs: StructureInputs) -> Value:
        """Structural mass [kg]."""
        return structure_function(self.name)(inputs)


Structure = Annotated[
    PowerLawStructure | AllPowerLawStructure | SparStructure | RibWingStructure | OwnStructure,
    Field(discriminator="model"),
]
