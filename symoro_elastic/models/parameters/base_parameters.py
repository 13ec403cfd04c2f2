"""Base inertial parameters of a machine as formulas, and the machine that has only those.

The grouping rules are decided modulo a large prime, at random values of parameters and variables:
parallel, perpendicular, along gravity then mean so for every value, angles of 0.37 - 0.37 included.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import formulas as formulas_of
from symoro_elastic.machine.checks import parameter_values, require_fixed_base
from symoro_elastic.machine.columns import Cell, cells, with_cells
from symoro_elastic.machine.described import with_changed_scene
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.mechanics.base_parameters import ROTOR, GroupingRule, Simplify, group, grouping_rules
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.regressor import INERTIAL, parameters_of
from symoro_elastic.mechanics.spatial import Axis, is_zero
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, Library, ModularAngles, evaluate
from symoro_elastic.symbolic.expression import Constant, exact
from symoro_elastic.symbolic.finite_field import PRIME, Residue
from symoro_elastic.symbolic.operations import COS, COSPI, PI

Monomial = tuple[str, ...]
"""Factors (names and functions as text) in order, repeated for powers."""
ONE: Monomial = ()
MAX_DIGITS = 17
SEED = 20261
KEPT, GROUPED, NO_EFFECT = "kept", "grouped", "without effect"
LONGEST_SUMS = (1000, 400, 120, 40)
"""Length (characters) above which an intermediate sum gets a name; the next is tried where a formula is too long."""
Label = tuple[int, str]
"""A parameter: number of the joint, and XX ... M or IA."""
Relations = Mapping[Label, Mapping[Label, float]]
"""Coefficients of the parameters that are grouped into base parameters, by base parameter."""


class Polynomial:
    """Exact coefficients of monomials."""

    __slots__ = ("terms",)

    def __init__(self, terms: Mapping[Monomial, Fraction]) -> None:
        self.terms = {monomial: x for monomial, x in terms.items() if x}

    @classmethod
    def factor(cls, text: str) -> Polynomial:
        """The polynomial of a factor: a name, a function or an expression in brackets."""
        return cls({(text,): Fraction(1)})

    @classmethod
    def of(cls, x: Polynomial | Constant) -> Polynomial:
        """A constant as a polynomial."""
        return x if isinstance(x, Polynomial) else cls({ONE: Fraction(x)})

    def __add__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        if right is None:
            return NotImplemented
        terms = dict(self.terms)
        for monomial, x in right.terms.items():
            terms[monomial] = terms.get(monomial, Fraction(0)) + x
        return Polynomial(terms)

    def __mul__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        if right is None:
            return NotImplemented
        terms: dict[Monomial, Fraction] = {}
        for first, x in self.terms.items():
            for second, y in right.terms.items():
                monomial = tuple(sorted((*first, *second)))
                terms[monomial] = terms.get(monomial, Fraction(0)) + x * y
        return Polynomial(terms)

    def __neg__(self) -> Polynomial:
        return self * -1

    def __sub__(self, other: Scalar) -> Polynomial:
        right = _polynomial(other)
        return NotImplemented if right is None else self + -right

    def __truediv__(self, other: Scalar) -> Polynomial:
        divisor = _polynomial(other)
        if divisor is None:
            return NotImplemented
        if set(divisor.terms) == {ONE}:
            return self * (1 / divisor.terms[ONE])
        if self.terms == divisor.terms:
            return Polynomial.of(1)
        return self * Polynomial.factor(f"(1/({polynomial_text(divisor)}))")

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Scalar) -> Polynomial:
        minuend = _polynomial(other)
        return NotImplemented if minuend is None else minuend - self

    def __rtruediv__(self, other: Scalar) -> Polynomial:
        dividend = _polynomial(other)
        return NotImplemented if dividend is None else dividend / self

    def __bool__(self) -> bool:
        return bool(self.terms)


def _polynomial(x: Scalar) -> Polynomial | None:
    """A polynomial, or an exact constant as a polynomial; None for anything else."""
    if isinstance(x, Polynomial):
        return x
    constant = exact(x)
    return None if constant is None else Polynomial.of(constant)


def polynomial_text(p: Polynomial, sources: Collection[str] = ()) -> str:
    """The text of a polynomial, in the grammar of machine files.

    Factors of a common product are collected in brackets where they are linear in `sources`:
    `D4^2*(M4 + M5 + M6)`.
    """
    groups: dict[Monomial, dict[Monomial, Fraction]] = {}
    for monomial, x in p.terms.items():
        outer = tuple(name for name in monomial if name not in sources)
        inner = tuple(name for name in monomial if name in sources)
        groups.setdefault(outer, {})[inner] = x
    terms = [term for outer, inner in groups.items() for term in _group(outer, inner)]
    return _sum(terms)


def _group(outer: Monomial, inner: dict[Monomial, Fraction]) -> list[tuple[Fraction, str]]:
    """Terms with a common outer factor, in a bracket where there are several and the factor is not 1."""
    if outer == ONE or len(inner) == 1:
        return [(x, "*".join(_powers((*outer, *monomial), x))) for monomial, x in inner.items()]
    first = next(iter(inner.values()))
    common = first if len({abs(x) for x in inner.values()}) == 1 else Fraction(1 if first > 0 else -1)
    bracket = _sum([(x / common, "*".join(_powers(monomial, x / common))) for monomial, x in inner.items()])
    return [(common, "*".join([*_powers(outer, common), f"({bracket})"]))]


def _powers(monomial: Monomial, coefficient: Fraction) -> list[str]:
    """Factors of a term without its sign, powers written as such."""
    size = abs(coefficient)
    times = [(name, monomial.count(name)) for name in dict.fromkeys(monomial)]
    factors = [name if n == 1 else f"{name}^{n}" for name, n in times]
    return factors if size == 1 and factors else [_number(size), *factors]


def _sum(terms: list[tuple[Fraction, str]]) -> str:
    text = "".join(f" {'+' if x > 0 else '-'} {term}" for x, term in terms)
    return "0" if not terms else text[3:] if text.startswith(" + ") else f"-{text[3:]}"


def _number(x: Fraction) -> str:
    """A positive number: a fraction or a decimal, rounded to a double where it is long."""
    if x.denominator == 1 and len(str(x)) <= MAX_DIGITS:
        return str(x)
    short = repr(float(x))
    if Fraction(short) == x or len(str(x)) > MAX_DIGITS:
        return short
    return str(x)


def _function(name: str) -> Callable[..., Polynomial]:
    return lambda *operands: Polynomial.factor(f"{name}({', '.join(map(polynomial_text, operands))})")


POLYNOMIALS: Arithmetic[Polynomial] = Arithmetic(
    Polynomial.of,
    Library(
        _function,
        {PI: lambda: Polynomial.factor("pi"), COSPI: lambda halves: _function(COS)(halves * Polynomial.factor("pi"))},
    ),
)


@dataclass(frozen=True)
class BaseParameter:
    """A base inertial parameter: `XXR3` where others are grouped into it, else `XX3` (see `ParameterLabels`).

    `formula` is over the names of the machine and of the composites.
    """

    name: str
    joint: int
    entry: str
    formula: Formula


@dataclass(frozen=True)
class Grouping:
    """The base inertial parameters of a machine.

    `effects` gives the effect on every parameter: (joint, entry) -> kept, grouped or without
    effect; `count` is the number of base parameters of general bodies, `parameters` are the ones that
    are not zero for the bodies of this machine. `composites` are sums that have a name because
    formulas would be too long, in the order in which they can be computed. `labels` name all that are
    kept, also those that are zero for the bodies of this machine. `machine` has the same torques, but
    neither the same reaction wrenches nor, with base parameters only, real bodies. `geometry` are names of parameters
    that the sums hold the values of: they are base parameters for these values only.
    """

    parameters: tuple[BaseParameter, ...]
    composites: Mapping[str, Formula]
    effects: Mapping[Label, str]
    labels: Mapping[Label, str]
    machine: Machine
    geometry: tuple[str, ...] = ()

    @property
    def kept(self) -> list[Label]:
        """Base inertial parameters of the structure, rotor inertias included."""
        return [label for label, effect in self.effects.items() if effect == KEPT]

    @property
    def count(self) -> int:
        """Number of base inertial parameters of the structure."""
        return len(self.kept)

    @property
    def zero(self) -> list[str]:
        """Labels of base parameters that vanish for the bodies of this machine."""
        with_parameter = {(p.joint, p.entry) for p in self.parameters}
        return [name for label, name in self.labels.items() if label not in with_parameter]

    @cached_property
    def formulas(self) -> dict[str, str]:
        """The text of every formula, composites first."""
        return {name: formula.text for name, formula in self._all()}

    def values(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values of composites and base parameters from those of the machine's parameters.

        Parameters that depend on a name without value are omitted.
        """
        known_values = dict(values)
        results = {}
        for name, formula in self._all():
            if formula.names <= known_values.keys():
                results[name] = formula.value(known_values)
                known_values.setdefault(name, results[name])
        return results

    def _all(self) -> Iterator[tuple[str, Formula]]:
        yield from self.composites.items()
        yield from ((parameter.name, parameter.formula) for parameter in self.parameters)


def base_grouping(machine: Machine) -> Grouping:
    """Group the inertial parameters of a machine; on a base that moves, for every motion of the base.

    With couplings and loops these are the groups of the tree of its joints, which are all valid there too; what
    couplings and loops group besides is found by numbers (`grouping`).

    Raises `InputError` for cells without value, and where the sums are too long to be written.
    """
    require_fixed_base(machine, "base inertial parameters")
    machine.refuse_flexible("grouping inertial parameters")
    zero = ZeroPosition(machine)
    rules = zero.grouping_rules()
    mechanism = zero.polynomials()
    texts = _written_sums(zero, mechanism, lambda simplify: group(mechanism, rules, simplify))
    effects = {(j, name): effect for j in rules for name, effect in _effects(zero, j, rules[j])}
    return _grouping(texts, effects)


GroupingOf = Callable[[Machine], Grouping]
"""A function that groups the inertial parameters of a machine."""


def grouping_of_tree(machine: Machine) -> Grouping:
    """Group the inertial parameters of a machine without couplings and loops; `ValueError` for others.

    Their base is found by numbers, which stand above models.
    """
    if machine.is_coupled:
        raise ValueError(f"{machine.label}: couplings and loops group more than the rules of a tree")
    return base_grouping(machine)


def numeric_grouping(machine: Machine, relations: Relations) -> Grouping:
    """The grouping with numeric coefficients, which are valid for a single geometry."""
    zero = ZeroPosition(machine)
    mechanism = zero.polynomials()
    texts = _written_sums(zero, mechanism, lambda simplify: _sums(mechanism, relations, simplify))
    gone = {label for members in relations.values() for label in members}
    entries = [(j, name) for j, _ in mechanism.from_base() for name, _ in _effects(zero, j, ())]
    return _grouping(texts, {x: KEPT if x in relations else GROUPED if x in gone else NO_EFFECT for x in entries})


def _sums(mechanism: Mechanism, relations: Relations, simplify: Simplify) -> dict[int, dict[str, Any]]:
    own = {j: _own(mechanism, j) for j, _ in mechanism.from_base()}
    sums: dict[int, dict[str, Any]] = {j: {} for j in own}
    for (j, entry), members in relations.items():
        total = own[j][entry]
        for (k, other), coefficient in members.items():
            total = simplify(j, entry, total + Fraction(repr(coefficient)) * own[k][other])
        sums[j][entry] = total
    return sums


def _grouping(texts: _Texts, effects: Mapping[Label, str]) -> Grouping:
    parameters = tuple(texts.parameters)
    composites = _needed_composites(texts.composites, [parameter.formula for parameter in parameters])
    names = {(p.joint, p.entry): p.name for p in parameters}
    labels = {x: names.get(x) or texts.label(x[1], x[0]) for x, effect in effects.items() if effect == KEPT}
    return Grouping(parameters, composites, effects, labels, _regroup(texts.machine, parameters, composites))


class ZeroPosition:
    """The tree of a machine with all joint positions zero, in several arithmetics: loops open, no coupling, no force.

    Every joint then moves freely. What is grouped in that tree is grouped in all its motions, those of the machine
    with its couplings and loops among them.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        fixed = tuple(_fixed_at_zero(machine, joint) for joint in machine.joints)
        mechanism = Tree(replace(machine, joints=fixed, loops=(), forces=())).mechanism
        links = [
            replace(link, axis=Axis(machine.joint(j).sigma) if j in machine.articulated else Axis.NONE)
            for j, link in enumerate(mechanism.links, start=1)
        ]
        self.mechanism = replace(mechanism, links=tuple(links))
        self._leaves = [*self.mechanism.scalars()]

    @property
    def free_base(self) -> bool:
        """Whether the base moves."""
        base = self.machine.base
        motion = (base.velocity, base.angular_velocity, base.acceleration, base.angular_acceleration)
        return any(not formula.is_zero for vector in motion for formula in vector)

    @property
    def geometry(self) -> list[str]:
        """Parameters that the grouping depends on: of the geometry and, on a base at rest, of gravity."""
        formulas = [
            formula
            for joint in self.machine.joints
            for cell, formula in cells(joint)
            if cell.column.section == "joints"
        ]
        formulas += [] if self.free_base else self.machine.base.gravity
        used = {name for formula in formulas for name in formula.names}
        return [parameter.name for parameter in self.machine.parameters if parameter.name in used]

    def modulo_prime(self) -> Mechanism:
        """The mechanism modulo a prime at random values of all parameters."""
        return self.mechanism.map(ModularAngles(SEED).values(self._leaves))

    def floats(self, values: Mapping[str, float]) -> Mechanism:
        """The mechanism in double precision."""
        value: Callable[[Scalar], float] = evaluate(self._leaves, values, FLOATS)
        return self.mechanism.map(value)

    def polynomials(self) -> Mechanism:
        """The mechanism as polynomials over the names of the parameters."""
        names = {parameter.name: Polynomial.factor(parameter.name) for parameter in self.machine.parameters}
        value: Callable[[Scalar], Polynomial] = evaluate(self._leaves, names, POLYNOMIALS)
        return self.mechanism.map(value)

    def grouping_rules(self) -> dict[int, list[GroupingRule]]:
        """Grouping rules, by body."""
        source = random.Random(SEED)
        return grouping_rules(
            self.modulo_prime(), lambda: Residue(source.randrange(1, PRIME)), self.free_base, self._typical()
        )

    def _typical(self) -> Mechanism:
        """The mechanism in double precision, with random values about 1 of parameters without value."""
        source = random.Random(SEED)
        values = {parameter.name: source.uniform(0.5, 1.5) for parameter in self.machine.parameters}
        try:
            return self.floats(values | parameter_values(self.machine))
        except (ArithmeticError, ValueError):
            return self.mechanism.map(lambda x: 1.0)


def _fixed_at_zero(machine: Machine, joint: Joint) -> Joint:
    """The joint at position zero as a fixed frame, without the part of its cell that follows other variables."""
    if not joint.selected.names.isdisjoint(machine.variables):
        joint = joint.with_selected(ZERO)
    return replace(joint, kind=Kind.FIXED, sigma=2, variable=None, spring=Spring())


def _effects(zero: ZeroPosition, j: int, rules: Sequence[GroupingRule]) -> Iterator[tuple[str, str]]:
    """Effect of the grouping on each parameter of body j; a rotor inertia counts where the machine has one."""
    gone = {x.eliminated: GROUPED if x.joins_antecedent or len(x.combination) > 1 else NO_EFFECT for x in rules}
    rotor = [] if is_zero(zero.mechanism.links[j - 1].rotor_inertia) else [ROTOR]
    return ((name, gone.get(name, KEPT)) for name in (*INERTIAL, *rotor))


class _Texts:
    """Writer of formulas of grouped parameters, in which sums longer than `longest` get a name of their own."""

    def __init__(self, zero: ZeroPosition, longest: int) -> None:
        self.machine = zero.machine
        self.longest = longest
        self.composites: dict[str, Formula] = {}
        self._names: dict[Formula, str] = {}
        self.parameters: list[BaseParameter] = []
        self.sources = _inertial_names(zero.machine)
        self.labels = ParameterLabels(zero.machine)

    def simplify(self, j: int, entry: str, x: Any) -> Any:
        """The sum x; where its text is long, its number, or the name of a new parameter that stands for it."""
        text = self.text(x)
        if len(text) <= self.longest:
            return x
        formula = Formula.parse(text)
        if not formula.names:
            return Polynomial.of(Fraction(repr(formula.value())))
        if formula not in self._names:
            self._names[formula] = name = self.label(f"{entry}C", j)
            self.composites[name] = formula
            self.sources.add(name)
        return Polynomial.factor(self._names[formula])

    def text(self, x: Any) -> str:
        """The text of a grouped parameter, which is a sum."""
        return polynomial_text(Polynomial.of(x), self.sources)

    def label(self, entry: str, j: int, regrouped: bool = False) -> str:
        """Reserve and return an unused label."""
        label = self.labels.grouped_name(j, entry) if regrouped else self.labels(j, entry)
        self.labels.taken.add(label)
        return label

    def add(self, j: int, entry: str, x: Any, unchanged: bool) -> None:
        """Add a grouped parameter of body j, unless it is zero."""
        formula = Formula.parse(self.text(x))
        formula = self.composites.get(formula.text, formula)
        if formula.is_zero:
            return
        self.parameters.append(BaseParameter(self.label(entry, j, not unchanged), j, entry, formula))


def _written_sums(
    zero: ZeroPosition, mechanism: Mechanism, sums: Callable[[Simplify], Mapping[int, Mapping[str, Any]]]
) -> _Texts:
    """Formulas of the grouped parameters, split as little as their length allows."""
    for longest in LONGEST_SUMS:
        texts = _Texts(zero, longest)
        try:
            for j, values in sorted(sums(texts.simplify).items()):
                own = _own(mechanism, j)
                for entry, x in values.items():
                    texts.add(j, entry, x, Polynomial.of(x).terms == Polynomial.of(own[entry]).terms)
            return texts
        except FormulaError as error:
            too_long = error
    what = f"their sums are too long ({too_long}): write one parameter where the table has long formulas"
    raise zero.machine.error("base inertial parameters", what)


def _needed_composites(composites: dict[str, Formula], users: Sequence[Formula]) -> dict[str, Formula]:
    """The composites that formulas refer to, directly or through others."""
    names = {name for formula in users for name in formula.names}
    for name, formula in reversed(composites.items()):
        if name in names:
            names |= formula.names
    return {name: formula for name, formula in composites.items() if name in names}


def _own(mechanism: Mechanism, j: int) -> dict[str, Any]:
    """The inertial parameters of body j and its rotor inertia, by name, before grouping."""
    link = mechanism.links[j - 1]
    return {**parameters_of(link.body), ROTOR: link.rotor_inertia}


def _inertial_names(machine: Machine) -> set[str]:
    """Names that occur in the inertial parameters of a machine."""
    formulas = (formula for joint in machine.joints for cell, formula in cells(joint) if _is_inertial(cell))
    return {name for formula in formulas for name in formula.names}


def _is_inertial(cell: Cell) -> bool:
    """Whether a cell is of a body or a rotor; the share of a motor is of neither."""
    return cell.column.section in ("bodies", "motors") and cell.column.key != "sharing"


def _regroup(machine: Machine, parameters: Sequence[BaseParameter], composites: Mapping[str, Formula]) -> Machine:
    """The machine with the base parameters only, sums being parameters of their own."""
    base, new = _cells(parameters, machine, composites)
    joints = tuple(_with_inertial(joint, j, base) for j, joint in enumerate(machine.joints, start=1))
    bare = replace(machine, joints=joints, is_grouped=True)
    used = {name for _, formula in formulas_of(bare) for name in formula.names}
    gone = _inertial_names(machine) - used
    remaining = tuple(parameter for parameter in machine.parameters if parameter.name not in gone)
    return with_changed_scene(replace(bare, parameters=(*remaining, *new)), lambda scene: _scene(scene, gone, new))


def _cells(
    parameters: Sequence[BaseParameter], machine: Machine, composites: Mapping[str, Formula]
) -> tuple[dict[Label, Formula], list[Parameter]]:
    """The cells of base parameters, and the new parameters that they name."""
    values = parameter_values(machine)
    for name, formula in composites.items():
        if formula.names <= values.keys():
            values[name] = formula.value(values)
    units = {cell.par: cell.column.dimension.units[0] for cell, _ in cells(Body())}
    cells_of_base, new = {}, []
    for parameter in parameters:
        formula = parameter.formula
        if formula.names and formula.tree[0] != "name":
            value = Formula.parse(formula.value(values)) if formula.names <= values.keys() else None
            new.append(Parameter(parameter.name, value, units.get(parameter.entry, "")))
            formula = Formula.parse(parameter.name)
        elif not formula.names and formula.tree[0] != "number":
            formula = Formula.parse(formula.value())
        cells_of_base[parameter.joint, parameter.entry] = formula
    return cells_of_base, new


def _with_inertial(joint: Joint, j: int, inertial: Mapping[Label, Formula]) -> Joint:
    """The joint with these inertial parameters, zeros where there is none."""
    return with_cells(
        replace(joint, body=Body()),
        lambda cell, formula: inertial.get((j, cell.par), ZERO) if _is_inertial(cell) else formula,
    )


def _scene(scene: Scene, gone: set[str], new: Sequence[Parameter]) -> Scene:
    """The scene with folded parameters replaced by the new ones."""
    if scene.fold == ALL or not gone.intersection(scene.fold):
        return scene
    fold = tuple(name for name in scene.fold if name not in gone)
    return replace(scene, fold=(*fold, *(parameter.name for parameter in new if parameter.value is not None)))
