"""The precisions in which C can be written: types of arrays, of arithmetic, and of sines and cosines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

LIBM = ("sin", "cos", "sqrt", "atan2")
DOUBLE_DOUBLE_TYPE = "dd"


@dataclass(frozen=True)
class Precision:
    """Number types of generated code: `state` of arrays, `real` of arithmetic, `angle` of sines and cosines.

    `bits` is the length of its significand; `short` is its name in names of files and functions, where that is another.
    """

    name: str
    title: str
    state: str
    real: str
    angle: str
    bits: int
    literal_suffix: str = ""
    functions: Mapping[str, str] = field(default_factory=dict)
    short: str = ""

    @property
    def suffix(self) -> str:
        """Suffix of the names of files and functions in this precision."""
        return "" if self is DOUBLE else "_" + (self.short or self.name.replace("-", "_"))

    def function(self, package: str, model: str) -> str:
        """The name in C of a model of a package."""
        return f"{package}_{model}_f32" if self is SINGLE else f"{package}{self.suffix}_{model}"

    def type_of_real(self, package: str) -> str:
        """The type of arithmetic in C: sums of two doubles have a type named after the package."""
        return f"{package}_{DOUBLE_DOUBLE_TYPE}" if self.is_pair else self.real

    def number(self, digits: str) -> str:
        """C literal of a number in the type of arithmetic, from its digits."""
        return digits + self.literal_suffix

    def number_of_state(self, digits: str) -> str:
        """C literal of a number that is combined with entries of arrays."""
        return f"{digits}f" if self.state == "float" else digits

    @property
    def is_pair(self) -> bool:
        """Whether numbers are sums of two doubles, whose operators are functions."""
        return self.real == "double_double"

    @property
    def is_mixed(self) -> bool:
        """Whether sines and cosines have another type than other numbers."""
        return self.real != self.angle

    @property
    def angle_bits(self) -> str:
        """The unsigned integer type with the size of a sine."""
        return "uint32_t" if self.angle == "float" else "uint64_t"

    @property
    def widest(self) -> int:
        """Maximum number of states that a batch computes side by side."""
        return {"float": 16, "double": 8, "double_double": 1}[self.real]


_FLOAT = {name: f"{name}f" for name in LIBM}

DOUBLE = Precision("double", "double precision", "double", "double", "double", 53)
SINGLE = Precision("single", "single precision", "float", "float", "float", 24, "f", _FLOAT)
MIXED = Precision(
    "mixed", "single precision, states and angles in double", "double", "float", "double", 24, "f", _FLOAT
)
DOUBLE_DOUBLE = Precision(
    "double-double", "sums of two doubles, states in double", "double", "double_double", "double_double", 106
)
PRECISIONS: dict[str, Precision] = {p.name: p for p in (DOUBLE, SINGLE, MIXED, DOUBLE_DOUBLE)}
