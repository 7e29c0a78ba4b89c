"""Polars of a section and a wing known in closed form, written as XFOIL and XFLR5 write theirs."""

import math

import numpy as np

ANGLES = tuple(float(alpha) for alpha in np.arange(-4.0, 12.01, 1.0))
REYNOLDS = (60e3, 100e3, 200e3, 400e3, 800e3)
# The wing: XFLR5's standard viscosity, and a span efficiency.
CHORD_M, ASPECT_RATIO, VISCOSITY, SPAN_EFFICIENCY = 0.3, 18.0, 1.5e-5, 0.95


def lift(alpha_deg):
    """Lift coefficient, 0.1 per degree with a soft stall that does not depend on Re."""
    return 0.4 + 0.1 * alpha_deg - 2e-5 * max(alpha_deg, 0.0) ** 4


def drag(cl, reynolds):
    """Parabolic drag with a power of the Reynolds number."""
    return (0.008 + 0.004 * (cl - 0.5) ** 2) * (reynolds / 2e5) ** -0.4


def induced(cl):
    """Induced drag of the wing."""
    return cl**2 / (math.pi * ASPECT_RATIO * SPAN_EFFICIENCY)


def section(
    reynolds,
    *,
    program="       XFOIL         Version 6.99",
    name="FORMULA 12",
    kind=1,
    commas=False,
    mach=0.0,
    ncrit=9.0,
    angles=ANGLES,
):
    """Polar of the section; ``reynolds`` is that at C_L = 1 for kind 2."""
    types = {1: "1 1 Reynolds number fixed          Mach number fixed         "}
    types[2] = "2 1 Reynolds number ~ 1/sqrt(CL)   Mach number fixed         "
    lines = [
        "  ",
        program,
        "  ",
        f" Calculated polar for: {name:<40}",
        "  ",
        f" {types[kind]}",
        "  ",
        " xtrf =   1.000 (top)        1.000 (bottom)  ",
        f" Mach = {mach:7.3f}     Re = {reynolds / 1e6:9.3f} e 6     Ncrit = {ncrit:7.3f}",
        "  ",
    ]
    if commas:
        lines.append("alpha,CL,CD,CDp,Cm,Top Xtr,Bot Xtr,Cpmin,Chinge,XCp")
    else:
        lines.append("   alpha    CL        CD       CDp       CM     Top_Xtr  Bot_Xtr")
        lines.append("  ------ -------- --------- --------- -------- -------- --------")
    for alpha in angles:
        cl = lift(alpha)
        if kind == 2 and cl <= 0.0:
            continue
        re = reynolds if kind == 1 else reynolds / math.sqrt(cl)
        cd = drag(cl, re)
        if commas:
            first = f"{alpha:8.3f},{cl:8.4f},{cd:9.6f},{cd / 3:9.6f},{-0.05:8.4f}"
            lines.append(f"{first},  0.6000,  0.9000, -1.5000,  0.0000,  0.2500")
        else:
            first = f"{alpha:8.3f}{cl:9.4f}{cd:10.6f}{cd / 3:10.6f}{-0.05:9.4f}"
            lines.append(f"{first}{0.6:9.4f}{0.9:9.4f}")
    return "\n".join([*lines, "", ""])


def wing(
    speed_m_per_s,
    *,
    word="Wing",
    unit="m/s",
    per_unit=1.0,
    commas=False,
    fixed_lift=False,
    early=False,
    sideslip=False,
    angles=ANGLES,
):
    """Polar of the wing; ``speed_m_per_s`` is that at C_L = 1 for fixed lift."""
    comma = "," if commas else ""
    named = "Wing polar" if word == "Wing" else "Polar"
    speed = speed_m_per_s / per_unit
    lines = [
        "xflr5 v5.02" if early else "xflr5 v6.47",
        "",
        f"{word} name :{comma}        Formula wing",
        f"{named} name :{comma}  {'T2' if fixed_lift else 'T1'}-{speed:.1f} {unit}-LLT",
        "" if fixed_lift else f"Freestream speed :{comma} {speed:7.3f} {unit}",
        "",
    ]
    columns = ["alpha", "CL", "ICd", "PCd", "TCd", "CY", "GCm", "GRm", "GYm", "IYm", "QInf", "XCP"]
    if not early:
        columns = ["alpha", "CL", "CDi", "CDv", "CD", "CY", "Cl", "Cm", "Cn", "Cni", "QInf", "XCP"]
    if sideslip:
        columns.insert(1, "Beta")
    lines.append((", " if commas else "       ").join(columns))
    if early:
        lines.append((",  " if commas else "  ").join(["_________"] * len(columns)))
    for alpha in angles:
        cl = lift(alpha)
        if fixed_lift and cl <= 0.0:
            continue
        at = speed_m_per_s / math.sqrt(cl) if fixed_lift else speed_m_per_s
        viscous = drag(cl, at * CHORD_M / VISCOSITY)
        values = [alpha, cl, induced(cl), viscous, induced(cl) + viscous]
        values += [0.0, 0.0, -0.05, 0.0, 0.0]
        values += [at / per_unit, 0.08]
        if sideslip:
            values.insert(1, 0.0)
        lines.append((",  " if commas else "  ").join(f"{value:9.6f}" for value in values))
    return "\n".join([*lines, "", ""])
