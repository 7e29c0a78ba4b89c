"""Balance and drag of an aircraft by its parts, in words."""

from __future__ import annotations

from typing import Any

from sizing.balance.assessment import BalanceAssessment
from sizing.balance.drag import DragShares
from sizing.results.tables import Column, Line, Table

__all__ = ["balance_blocks", "balance_lines", "balance_table", "drag_record", "drag_table"]

_DRAG_WORDS = {
    "wing_profile": "wing, profile",
    "wing_induced": "wing, induced",
    "horizontal_tail": "horizontal tail",
    "vertical_tail": "vertical tail",
    "gaps": "gaps, leaks, protuberances",
    "other": "constants of the file",
}
_MASS_WORDS = {"mppt": "MPPT", "spar_caps": "spar caps", "spar_web": "spar web"}
_CLOSE = 0.01  # what a weighed list and the mass budget may differ by without a note


def balance_blocks(shares: DragShares | None, balance: BalanceAssessment | None) -> list[Any]:
    """Tables and lines of an analysis; none where the file has no such keys."""
    blocks: list[Any] = []
    if shares is not None:
        blocks += [drag_table(shares), Line(_parasitic(shares))]
    if balance is not None:
        blocks.append(balance_table(balance))
        blocks += [Line(text) for text in balance_lines(balance)]
    return blocks


def drag_table(shares: DragShares) -> Table:
    """Drag of the parts of level flight, with their shares."""
    columns = (
        Column("part"),
        Column("coefficient", "C_D on the wing area", form=".5f"),
        Column("share", "share", "%", ".1f"),
    )
    rows = [
        (_DRAG_WORDS.get(name, name), float(one), 100.0 * float(one / shares.total))
        for name, one in (*shares._asdict().items(), ("sum", shares.total))
        if one != 0.0
    ]
    return Table("drag budget of level flight", columns, tuple(rows))


def _parasitic(shares: DragShares) -> str:
    share = 100.0 * float(shares.parasitic / shares.total)
    return (
        f"Parasitic drag, all but the wing and the trim: C_D {float(shares.parasitic):.5f}, "
        f"{share:.1f} % of the drag."
    )


def drag_record(shares: DragShares) -> dict[str, float]:
    """Drag coefficients of the parts, JSON-ready, and their sums."""
    parts = {name: float(one) for name, one in shares._asdict().items()}
    return parts | {"parasitic": float(shares.parasitic), "total": float(shares.total)}


def balance_table(balance: BalanceAssessment) -> Table:
    """Masses with their places."""
    columns = (
        Column("item"),
        Column("mass", "mass", "kg", ".3f"),
        Column("place", "behind leading edge", "m", ".3f"),
    )
    rows = [(_MASS_WORDS.get(one.name, one.name), one.mass_kg, one.x_m) for one in balance.items]
    rows.append(("centre of gravity", balance.mass_kg, balance.gravity_m))
    return Table("balance, from the leading edge of the wing root", columns, tuple(rows))


def balance_lines(balance: BalanceAssessment) -> list[str]:
    """Static margin, tail, trim and controls in sentences."""
    tail, level, out = balance.planes, balance.level, balance.motor_out
    stable = "stable" if balance.static_margin > 0.0 else "unstable"
    lines = [
        f"Static margin {100.0 * balance.static_margin:.1f} % of the mean aerodynamic chord "
        f"({stable}): centre of gravity at {100.0 * balance.in_chord(balance.gravity_m):.1f} %, "
        f"neutral point at {100.0 * balance.in_chord(balance.found.x_m):.1f} % of "
        f"{balance.wing.aerodynamic_chord_m:.3f} m.",
        f"Tail planes of {tail.horizontal_m2:.3f} and {tail.vertical_m2:.3f} m², "
        f"{tail.arm_m:.2f} m behind the wing; trimmed C_L {level.wing_lift:.3f} of the wing and "
        f"{level.tail_lift:.3f} of the tail, trim drag {level.drag:+.5f} "
        f"({100.0 * level.drag / balance.drag_coefficient:+.1f} % of the drag).",
        f"Elevator, trailing edge up positive, of {balance.elevator_limit_deg:g}°: "
        f"{-balance.elevator_deg:+.1f}° trims 1.2 times the stall speed, "
        f"{-balance.elevator_at_stall_deg:+.1f}° the stall. Rudder at 1.2 times the stall speed: "
        f"{balance.sideslip_deg:.0f}° of sideslip, {balance.crosswind_m_per_s:.1f} m/s of crosswind"
        + ("." if out is None else f"; one motor out needs {100.0 * out:.0f} % of it."),
    ]
    if (moved := balance.moved) is not None:
        where = f"{abs(moved.x_m):.3f} m {'behind' if moved.x_m >= 0.0 else 'ahead of'}"
        lines[0] += f" For it {moved.mass_kg:.3f} kg ({moved.name}) lie {where} the leading edge."
    if balance.sized_volume is not None:
        lines[0] += (
            f" For it the horizontal tail has a volume coefficient of {balance.sized_volume:.3f}."
        )
    off = balance.mass_kg / balance.design_mass_kg - 1.0
    if abs(off) > _CLOSE:
        lines.append(
            f"The weighed masses add up to {balance.mass_kg:.3f} kg, {100.0 * off:+.1f} % off the "
            f"mass budget of {balance.design_mass_kg:.3f} kg."
        )
    return lines
