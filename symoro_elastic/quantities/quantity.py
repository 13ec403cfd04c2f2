"""A quantity of generated code: name, symbol, unit, shape, meaning, equations, role."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, replace
from enum import Enum
from functools import cache

from symoro_elastic.quantities.units import PairUnit, Unit


class Role(Enum):
    """Role of a quantity in generated code; `COLUMN` is a variable that derivatives are taken by."""

    ARGUMENT = "argument"
    RESULT = "result"
    COLUMN = "column"
    INTERMEDIATE = "intermediate"
    STATE = "state"
    """A block of the state of a machine: in test states, trajectories and calls."""
    CARRIED = "carried"
    """A block of the state that a time step advances."""


@dataclass(frozen=True)
class Samples:
    """Test values of an argument: moderate ones within `size`, extreme ones of 10^low to 10^high."""

    size: float
    decades: tuple[float, float] | None = None


@dataclass(frozen=True)
class Quantity:
    """An argument, a result, or a variable of derivatives."""

    name: str
    meaning: str
    symbol: str
    """LaTeX, without indices."""
    unit: Unit | PairUnit | None
    """None where it depends on more than the joints that an entry belongs to."""
    shape: str
    """Lengths of the axes, as in `frames x 6`: `n` joints that move, `m` motors, `d` dependent, `s` static, `w` frames
    under wrenches, `b` joints whose friction has a state, `l` whose friction rises with load, numbers."""
    roles: tuple[Role, ...]
    _: KW_ONLY
    frame: str = ""
    """Frame of the components, in words."""
    note: str = ""
    """What else the sentence says, at its end."""
    equations: tuple[int, ...] = ()
    entries: str | tuple[str, ...] = ""
    """Names of single entries, in which `@` is a number of a joint or wrench; empty: as joint variables are called."""
    index: str = ""
    """First index of all entries."""
    frame0: bool = False
    """Whether components are in frame 0, which then is a left superscript."""
    columns_follow_rows: bool = False
    """Whether a scene that chooses rows chooses columns, too."""
    plural: str = ""
    """Its name in `derivatives of ...`."""
    as_column: str = ""
    """Its name in `derivatives by ...`, where that is not `name`."""
    rows: int = 0
    """Rows of the matrix that may be given in its place."""
    samples: Samples | None = None
    """Test values of its entries."""
    is_word: bool = False
    """Whether no machine may use the name; other names are refused where a model uses them."""
    says_unit: bool = True
    """Whether the sentence ends with the unit."""
    is_derivative: bool = False

    @property
    def letter(self) -> str:
        """LaTeX of the whole quantity."""
        return self.symbol + (f"_{{{self.index}}}" if self.index else "")

    @property
    def sentence(self) -> str:
        """Meaning, frame and unit, as in docstrings, comments and tables."""
        parts = filter(None, (self.meaning, self.frame, self._units()))
        return ", ".join(parts) + (f"; {self.note}" if self.note else "")

    def _units(self) -> str:
        if self.unit is None or not self.says_unit:
            return ""
        if isinstance(self.unit, PairUnit):
            return self.unit.text
        if self.unit.linear and not self.unit.angular:
            return f"lengths in {self.unit.linear}"
        return self.unit.screw if self.axes[-1] == "6" else self.unit.text

    @property
    def axes(self) -> tuple[str, ...]:
        """Lengths of the axes in the shape, such as `n` (moving joints) and `6`."""
        return tuple(self.shape.split(" x "))

    @property
    def follows(self) -> str:
        """The letter of the first axis if it counts joints or frames, such as `n` or `w`; empty for a fixed length."""
        return self.axes[0] if self.axes[0] in ("n", "m", "d", "s", "w", "b", "l") else ""


@dataclass(frozen=True)
class Intermediate:
    """Variables `<name><joint><component>` of generated code.

    `base`, `above` and `below` are the LaTeX of the symbol and of its indices, in which `@` is the joint, `#` the
    component, `<` and `>` its first and second letter. `definition` is the paper's symbol. The unit of an entry with
    two indices is that of its component and its joint, or of its row and its column. Where the same names have another
    meaning in other programs, `of_results` names results of the programs that the row is for.
    """

    name: str
    component: str
    base: str
    above: str
    below: str
    definition: str
    equations: tuple[int, ...]
    unit: Unit | PairUnit | None
    meaning: str
    of_results: tuple[str, ...] = ()
    role: Role = Role.INTERMEDIATE

    def symbol(self, joint: str = "j", component: str | None = None, part: str = "") -> str:
        """LaTeX of a component; `part` is the letter of a shared part of it."""
        index = (COMPONENTS[self.component][1] if component is None else component).replace("_", ",")
        above = "".join(x for x in (self.above, rf"\mathrm{{{part}}}" if part else "") if x)
        text = self.base + (f"^{{{above}}}" if above else "") + (f"_{{{self.below}}}" if self.below else "")
        return text.replace("<", index[:1]).replace(">", index[1:]).replace("#", index).replace("@", joint)

    def match(self, name: str) -> re.Match[str] | None:
        """Joint `j`, component `c` and `part` in a name of this row; None for other names."""
        return _pattern(self.name, self.component).fullmatch(name)


COMPONENTS = {
    "": ("", ""),
    "axis": ("_(?P<c>[xyz])", "x"),
    "square": ("_(?P<c>xx|yy|zz)", "xx"),
    "product": ("_(?P<c>xy|xz|yz)", "xy"),
    "six": ("_(?P<c>[1-6])", "k"),
    "entry": ("_(?P<c>[1-6]{2})", "mn"),
    "moment": ("_(?P<c>xx|xy|xz|yy|yz|zz)", "xx"),
    "quaternion": ("_(?P<c>[wxyz])", "w"),
    "rotation": ("(?<![A-Za-z]0)_(?P<c>[1-3]{2})", "mn"),
    "base rotation": ("(?<=[A-Za-z]0)_(?P<c>[1-3]{2})", "mn"),
    "number": (r"(?<![A-Za-z]0)_(?P<c>\d+)", "i"),
    "place": (r"_(?P<c>(?<![A-Za-z]0_)(?:0_)?\d+|(?<=[A-Za-z]0_)\d+_(?:0_)?\d+)", "i"),
    "row column": (r"_(?P<c>[1-6]_\d+)", "k_i"),
    "c": ("_c", ""),
    "c axis": ("_c_(?P<c>[xyz])", "x"),
    "c moment": ("_c(?P<c>xx|xy|xz|yy|yz|zz)", "xx"),
    "parameter": (r"_(?P<c>[A-Z]+\d+)", "X"),
    "theta": ("_theta", ""),
    "motor": ("_motor", ""),
    "spring": ("_spring", ""),
    "link": ("_link", ""),
    "compliance": ("_compliance", ""),
    "r": ("_r", ""),
    "loop": ("_loop", ""),
    "squared": ("_squared", ""),
    "inverse": ("_inverse", ""),
    "own": ("_x", ""),
}
"""Components of a name: their appearance, and the representative in a list of symbols."""


@cache
def _pattern(name: str, component: str) -> re.Pattern[str]:
    return re.compile(rf"{name}(?P<j>\d+){COMPONENTS[component][0]}(?P<part>[a-z]*)", re.ASCII)


def derivative(of: Quantity, by: Quantity, note: str = "") -> Quantity:
    """The derivatives of one quantity by another: `dtau_dq`, a row for each entry of tau, a column for each of q."""
    columns = by.as_column or by.name
    unit = of.unit / by.unit if isinstance(of.unit, Unit) and isinstance(by.unit, Unit) else None
    return Quantity(
        f"d{of.name}_d{by.name}",
        f"derivatives of {of.plural} by {columns}{note}",
        rf"[\partial{_with_space(of)}/\partial{_with_space(by)}]",
        unit,
        f"{of.shape} x {by.shape}",
        (Role.RESULT,),
        says_unit=False,
        is_derivative=True,
    )


def _with_space(quantity: Quantity) -> str:
    """LaTeX of a quantity that may follow a command: with a space before a letter, without one before a backslash."""
    return quantity.letter if quantity.letter.startswith("\\") else f" {quantity.letter}"


def time_derivative(of: Quantity, order: int, meaning: str) -> Quantity:
    """The derivative by time of some order, of a quantity in rad or m."""
    power = order if order > 1 else ""
    return replace(
        of,
        name=of.name + "d" * order,
        meaning=meaning,
        note="",
        unit=Unit(f"rad/s{power}", f"m/s{power}"),
        symbol=rf"{of.symbol}^{{({order})}}",
        entries=str(of.entries).replace("_0", f"_{order}"),
    )


def citation(equations: Iterable[int]) -> str:
    """Equation numbers as they are cited: `[28], [50]`."""
    return ", ".join(f"[{number}]" for number in equations)
