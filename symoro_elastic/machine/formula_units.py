"""Units of formulas, by the units of parameters and joint variables: which parts do not fit.

A parameter without a unit, or with one that is not known, may have any, and so may a number such as 0.05: it may be a
radius in m. Integers and pi are ratios. The rad is a unit of its own that counts as a number beside
others: an arc is a radius times an angle. So is the cycle of Hz, but 2 pi cycles are not a rad: only 2*pi*f is in
rad/s.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from symoro_elastic.machine.formula import Formula, Tree, names_in, terms, text_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import quote
from symoro_elastic.quantities.unit_reader import CYCLE, Powers, dimension, product, unit_text

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
    actual: Measure
    needed: Powers
    within: str
    is_mixed: bool
    is_in_function: bool = False

    @property
    def is_of_angles(self) -> bool:
        """Whether only the power of rad is wrong, which changes no number."""
        return fits(self.actual.powers, self.needed)

    @property
    def is_radius_missing(self) -> bool:
        """Whether an angle is added to a length, or a length to an angle."""
        pair = (self.actual.powers, self.needed)
        return not self.is_in_function and pair in ((ANGLE, LENGTH), (LENGTH, ANGLE))

    @property
    def message(self) -> str:
        """The mismatch in words, and the way out."""
        part = text_of(self.part)
        if self.is_radius_missing:
            actual, other = ("a length", "an angle") if self.needed == ANGLE else ("an angle", "a length")
            return f"{part} is {actual}, added to {other} in {self.within}: a radius or a pitch is missing, as in R*q1"
        has = f"is in {unit_text(self.actual.powers)}" if self.actual.powers else "has no unit"
        needed = "an angle" if self.needed == ANGLE else unit_text(self.needed) or "a number"
        return (
            f"{part} {has} in {self.within}, where {needed} is needed: correct the formula, or a unit in [parameters]"
        )


def mismatches(formula: Formula, names: Mapping[str, Powers], needed: Powers) -> list[Mismatch]:
    """Return the parts of a formula whose unit does not fit those of its names, or the one that is `needed`."""
    units = _Units(names, quote(formula))
    units.same([*terms(formula.tree)], Measure(needed))
    return units.mismatches


def fits(powers: Powers, other: Powers) -> bool:
    """Return whether two units are equal up to rad or cycles, which change no number."""
    return any(product((powers, 1), (other, -1)).keys() <= {unit} for unit in ("rad", CYCLE))


class _Units:
    """Units of the parts of a formula, from the names upwards; mismatches are collected."""

    def __init__(self, names: Mapping[str, Powers], formula: str) -> None:
        self.names, self.formula = names, formula
        self.mismatches: list[Mismatch] = []

    def of(self, tree: Tree) -> Measure | None:
        """Return the unit of a part of a formula; None if any unit fits."""
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
        measures = [(self.of(part), exponent) for part, exponent in factors]
        units = [(measure, exponent) for measure, exponent in measures if measure is not None]
        if len(units) < len(measures):
            return None
        powers = product(*((measure.powers, exponent) for measure, exponent in units))
        return Measure(powers, any(measure.counted for measure, _ in units), all(measure.bare for measure, _ in units))

    def same(self, parts: Sequence[Tree], needed: Measure | None = None) -> Measure | None:
        """The unit common to parts: the one needed, else the first, preferably one that is not an angle.

        Numbers have the unit of the other parts.
        """
        measures = [(part, self.of(part)) for part in parts]
        certain = [(part, measure) for part, measure in measures if measure is not None and not measure.bare]
        if needed is None and not certain:
            return COUNT if all(measure for _, measure in measures) else None
        common = needed or min((measure for _, measure in certain), key=lambda measure: measure.powers == ANGLE)
        mixed = any(not fits(first.powers, other.powers) for (_, first), (_, other) in pairwise(certain))
        for part, measure in certain:
            counted = measure.counted and _is_turning(measure, common)
            if not (counted or fits(measure.powers, common.powers)) or (needed and _is_power_of_angle(measure, needed)):
                actual = replace(measure, counted=measure.counted or common.counted)
                self.mismatches.append(Mismatch(part, actual, common.powers, self.formula, mixed))
        return replace(common, counted=any(measure.counted for _, measure in certain))

    def function(self, tree: Tree) -> Measure:
        """Return the unit of a sine, cosine or tangent, which is none; its argument is an angle."""
        angle = self.of(tree[1])
        if angle and not fits(angle.powers, ANGLE):
            self.mismatches.append(Mismatch(tree[1], angle, ANGLE, text_of(tree), is_mixed=True, is_in_function=True))
        return Measure({})


def _is_turning(measure: Measure, needed: Measure) -> bool:
    """Whether radians are needed and the unit is in cycles, or the reverse: 2*pi*f."""
    return product((measure.powers, 1), (needed.powers, -1)).keys() == {"rad", CYCLE}


def _is_power_of_angle(measure: Measure, needed: Measure) -> bool:
    """Whether an angle is needed and the unit is rad2, 1/rad or the like."""
    return needed.powers == ANGLE and not measure.counted and measure.powers.get("rad", 0) not in (0, 1)


@dataclass(frozen=True)
class Doubt:
    """An error, or a possible error, in the units of a formula."""

    what: str
    is_certain: bool


@dataclass(frozen=True)
class UnitsOfNames:
    """Units of the names of a machine: of the parameters that declare one, and of the joint variables."""

    machine: Machine

    @cached_property
    def declared(self) -> dict[str, Powers]:
        """Units of parameters, as exponents of kg, m, s and rad, where they are declared and known."""
        dimensions = {p.name: dimension(p.unit) for p in self.machine.parameters if p.unit}
        return {name: powers for name, powers in dimensions.items() if powers is not None}

    @cached_property
    def of_variables(self) -> dict[str, Powers]:
        """Units of joint variables."""
        units = {name: dimension(self.machine.joint(j).unit) for name, j in self.machine.variables.items()}
        return {name: powers for name, powers in units.items() if powers is not None}

    @cached_property
    def known(self) -> dict[str, Powers]:
        """Units of all names that have one."""
        return {**self.declared, **self.of_variables}

    def doubts(self, formula: Formula, unit: str, *, gives_position: bool) -> Iterator[Doubt]:
        """Yield doubts about the units of a formula that needs `unit`, and that gives a joint's position or not.

        Numbers may have units: `8e4/L` is a stiffness in N/m, `1*q1` an arc of radius 1 m. So it is certain only where
        a variable stands alone, or where units are declared. A unit that is only not that of the cell is a warning:
        values are taken in the unit of the cell.
        """
        needed = dimension(unit) or {}
        for mismatch in mismatches(formula, self.known, needed):
            is_fixed = gives_position and not mismatch.is_of_angles
            if (gives_position or mismatch.is_mixed) and self._is_certain(mismatch):
                yield Doubt(mismatch.message, is_certain=True)
            elif is_fixed or mismatch.is_mixed or self._is_declared(mismatch, formula):
                yield Doubt(mismatch.message, is_certain=False)

    def _is_certain(self, mismatch: Mismatch) -> bool:
        names = names_in(mismatch.part)
        stands_alone = mismatch.part[0] == "name" or not names.isdisjoint(self.declared)
        return stands_alone and not mismatch.actual.counted and not mismatch.is_of_angles

    def _is_declared(self, mismatch: Mismatch, formula: Formula) -> bool:
        """Whether a name with a declared unit is in the mismatch; a number may carry units in formulas of variables."""
        declared = any(name in self.declared for name in formula.names)
        return declared and (mismatch.is_of_angles or formula.names.isdisjoint(self.of_variables))
