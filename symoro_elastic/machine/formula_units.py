"""Units of formulas, by the units of parameters and joint variables: which parts do not fit.

A parameter without a unit, or with one that is not known, may have any, and so may a number such as 0.05: it may be a
radius in m. Whole numbers and pi are taken as ratios. The rad is a unit of its own that counts as a number beside
others: an arc is a radius times an angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from symoro_elastic.machine.formula import Formula, Tree, text_of
from symoro_elastic.machine.names import quote
from symoro_elastic.quantities import units
from symoro_elastic.quantities.units import Powers, product

ANGLE: Powers = {"rad": Fraction(1)}
LENGTH: Powers = {"m": Fraction(1)}


@dataclass(frozen=True)
class Measure:
    """Unit of a part of a formula: whole numbers or pi are factors where `counted`, all of it where `bare`."""

    powers: Powers
    counted: bool = False
    bare: bool = False


COUNT = Measure({}, counted=True, bare=True)


@dataclass(frozen=True)
class Mismatch:
    """A part of a formula whose unit is not the one needed there.

    `is_mixed` where the formula contradicts itself, whatever it gives: in a sum, in the sine of a length.
    """

    part: Tree
    found: Measure
    needed: Powers
    within: str
    is_mixed: bool
    is_in_function: bool = False

    @property
    def is_of_angles(self) -> bool:
        """Whether only the power of rad is wrong, which changes no number."""
        return fits(self.found.powers, self.needed)

    @property
    def is_radius_missing(self) -> bool:
        """Whether an angle is added to a length, or a length to an angle."""
        pair = (self.found.powers, self.needed)
        return not self.is_in_function and pair in ((ANGLE, LENGTH), (LENGTH, ANGLE))

    @property
    def message(self) -> str:
        """What is wrong, and the way out."""
        part = text_of(self.part)
        if self.is_radius_missing:
            one, other = ("a length", "an angle") if self.needed == ANGLE else ("an angle", "a length")
            return f"{part} is {one}, added to {other} in {self.within}: a radius or a pitch is missing, as in R*q1"
        has = f"is in {units.unit_text(self.found.powers)}" if self.found.powers else "has no unit"
        needed = "an angle" if self.needed == ANGLE else units.unit_text(self.needed) or "a number"
        return (
            f"{part} {has} in {self.within}, where {needed} is needed: correct the formula, or a unit in [parameters]"
        )


def mismatches(formula: Formula, names: Mapping[str, Powers], needed: Powers) -> list[Mismatch]:
    """Parts of a formula whose unit does not fit, by those of the names that have one and by that of the formula."""
    found = _Units(names, quote(formula))
    found.same([*terms(formula.tree)], Measure(needed))
    return found.mismatches


def terms(tree: Tree) -> Iterator[Tree]:
    """The terms of a sum, without their signs."""
    if tree[0] in ("+", "-", "neg"):
        for part in tree[1:]:
            yield from terms(part)
    else:
        yield tree


def fits(powers: Powers, others: Powers) -> bool:
    """Whether two units are the same but for rad."""
    return product((powers, 1), (others, -1)).keys() <= ANGLE.keys()


class _Units:
    """Units of the parts of a formula, from the names upwards; what does not fit is collected."""

    def __init__(self, names: Mapping[str, Powers], formula: str) -> None:
        self.names, self.formula = names, formula
        self.mismatches: list[Mismatch] = []

    def of(self, tree: Tree) -> Measure | None:
        """The unit of a part; None where it may be any."""
        match tree:
            case ("number", value):
                return COUNT if value.denominator == 1 else None
            case ("pi",):
                return COUNT
            case ("name", name):
                return Measure(self.names[name]) if name in self.names else None
            case ("power", base, exponent):
                return self.product((base, exponent))
            case ("sqrt", base):
                return self.product((base, Fraction(1, 2)))
            case ("*", one, other):
                return self.product((one, 1), (other, 1))
            case ("/", one, other):
                return self.product((one, 1), (other, -1))
            case ("+" | "-" | "neg", *_):
                return self.same([*terms(tree)])
            case ("atan2", *sides):
                self.same(sides)
                return Measure(ANGLE)
        return self.function(tree)

    def product(self, *factors: tuple[Tree, Fraction | int]) -> Measure | None:
        """The unit of a product of powers."""
        found = [(self.of(part), exponent) for part, exponent in factors]
        known = [(measure, exponent) for measure, exponent in found if measure is not None]
        if len(known) < len(found):
            return None
        powers = product(*((measure.powers, exponent) for measure, exponent in known))
        return Measure(powers, any(one.counted for one, _ in known), all(one.bare for one, _ in known))

    def same(self, parts: Sequence[Tree], needed: Measure | None = None) -> Measure | None:
        """The unit common to parts: the one needed, else the first, preferably one that is not an angle.

        Numbers take the unit of the others.
        """
        found = [(part, self.of(part)) for part in parts]
        known = [(part, measure) for part, measure in found if measure is not None and not measure.bare]
        if needed is None and not known:
            return COUNT if all(measure for _, measure in found) else None
        common = needed or min((measure for _, measure in known), key=lambda one: one.powers == ANGLE)
        mixed = any(not fits(one.powers, other.powers) for (_, one), (_, other) in pairwise(known))
        for part, measure in known:
            if not fits(measure.powers, common.powers) or (needed and _is_power_of_angle(measure, needed)):
                found_there = replace(measure, counted=measure.counted or common.counted)
                self.mismatches.append(Mismatch(part, found_there, common.powers, self.formula, mixed))
        return replace(common, counted=any(measure.counted for _, measure in known))

    def function(self, tree: Tree) -> Measure:
        """The unit of a sine, cosine or tangent: none, of an angle."""
        angle = self.of(tree[1])
        if angle and not fits(angle.powers, ANGLE):
            self.mismatches.append(Mismatch(tree[1], angle, ANGLE, text_of(tree), is_mixed=True, is_in_function=True))
        return Measure({})


def _is_power_of_angle(found: Measure, needed: Measure) -> bool:
    """Whether an angle is needed and rad2, 1/rad and the like are found."""
    return needed.powers == ANGLE and not found.counted and found.powers.get("rad", 0) not in (0, 1)
