"""Angles written as rounded decimals of parts of a turn: 1.57079632679 for pi/2."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import replace
from fractions import Fraction

from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula, terms

TWELFTH = math.pi / 12
DECIMALS = 1e-9
"""Largest error, rad, of a decimal of ten digits: what SYMORO and tables of robots write."""
ANGLES = ("gamma", "alpha", "theta")
_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_PLACE = "_angle_"


def multiple_of_pi(half_turns: Fraction) -> str:
    """Return the text of an angle in half turns: `-pi/2`, `7*pi/6`, `0`."""
    if half_turns == 0:
        return "0"
    sign, above = "-" if half_turns < 0 else "", abs(half_turns.numerator)
    below = f"/{half_turns.denominator}" if half_turns.denominator > 1 else ""
    return f"{sign}pi{below}" if above == 1 else f"{sign}{above}*pi{below}"


def nearest_part(angle: float, tolerance: float = DECIMALS) -> Fraction | None:
    """Return half turns as a multiple of 1/12, for an inexact angle within a tolerance of it."""
    parts = round(angle / TWELFTH)
    exact = parts * math.pi / 12
    return Fraction(parts, 12) if parts and math.ulp(exact) < abs(angle - exact) <= tolerance else None


def part_of_turn(angle: float) -> float:
    """Return the multiple of pi/12 that a decimal angle, rad, abbreviates, else the angle."""
    half_turns = nearest_part(angle)
    return angle if half_turns is None else float(half_turns) * math.pi


def remark_on(errors: Collection[float]) -> str:
    """Return a line about angles that were rounded by these errors, rad."""
    count = "1 angle is" if len(errors) == 1 else f"{len(errors)} angles are"
    return f"{count} read as multiples of pi/12, off which rounding left them by {max(errors):.2g} rad at most"


def with_exact_angles(machine: DescribedMachine, tolerance: float = DECIMALS) -> DescribedMachine:
    """Return the machine with multiples of pi/12 for angles within a tolerance, rad, of them; a remark counts them."""
    errors: list[float] = []

    def exact(cell: Cell, formula: Formula) -> Formula:
        while cell.column.key in (*ANGLES, "rpy") and (part := _part_in(formula, tolerance)):
            formula, error = part
            errors.append(error)
        return formula

    joints = tuple(with_cells(joint, exact) for joint in machine.joints)
    frames = tuple(with_cells(frame, exact) for frame in machine.frames)
    return replace(machine, joints=joints, frames=frames).with_remarks(remark_on(errors)) if errors else machine


def _part_in(formula: Formula, tolerance: float) -> tuple[Formula, float] | None:
    """Return the formula with a multiple of pi in place of a number added in it, and the change."""
    for match in _NUMBER.finditer(formula.text):
        half_turns = nearest_part(float(match[0]), tolerance)
        before, after = formula.text[: match.start()], formula.text[match.end() :]
        if half_turns and ("name", _PLACE) in terms(Formula.parse(f"{before}{_PLACE}{after}").tree):
            text = f"{before}{multiple_of_pi(half_turns)}{after}"
            return Formula.parse(text), abs(float(match[0]) - float(half_turns) * math.pi)
    return None
