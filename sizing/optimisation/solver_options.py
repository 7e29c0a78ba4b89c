"""How the solvers of CasADi are set for a sizing, by the effort that is made."""

from __future__ import annotations

from typing import Any, Literal

Effort = Literal["quick", "still", "steady", "next", "direct"]

TOLERANCE = 1e-8  # of the interior-point method, in the program

_COMMON_OPTIONS = {
    "print_time": False,
    "show_eval_warnings": False,
    "error_on_fail": False,
    # Multipliers of parameters are found only on request: sizing.optimisation.sensitivity.
    "calc_lam_p": False,
    "no_nlp_grad": True,
}

_IPOPT_OPTIONS: dict[str, Any] = _COMMON_OPTIONS | {
    "ipopt.hessian_approximation": "limited-memory",
    "ipopt.mu_strategy": "monotone",
    "ipopt.max_iter": 120,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": TOLERANCE,
    "ipopt.acceptable_tol": 1e-6,
    "ipopt.acceptable_iter": 8,
    # One factorisation of the low-rank Hessian bordered, instead of many solves with its inverse.
    "ipopt.limited_memory_aug_solver": "extended",
}

# Where a requirement may be missed, at a cost, that cost is known once it stands still: at a kink
# steps would go to and fro up to their limit.
_STILL_OPTIONS: dict[str, Any] = _IPOPT_OPTIONS | {
    "ipopt.acceptable_tol": 1e10,
    "ipopt.acceptable_iter": 15,
    "ipopt.acceptable_obj_change_tol": 3e-5,
    "ipopt.acceptable_constr_viol_tol": 1e-3,
    "ipopt.acceptable_compl_inf_tol": 1e-3,
    "ipopt.acceptable_dual_inf_tol": 1e20,
}

# Sequential quadratic programming, for the next one of a row of similar problems.
_SQP_OPTIONS: dict[str, Any] = _COMMON_OPTIONS | {
    "print_header": False,
    "print_iteration": False,
    "print_status": False,
    "qpsol": "qrqp",
    "qpsol_options": {
        "print_iter": False,
        "print_header": False,
        "print_info": False,
        "error_on_fail": False,
        # Where the active set has not settled by then it cycles, up to the default of 1000.
        "max_iter": 100,
    },
    "hessian_approximation": "limited-memory",
    "max_iter": 80,
    "tol_du": 1e-6,
    "tol_pr": 1e-7,
}

# The same for a program without a neighbour, from a design that need not be near: whole steps, and
# few of them. Where they lead to no solution they seldom would later, and interior points follow.
_DIRECT_OPTIONS: dict[str, Any] = _SQP_OPTIONS | {
    "qpsol_options": _SQP_OPTIONS["qpsol_options"] | {"max_iter": 40},
    "lbfgs_memory": 80,
    "max_iter_ls": 0,
    "max_iter": 20,
    "tol_pr": 1e-9,
}
OPTIONS: dict[Effort, dict[str, Any]] = {
    "quick": _IPOPT_OPTIONS,
    "still": _STILL_OPTIONS,
    "steady": _IPOPT_OPTIONS | {"ipopt.hessian_approximation": "exact", "ipopt.max_iter": 300},
    "next": _SQP_OPTIONS,
    "direct": _DIRECT_OPTIONS,
}
