"""The step `group`: base inertial parameters by rules, cross-checked with numbers, or by numbers; machines of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from symoro_elastic.foundation.errors import some_of
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.constants import with_constants
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.parameters.base_parameters import (
    Grouping,
    Label,
    ZeroPosition,
    base_grouping,
    numeric_grouping,
)
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear.rank import CrossCheck, cross_check, numerical_relations

NOTE = "inertial parameters grouped by QR, for this geometry only"
SAME, ROUNDING = 1e-9, 1e-13
MOST_NAMED = 6
UNTIL_THEN = "; until then the grouping by the rules is used"
FRESH = 1
"""Seed of the states that check relations; the relations are computed at the states of seed 0."""


def checked_grouping(machine: Machine) -> tuple[Grouping, CrossCheck]:
    """The grouping to use, and its comparison with the numerical rank of the regressor.

    That of the rules or, where numbers contradict them or couplings and loops group more, the one found by QR: it
    holds for one geometry, whose parameters are constants in the regrouped machine. Without their values that of the
    rules comes back, refused in a tree without couplings.
    """
    grouping = base_grouping(machine)
    check = cross_check(machine, grouping)
    return (grouping, check) if check.agrees else _by_numbers(machine, grouping, check)


def grouping_by_rank(machine: Machine) -> Grouping:
    """Return the grouping with as many base parameters as the regressor's rank; raises `InputError` without one."""
    grouping, check = checked_grouping(machine)
    if check.refused or check.rank not in (None, grouping.count):
        raise machine.error("base_parameters", check.message.removesuffix(UNTIL_THEN))
    return grouping


def base_machine(machine: Machine) -> tuple[DescribedMachine, tuple[str, ...]]:
    """Return the machine with base inertial parameters (fewer operations, the same torques), and warnings, a line each.

    Raises `InputError` where the rules and the rank of the regressor disagree and values are missing for another
    grouping.
    """
    grouping, check = checked_grouping(machine)
    if check.refused:
        raise machine.error("--base", check.message)
    return DescribedMachine.of(grouping.machine), () if check.agrees else (f"{machine.label}: --base: {check.message}",)


def base_formulas(grouping: Grouping, check: CrossCheck) -> dict[str, str]:
    """Formulas of the base inertial parameters; empty if no grouping can be used."""
    return {} if check.refused else dict(grouping.formulas)


@dataclass(frozen=True)
class BaseParameters:
    """Formulas of the base inertial parameters and of the sums they share, how they were checked, and conditioning.

    `zero` labels the base parameters that are zero for the bodies of this machine. `condition` is the condition of
    the base regressor at random states, None without a number.
    """

    formulas: dict[str, str]
    parts: dict[str, str]
    zero: list[str]
    check: str
    condition: float | None
    conditioning: str


def base_parameters(machine: Machine) -> BaseParameters:
    """The base inertial parameters of a machine, how they were checked, and their conditioning."""
    if machine.degrees_of_base:
        return BaseParameters({}, {}, [], "not offered on a floating base", None, "")
    if machine.flexible:
        return BaseParameters({}, {}, [], "not offered for bodies that bend by modes", None, "")
    grouping, check = checked_grouping(machine)
    formulas = base_formulas(grouping, check)
    parts = {name: text for name, text in formulas.items() if name in grouping.composites}
    own = {name: text for name, text in formulas.items() if name not in parts}
    zero = [] if check.refused else grouping.zero
    condition = check.conditioning.condition if check.conditioning else None
    return BaseParameters(own, parts, zero, check.message, condition, conditioning_text(check))


def conditioning_text(check: CrossCheck) -> str:
    """Conditioning of the base regressor at random states, and the parameters hardest to identify."""
    figures = check.conditioning
    if figures is None:
        return "no condition number of the base regressor: it is computed where the rank is"
    if not figures.distinct:
        return "no base inertial parameter to identify"
    weakest = ", ".join(f"{name} ({part:.2g})" for name, part in list(figures.distinct.items())[:5])
    return (
        f"condition number of the base regressor at random states {figures.condition:.3g}; "
        f"hardest to tell apart (1 is easy, 0 impossible): {weakest}"
    )


def _by_numbers(machine: Machine, rules: Grouping, check: CrossCheck) -> tuple[Grouping, CrossCheck]:
    """Return the grouping by QR that differs least from the grouping by the rules."""
    geometry = ZeroPosition(machine).geometry
    missing = [p.name for p in machine.parameters if p.name in geometry and p.value is None]
    if missing:
        what = f"the QR grouping holds for one geometry only: give values to {some_of(missing, MOST_NAMED)}"
        usable = machine.is_coupled and check.torques_stay
        what += UNTIL_THEN if usable else ""
        return rules, replace(check, doubt=f"{check.doubt}; {what}", refused=not usable)
    fixed = with_constants(machine, geometry)
    fixed = DescribedMachine.of(fixed).with_notes(NOTE)
    grouping = numeric_grouping(fixed, numerical_relations(fixed, rules.kept))
    fresh = cross_check(fixed, grouping, FRESH)
    if not fresh.torques_stay:
        what = f"the QR grouping changes torques by {fresh.torque_error:.2g}"
        what += ", so the grouping by the rules is used" if check.torques_stay else ", write or generate without --base"
        return rules, replace(check, doubt=f"{check.doubt}; {what}", refused=not check.torques_stay)
    what = "the QR grouping is used, which holds for this geometry only"
    what += f" ({some_of(geometry, MOST_NAMED)} became constants)" if geometry else ""
    grouping = replace(grouping, geometry=tuple(geometry))
    what += f"; it differs in {_differences(machine, rules, grouping)}"
    return grouping, replace(fresh, doubt=f"{check.doubt}; {what}")


def _differences(machine: Machine, rules: Grouping, found: Grouping) -> str:
    """Return the parameters, by joint, that only one of two groupings keeps, else those with different sums."""
    labels = sorted({*rules.kept} ^ {*found.kept}) or _other_sums(_values(machine, rules), _values(machine, found))
    by_joint: dict[int, list[str]] = {}
    for j, entry in labels:
        by_joint.setdefault(j, []).append(entry)
    named = [f"{place_of(j, machine.joint(j))} {' '.join(entries)}" for j, entries in by_joint.items()]
    return some_of(named, MOST_NAMED)


def _other_sums(one: Mapping[Label, float], other: Mapping[Label, float]) -> list[Label]:
    rounding = ROUNDING * max(map(abs, (*one.values(), *other.values())), default=0.0)
    pairs = {label: (one.get(label, 0.0), other.get(label, 0.0)) for label in sorted({*one, *other})}
    return [label for label, (a, b) in pairs.items() if not math.isclose(a, b, rel_tol=SAME, abs_tol=rounding)]


def _values(machine: Machine, grouping: Grouping) -> dict[Label, float]:
    values = grouping.values(parameter_values(machine))
    return {(p.joint, p.entry): values[p.name] for p in grouping.parameters if p.name in values}
