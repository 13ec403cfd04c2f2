"""The step `group`: a machine with base inertial parameters only, cross-checked with numbers."""

from __future__ import annotations

from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.base_parameters import Grouping, grouped
from symoro_elastic.numerics.rank import CrossCheck, cross_check


def checked_grouping(machine: Machine) -> tuple[Grouping, CrossCheck]:
    """The grouping by the rules, and what the numerical rank of the regressor says of it."""
    grouping = grouped(machine)
    return grouping, cross_check(machine, grouping)


def base_machine(machine: Machine) -> Machine:
    """The machine with base inertial parameters: fewer operations, the same torques.

    Raises `InputError` where the rules and the rank of the regressor disagree.
    """
    grouping, check = checked_grouping(machine)
    if not check.agrees:
        what = f"{check.message}; generate without --base, and identify with the base regressor instead"
        raise InputError(machine.source or machine.name, "--base", what)
    return grouping.machine


def base_formulas(grouping: Grouping, check: CrossCheck) -> dict[str, str]:
    """Formulas of the base inertial parameters: those of the rules or, where they fail, of QR."""
    return dict(grouping.formulas if check.numerical is None else check.numerical.formulas)


def conditioning_text(check: CrossCheck) -> str:
    """How well random motion tells the base parameters apart, and which ones it tells worst."""
    found = check.conditioning
    if not found.distinct:
        return "no base inertial parameter to identify"
    weakest = ", ".join(f"{name} ({part:.2g})" for name, part in list(found.distinct.items())[:5])
    return (
        f"condition number of the base regressor at random states {found.condition:.3g}; "
        f"hardest to tell apart (1 is easy, 0 impossible): {weakest}"
    )
