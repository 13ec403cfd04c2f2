"""Input of targets: a machine's names and functions, in terms of code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symoro_elastic.codegen.fixed_point import FixedPoint
from symoro_elastic.codegen.guaranteed import Guaranteed
from symoro_elastic.quantities import ON_BASE, Quantity
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import Program

EXTERNAL = "f_ext"
"""Name of the wrenches on frames."""


@dataclass(frozen=True)
class Axis:
    """An entry of q: the joint's name, kind and unit."""

    name: str
    kind: str
    unit: str


@dataclass(frozen=True)
class ParameterValue:
    """An entry of p; `value` is NaN without a value in the machine. `local` is its variable if `name` is reserved."""

    name: str
    value: float
    unit: str
    local: str = ""

    @property
    def symbol(self) -> str:
        """Name of the parameter's variable in statements."""
        return self.local or self.name


@dataclass(frozen=True)
class _Array:
    quantity: Quantity

    @property
    def name(self) -> str:
        """Name of the quantity."""
        return self.quantity.name

    @property
    def meaning(self) -> str:
        """Meaning of the quantity, with its unit."""
        return self.quantity.sentence


@dataclass(frozen=True)
class Argument(_Array):
    """An array of a function's signature: its quantity, and the entries along its last axis."""

    size: int


@dataclass(frozen=True)
class Result(_Array):
    """An array result: quantity, shape, and the names along its first and last axes.

    `whole` is False where its rows are those that a scene has chosen.
    """

    shape: tuple[int, ...]
    rows: tuple[str, ...]
    columns: tuple[str, ...] = ()
    whole: bool = True


@dataclass(frozen=True)
class Constant:
    """A named number of the machine: its joint (None: of the machine itself), meaning and unit."""

    name: str
    value: Operand
    joint: int | None
    meaning: str
    unit: str


@dataclass(frozen=True)
class Function:
    """A generated function; `constants` are named numbers that its statements may hold.

    `divides`: it divides by inertias, which may be zero somewhere; `least_bits` is the precision that it needs.
    `guaranteed` is, by precision, what holds where its arguments are in a box, if that was asked for; `fixed` are the
    scales of its numbers, if they are proven. `placed` is the frame that an inverse geometric model places.
    """

    name: str
    title: str
    equations: str
    program: Program
    arguments: tuple[Argument, ...]
    results: tuple[Result, ...]
    divides: bool = False
    least_bits: int = 0
    constants: tuple[Constant, ...] = ()
    guaranteed: Mapping[str, Guaranteed] = field(default_factory=dict, repr=False)
    fixed: FixedPoint | None = field(default=None, repr=False)
    placed: str = field(default="", repr=False)

    @property
    def columns(self) -> tuple[str, ...]:
        """The labels of columns, if all results that have some agree."""
        labels = {result.columns for result in self.results if result.columns}
        return labels.pop() if len(labels) == 1 else ()


@dataclass(frozen=True)
class Package:
    """All that is generated for one machine: its functions, parameters and names.

    `joint_names` are the rows of its table, then points that are asked for; `antecedents` are the numbers (from 1) of
    the rows that they stand on, 0 for the base. `source` is the name of the machine's file, `options` are what else
    shaped the code. Where joints are coupled `dependent` are joints that loops move and `driven` those of tau; they are
    None for a tree, whose motors all own entries of q: `motors` are their indices. `following` are kinds of the rows
    without a variable of their own that move, by name. `steps` names the methods of time steps, `state` the blocks that
    they advance; `only` is the suffix of the only variant of motor inputs, None for all variants. `states`
    are names of z: states of friction, then those of drives, which only some functions have.
    """

    name: str
    scene: str
    axes: tuple[Axis, ...]
    motors: tuple[int, ...]
    elastic: tuple[int, ...]
    frames: tuple[str, ...]
    joint_names: tuple[str, ...]
    parameters: tuple[ParameterValue, ...]
    functions: tuple[Function, ...]
    antecedents: tuple[int, ...] = ()
    source: str = ""
    options: tuple[str, ...] = ()
    dependent: tuple[Axis, ...] | None = None
    driven: tuple[Axis, ...] | None = None
    following: tuple[tuple[str, str], ...] = ()
    steps: tuple[str, ...] = ()
    state: tuple[Argument, ...] = ()
    only: str | None = None
    states: tuple[str, ...] = ()
    limbs: tuple[tuple[int, ...], ...] = ()
    congruent: tuple[tuple[str, ...], ...] = ()

    def __repr__(self) -> str:
        """Return one line that names the machine and the functions."""
        return f"<Package {self.name}: {', '.join(function.name for function in self.functions)}>"

    @property
    def assembled(self) -> tuple[Argument, ...]:
        """The blocks of the state that belong to loops without a closed form."""
        return tuple(block for block in self.state if block.quantity.follows == "d")

    @property
    def base(self) -> tuple[Argument, ...]:
        """The blocks of the state of a base that moves freely: orientation, position, velocity."""
        return tuple(block for block in self.state if block.quantity in ON_BASE)

    @property
    def external(self) -> int:
        """Number of entries of the wrenches on frames; 0 without such an argument."""
        sizes = (a.size for function in self.functions for a in function.arguments if a.name == EXTERNAL)
        return next(sizes, 0)

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the joints of all motors: the entries of tau."""
        return tuple(axis.name for axis in self.driven or map(self.axes.__getitem__, self.motors))

    @property
    def has_motors_in_q(self) -> bool:
        """Whether every motor owns an entry of q."""
        return len(self.motors) == len(self.motor_names)

    def inputs(self, function: Function) -> dict[str, int]:
        """Sizes of the inputs of a function by name, in order; `p` is the last, even if no parameter remains."""
        return {argument.name: argument.size for argument in function.arguments} | {"p": len(self.parameters)}
