"""Columns of the table of a machine: dimension, keys and names of each, and iteration over all of them.

A field of a dataclass that holds a formula, or several, is declared with `column(...)`. Checks, file
formats, test values, sensitivities and reports walk these fields, so a new one is declared once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from functools import cache, cached_property
from typing import Any, TypeVar

from symoro_elastic.machine.formula import ZERO, Formula

Owner = TypeVar("Owner")
Values = tuple[Formula, ...]

COLUMN, CENTRAL = "column", "central"
AXES = ("x", "y", "z")
TENSOR = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
UPPER = ((0, 1, 2), (1, 3, 4), (2, 4, 5))
"""Entries of a symmetric tensor in that order, by row and column."""


class Dimension(Enum):
    """Physical dimension of a number: its unit at a revolute and at a prismatic joint."""

    NUMBER = "number", ""
    RATIO = "ratio of a gear", "rad/rad", "rad/m"
    ANGLE = "angle", "rad"
    LENGTH = "length", "m"
    MASS = "mass", "kg"
    FIRST_MOMENT = "first moment of mass", "kg m"
    INERTIA = "moment of inertia", "kg m2"
    ROTOR_INERTIA = "rotor inertia", "kg m2", "kg"
    STIFFNESS = "stiffness", "N m/rad", "N/m"
    DAMPING = "damping", "N m s/rad", "N s/m"
    LINEAR_DAMPING = "damping of a translation", "N s/m"
    ANGULAR_DAMPING = "damping of a rotation", "N m s/rad"
    POSITION = "joint position", "rad", "m"
    VISCOUS_FRICTION = "viscous friction", "N m s/rad", "N s/m"
    COULOMB_FRICTION = "Coulomb friction", "N m", "N"
    CREEP = "creep velocity", "rad/s", "m/s"
    SHARE = "share", ""
    BACKLASH = "backlash", "rad", "m"
    RESISTANCE = "electrical resistance", "Ohm"
    INDUCTANCE = "inductance", "H"
    TORQUE_CONSTANT = "torque constant", "N m/A", "N/A"
    BACK_EMF = "back-EMF constant", "V s/rad", "V s/m"
    COGGING = "cogging torque", "N m", "N"
    PER_TURN = "number per turn", "", "rad/m"
    PHASE = "phase angle", "rad"
    FORCE = "force", "N"
    MOMENT = "moment", "N m"
    VELOCITY = "velocity", "m/s"
    ANGULAR_VELOCITY = "angular velocity", "rad/s"
    ACCELERATION = "acceleration", "m/s2"
    ANGULAR_ACCELERATION = "angular acceleration", "rad/s2"
    GRAVITY = "acceleration of gravity", "m/s2"

    def __init__(self, meaning: str, unit: str, prismatic: str = "") -> None:
        self.meaning, self.units = meaning, (unit, prismatic or unit)

    @property
    def is_nonnegative(self) -> bool:
        """Whether a negative value is an error."""
        return self in NOT_NEGATIVE

    def fault(self, x: float, by: str = "") -> str:
        """Why x cannot be the value of a cell of this dimension; empty for a valid one. `by` names the source of x."""
        if x < 0 and self.is_nonnegative:
            return f"is negative: {x:g}{by}"
        if x == 0 and self in WITHOUT:
            return f"is 0{by}: leave it out, then {WITHOUT[self]}"
        if x >= LARGEST_SHARE and self is Dimension.SHARE:
            return f"is {x:g}{by}: it must be below {LARGEST_SHARE}"
        return ""


NOT_NEGATIVE = (
    *(Dimension.MASS, Dimension.ROTOR_INERTIA, Dimension.STIFFNESS, Dimension.DAMPING),
    *(Dimension.VISCOUS_FRICTION, Dimension.COULOMB_FRICTION, Dimension.CREEP, Dimension.SHARE),
    *(Dimension.BACKLASH, Dimension.LINEAR_DAMPING, Dimension.ANGULAR_DAMPING),
    *(Dimension.RESISTANCE, Dimension.INDUCTANCE, Dimension.TORQUE_CONSTANT, Dimension.BACK_EMF),
)

LARGEST_SHARE = 0.9
"""Of a load in its own friction, which stops the joint at 1, and of a bristle that is elastic."""
LEAST_ROUNDING = 1e-4
"""Of a backlash: at sharper edges digits are lost, and no step is small enough."""
WITHOUT = {
    Dimension.CREEP: "dry friction jumps at rest (stribeck: leave out static, too)",
    Dimension.BACKLASH: "the spring is straight, or its edges are rounded by backlash/50",
    Dimension.PER_TURN: "the joint has no cogging: leave that out, too",
}
"""Laws without a cell that cannot be 0."""
OF_ROTORS = (
    *(Dimension.ROTOR_INERTIA, Dimension.TORQUE_CONSTANT, Dimension.BACK_EMF),
    *(Dimension.COGGING, Dimension.PER_TURN),
)
"""Those that belong to the axis of the rotor where a ratio is given, which turns where the joint slides, too."""


@dataclass(frozen=True)
class Column:
    """One column of the table, with an entry for each of `parts` where it is a vector or a tensor.

    `key` is its key in TOML, in the table `section`; `par` is its key in .par files, one for each entry or one for
    all: a list of that format, or else an extension line. `title` is its name in messages, `symbol` its name in the
    table that `show` prints. Numbers in it become parameters `<joint>.<name>` of sensitivities where it is `tunable`.
    `meaning` and `example`, as TOML writes its value, are in the reference of the formats; an entry that is left out
    is `default`.
    """

    key: str
    section: str
    dimension: Dimension
    par: tuple[str, ...]
    parts: tuple[str, ...] = ()
    title: str = ""
    symbol: str = ""
    tunable: bool = False
    meaning: str = ""
    example: str = "0"
    default: Formula = ZERO

    @cached_property
    def cells(self) -> tuple[Cell, ...]:
        """The cells of the column, one for each of its parts."""
        return tuple(Cell(self, k) for k in range(len(self.parts) or 1))


@dataclass(frozen=True)
class Cell:
    """One entry of a column."""

    column: Column
    index: int = 0

    @property
    def label(self) -> str:
        """Name of the cell in messages: `stiffness`, `inertia XX`."""
        title = self.column.title or self.column.key
        return f"{title} {self.column.parts[self.index]}" if self.column.parts else title

    @property
    def par(self) -> str:
        """Key of the cell in .par files, empty where that format has no place for it."""
        keys = self.column.par
        return keys[self.index if len(keys) > 1 else 0] if keys else ""

    @property
    def name(self) -> str:
        """Name of the cell as a parameter: `stiffness`, `XX`, `center_of_mass.x`."""
        if not self.column.parts:
            return self.column.key
        return self.par or f"{self.column.key}.{self.column.parts[self.index]}"


def column(
    dimension: Dimension,
    section: str,
    par: str,
    parts: tuple[str, ...] = (),
    *,
    key: str = "",
    title: str = "",
    symbol: str = "",
    tunable: bool = False,
    meaning: str = "",
    example: str = "0",
    default: str = "",
    central: Column | None = None,
) -> Any:
    """A dataclass field that holds a column, `default` or zero unless given; its key is the field's name unless given.

    `central` describes the column where the owner's `central` is true.
    """
    usual = Formula.parse(default) if default else ZERO
    cell = Column(key, section, dimension, tuple(par.split()), parts, title, symbol, tunable, meaning, example, usual)
    return field(default=(ZERO,) * len(parts) if parts else usual, metadata={COLUMN: cell, CENTRAL: central or cell})


def columns(owner: Any) -> Iterator[tuple[Column, Values]]:
    """Yield every column of a joint, body, spring or base, also of its parts, with the formulas in it."""
    for name, kind in _fields(owner):
        value = getattr(owner, name)
        if isinstance(kind, type):
            yield from columns(value)
        else:
            yield _column_of(owner, kind), value if isinstance(value, tuple) else (value,)


def cells(owner: Any) -> Iterator[tuple[Cell, Formula]]:
    """Yield every cell of a joint, body, spring or base, also of its parts, with the formula in it."""
    for column, values in columns(owner):
        yield from zip(column.cells, values, strict=True)


def declared_columns(owner: type, section: str = "", form: str = COLUMN) -> tuple[Column, ...]:
    """Columns of a class, all or those of a section of a TOML file.

    Those of bodies about the origin of their frame; about their centre of mass where `form` is `CENTRAL`.
    """
    result: list[Column] = []
    for _, part in _layout(owner):
        result += declared_columns(part, form=form) if isinstance(part, type) else [part[form]]
    return tuple(column for column in result if section in ("", column.section))


def with_columns(owner: Owner, change: Callable[[Column, Values], Sequence[Formula]]) -> Owner:
    """The same data with the formulas that `change` gives for each column."""
    changed: dict[str, Any] = {}
    for name, kind in _fields(owner):
        value = getattr(owner, name)
        if isinstance(kind, type):
            changed[name] = with_columns(value, change)
        elif isinstance(value, tuple):
            changed[name] = tuple(change(_column_of(owner, kind), value))
        else:
            (changed[name],) = change(_column_of(owner, kind), (value,))
    return replace(owner, **changed)  # type: ignore[type-var]


def with_cells(owner: Owner, change: Callable[[Cell, Formula], Formula]) -> Owner:
    """The same data with the formula that `change` gives for each cell."""
    return with_columns(owner, lambda column, values: [*map(change, column.cells, values)])


Described = Mapping[str, Column]
"""What a column is, and what it is in a body about its centre of mass."""
Layout = tuple[tuple[str, Described | type], ...]


def _column_of(owner: Any, described: Described) -> Column:
    return described[CENTRAL if getattr(owner, CENTRAL, False) else COLUMN]


def _fields(owner: Any) -> Layout:
    kind: Any = type(owner)
    return _layout(kind)


@cache
def _layout(owner: type) -> Layout:
    """Names of the fields of a class that hold columns: with the column, or with a class that has columns itself."""
    layout: list[tuple[str, Described | type]] = []
    for item in fields(owner):
        if COLUMN in item.metadata:
            layout.append((item.name, {name: replace(x, key=x.key or item.name) for name, x in item.metadata.items()}))
        elif is_dataclass(item.default) and not isinstance(item.default, type):
            layout.append((item.name, type(item.default)))
    return tuple(layout)
