"""Core between the facings of a spar's web: what holds a deep web against buckling."""

from __future__ import annotations

from math import pi

from sizing.smooth import Value, smooth_maximum
from solar.schema import NonNegativeReal, PositiveReal, Record

# Buckling of a long plate in shear, simply supported (Timoshenko & Gere, section 9.7).
SHEAR_PLATE = 5.35


class WebCore(Record):
    """Foam between two facings, each half of the laminate of the web.

    The facings carry the shear, the core keeps them apart. docs/structure.md names source or
    assumption key by key.
    """

    density_kg_per_m3: PositiveReal = 52.0
    shear_modulus_pa: PositiveReal = 19e6
    minimum_thickness_m: PositiveReal = 2e-3
    bond_kg_per_m2: NonNegativeReal = 0.1

    def kg_per_m2(
        self, shear_n_per_m: Value, facings_m: Value, depth_m: Value, modulus_pa: Value
    ) -> Value:
        """Core and its two bonds for the web's area [kg/m2].

        The plate's bending stiffness is that of its facings, ``D = E t d^2/(4 (1 - nu^2))`` with
        both of them t and the core d thick. With the shear of the core the plate buckles at
        ``1/(1/N_b + 1/(G d))``, ``N_b = 5.35 pi^2 D/h^2`` (Allen, Analysis and Design of Structural
        Sandwich Panels, chapters 2 and 5: the two stiffnesses in series); solved for d.

        Parameters
        ----------
        shear_n_per_m
            Ultimate shear flow of one web, as its force over its depth [N/m].
        facings_m
            Thickness of both facings together [m].
        depth_m
            Of the web [m].
        modulus_pa
            Of the laminate [Pa].

        Returns
        -------
        Value
        """
        per_thickness = SHEAR_PLATE * pi**2 * modulus_pa * facings_m / (4.0 * (1.0 - 0.3**2))
        bending_m2 = shear_n_per_m * depth_m * depth_m / per_thickness
        shear_m = shear_n_per_m / self.shear_modulus_pa
        needed_m = (shear_m + (shear_m * shear_m + 4.0 * bending_m2) ** 0.5) / 2.0
        thickness_m = smooth_maximum(needed_m, self.minimum_thickness_m)
        return self.density_kg_per_m3 * thickness_m + 2.0 * self.bond_kg_per_m2
