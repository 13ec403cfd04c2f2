"""Named numbers of a machine, with meaning and unit: cells of its table, and quantities that turn out constant."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from symoro_elastic.codegen.package import Constant
from symoro_elastic.machine.formula import FUNCTIONS, Formula, FormulaError
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.program import NamedConstant

DERIVED = {
    "MS": "first moment",
    "J": "inertia",
    "dJ": "difference of inertias",
    "M": "mass",
    "Js": "articulated inertia",
    "K": "articulated inertia",
    "H": "inertia moved",
    "Hinv": "inverse of the inertia moved",
    "UH": "articulated inertia over the inertia moved",
    "rho": "share of the rotor in the inertia moved",
    "P": "position of its origin",
}
"""Quantities of the equations that may be constant, by the letters of their names."""
STRUCTURAL = (0, 1, 2, Fraction(1, 2))
"""Numbers that belong to the equations; those of a machine that are equal to them are not told apart."""
_NAME = re.compile(r"(?P<letters>[A-Za-z]+)\d+(?P<composite>_c)?_?(?P<component>\w*)", re.ASCII)


def constants_of(machine: Machine, traced: TracedModel, folded: Sequence[str]) -> tuple[Constant, ...]:
    """Return the named numbers of a model, those of the machine's table first.

    A cell that is nothing but a folded parameter has the parameter's name.
    """
    values = _values(machine, folded)
    found = [*_of_base(machine, values)]
    for j, joint in enumerate(machine.joints, start=1):
        found += _of_joint(j, joint, values)
    found += [c for known in traced.program.named_constants for c in _derived(machine, known)]
    return tuple(c for c in found if isinstance(c.value, Expression) or abs(c.value) not in STRUCTURAL)


def _values(machine: Machine, folded: Sequence[str]) -> dict[str, Fraction]:
    given = {p.name: p.value for p in machine.parameters if p.name in folded and p.value is not None}
    exact = {name: _exact(formula, {}) for name, formula in given.items()}
    return {name: value for name, value in exact.items() if value is not None}


def _exact(formula: Formula, values: Mapping[str, Fraction]) -> Fraction | None:
    """Return the rational number of a cell; None where it is none."""
    names: dict[str, Any] = dict(values)
    try:
        value = formula.evaluate(names, dict.fromkeys(FUNCTIONS, _irrational), Fraction)
    except (ArithmeticError, FormulaError, KeyError, ValueError):
        return None
    return Fraction(value) if isinstance(value, int | Fraction) else None


def _irrational(*_: object) -> None:
    raise ValueError


def _of_base(machine: Machine, values: Mapping[str, Fraction]) -> Iterator[Constant]:
    for axis, formula in zip("xyz", machine.base.gravity, strict=True):
        yield from _cell(f"gravity_{axis}", formula, values, None, f"gravity along {axis}0, magnitude", "m/s2", abs)


def _of_joint(j: int, joint: Joint, values: Mapping[str, Fraction]) -> Iterator[Constant]:
    slides = joint.sigma == 1
    force, angle = ("N", "m") if slides else ("N m", "rad")
    inertia = "kg" if slides else "kg m2"
    rows = (
        ("k", joint.spring.stiffness, "stiffness", f"{force}/{angle}"),
        ("h", joint.spring.damping, "damping", f"{force} s/{angle}"),
        ("n", joint.spring.neutral, "neutral position", angle),
        ("Fv", joint.friction.viscous, "viscous friction", f"{force} s/{angle}"),
        ("Fs", joint.friction.coulomb, "Coulomb friction", force),
        ("vs", joint.friction.creep, "creep velocity of dry friction", f"{angle}/s"),
        ("Ia", joint.rotor_inertia, "rotor inertia", inertia),
        ("b", joint.b, "length b", "m"),
        ("d", joint.d, "length d", "m"),
        ("r", joint.r, "length r", "m"),
        ("M", joint.body.mass, "mass", "kg"),
    )
    for letters, formula, meaning, unit in rows:
        yield from _cell(f"{letters}{j}", formula, values, j, meaning, unit)


def _cell(
    name: str,
    formula: Formula,
    values: Mapping[str, Fraction],
    joint: int | None,
    meaning: str,
    unit: str,
    sign: Callable[[Fraction], Fraction] = Fraction,
) -> Iterator[Constant]:
    value = _exact(formula, values)
    if value is not None:
        named = str(formula.tree[1]) if formula.tree[0] == "name" else name
        yield Constant(named, sign(value), joint, meaning, unit)


def _derived(machine: Machine, constant: NamedConstant) -> Iterator[Constant]:
    """A quantity of the equations, where this module knows what it means."""
    joint, name = constant.label.section.joint, constant.label.name
    found = _NAME.fullmatch(name)
    if not found or not joint or joint > len(machine.joints) or found["letters"] not in DERIVED:
        return
    letters, component = found["letters"], found["component"]
    words = [DERIVED[letters]]
    words += [component.upper()] if letters in ("MS", "J") and component else []
    words += ["with all it carries"] if found["composite"] else []
    yield Constant(name, constant.value, joint, " ".join(words), _unit(letters, component, machine.joints[joint - 1]))


def _unit(letters: str, component: str, joint: Joint) -> str:
    inertia = "kg" if joint.sigma == 1 else "kg m2"
    if letters in ("Js", "K") and component.isdigit():
        return ("kg", "kg m", "kg m2")[sum(int(digit) > 3 for digit in component)]
    if letters == "UH" and component.isdigit():
        along = {(True, False): "", (True, True): "m", (False, False): "1/m", (False, True): ""}
        return along[joint.sigma == 1, int(component) > 3]
    units = {"MS": "kg m", "J": "kg m2", "dJ": "kg m2", "M": "kg", "H": inertia, "P": "m", "rho": ""}
    return units.get(letters, f"1/{inertia}" if inertia == "kg" else "1/(kg m2)")
