"""Solving the program: IPOPT from a simulated start, and what its solution says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sizing.program.transcription import INTERVALS, BlockData, Program
from solar.types import FloatArray

PRICE = 100.0
IPOPT: dict[str, Any] = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    "calc_lam_p": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-7,
    "ipopt.acceptable_tol": 1e-5,
    "ipopt.max_iter": 100,
    "ipopt.mu_strategy": "adaptive",
    "ipopt.mu_max": 1e-3,
}
ELASTIC = IPOPT | {"ipopt.max_iter": 300, "ipopt.mu_max": 1e-1}


@dataclass(frozen=True)
class Solution:
    program: Program
    x: FloatArray
    cost: float
    lam_x: FloatArray
    lam_g: FloatArray
    converged: bool
    iterations: int
    status: str

    def part(self, name: str) -> FloatArray:
        return self.x[self.program.parts[name]]

    @property
    def lack(self) -> float:
        return float(max(self.part("missed").max(initial=0.0), self.part("lack").max(initial=0.0)))


def solve(
    program: Program,
    *,
    parameters: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    start: FloatArray,
    elastic: bool,
) -> Solution:
    low, high = (np.array(one) for one in bounds)
    equation = np.array([c.equation for c in program.constraints])
    if not elastic:
        for part in ("missed", "lack"):
            high[program.parts[part]] = 0.0
    solver = program.solver("elastic" if elastic else "firm", ELASTIC if elastic else IPOPT)
    answer = solver(
        x0=np.clip(start, low, high),
        lbx=low,
        ubx=high,
        lbg=np.zeros(len(equation)),
        ubg=np.where(equation, 0.0, np.inf),
        p=parameters,
    )
    stats = solver.stats()
    return Solution(
        program,
        np.asarray(answer["x"]).ravel(),
        float(answer["f"]),
        np.asarray(answer["lam_x"]).ravel(),
        np.asarray(answer["lam_g"]).ravel(),
        bool(stats["success"]),
        int(stats["iter_count"]),
        str(stats["return_status"]),
    )
