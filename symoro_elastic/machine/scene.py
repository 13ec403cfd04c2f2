"""A request to the generator: models, outputs, locked joints, folded parameters, gravity."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.within import EXACT, Within

ALL = "all"
RECURSION, INERTIA, AUTO = "recursion", "inertia", "auto"
FORMS = (RECURSION, INERTIA, AUTO)
"""Forms of the direct dynamic model: by recursion, by the inertia matrix, the faster one that is as accurate."""
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
"""Components of twists: along the axes, then about them."""
SEEN_FROM = " in "
AT = " at "
BY = " by "

Point = tuple[Formula, Formula, Formula]


class Parts(Enum):
    """Parts of a model's results that a scene may request.

    None where they belong to the machine as a whole; those of joints; of bodies; of frames, which may be seen from
    others; frames and their points; also single components of twists.
    """

    WHOLE = "whole"
    JOINTS = "joints"
    BODIES = "bodies"
    FRAMES = "frames"
    POINTS = "points"
    COMPONENTS = "components"


class Offer(Protocol):
    """Requests of a scene that a model accepts."""

    @property
    def parts(self) -> Parts:
        """The parts of the model's results that may be requested, such as those of joints, bodies or frames."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Arguments that derivatives are taken by."""


@dataclass(frozen=True)
class Scene:
    """Request for models of a machine; the empty scene requests the default models of the full machine.

    `outputs` maps a model's name to joint (or frame) names, a frame also as `RequestedPart` reads it:
    "tool in bed_x", "tool at (0.1, 0, L2)", columns of derivatives: "by M1, K2"; `locked` a joint's
    name to the value at which its variable is held; `static` likewise, of springs that are left out of the motion,
    None where they are held at their neutral position; `condense` makes one of springs in series with massless bodies
    between; `zero` are numbers of bodies and rotors and parts of drives that are left out, as `zeroed.py` names them;
    `forces` are frames with wrenches as arguments of models; `fold` lists parameters that become
    constants, or is `ALL`. `merge_angles` is the largest angle, rad, up to which sums of angles may replace products
    of sines and cosines.
    `steps` are additional time steps, of `TimeStep`. `form` is one of `FORMS`. `within` are tolerances that
    terms are left out within.
    `source` is the file of the request, if it has its own.
    """

    models: tuple[str, ...] = ()
    outputs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    locked: dict[str, Formula] = field(default_factory=dict)
    static: dict[str, Formula | None] = field(default_factory=dict)
    condense: bool = False
    zero: tuple[str, ...] = ()
    forces: tuple[str, ...] = ()
    fold: tuple[str, ...] | str = ()
    gravity: bool = True
    merge_angles: float | None = None
    steps: tuple[str, ...] = ()
    form: str = RECURSION
    within: Within = EXACT
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        """Raise `ValueError` if only some of the static joints have a position, which files cannot express."""
        if None in self.static.values() and any(self.static.values()):
            raise ValueError("give the positions of all static joints, or of none: held_positions completes them")


@dataclass(frozen=True)
class RequestedPart:
    """A requested joint or frame: its name, a point of its body, the frame it is seen from.

    Written "tool", "tool at (0.1, 0, L2)", "tool in bed_x", "tool at (0.1, 0, L2) in base"; `FrameNames` reads the
    names. The point has three coordinates in the frame's own axes, m, numbers or formulas of parameters.
    Of inverse kinematic models, "tool.x" or "tool.rz at (0.1, 0, L2) in base" asks for one component of the twist.
    Of derivatives, "by M1, K2" asks for the columns that belong to these names; "tool by M1" for a
    row and a column.
    """

    name: str
    at: Point | None = None
    seen_from: str | None = None
    by: tuple[str, ...] = ()
    component: str = ""

    @classmethod
    def parse(cls, text: str) -> RequestedPart:
        """Parse a requested joint or frame; raises `FormulaError`."""
        text, *by = f" {text}".split(BY)
        names = tuple(name.strip() for name in by[0].split(",")) if by else ()
        if len(by) > 1 or not all(names):
            raise FormulaError("write one list of names, as in 'by M1, K2'")
        first, *seen_from = text.split(SEEN_FROM)
        if len(seen_from) > 1:
            raise FormulaError("write one frame in one other")
        name, *at = first.split(AT)
        if len(at) > 1:
            raise FormulaError("write a single point of a frame")
        point, place = _point(at[0].strip()) if at else None, seen_from[0].strip() if seen_from else None
        frame, dot, component = name.strip().partition(".")
        if dot and component not in COMPONENTS:
            raise FormulaError(f"write a component as one of {', '.join(COMPONENTS)}, as in 'tool.x'")
        return cls(frame, point, place, tuple(dict.fromkeys(names)), component)

    def __str__(self) -> str:
        at = f"{AT}({', '.join(map(str, self.at))})" if self.at else ""
        seen_from = f"{SEEN_FROM}{self.seen_from}" if self.seen_from else ""
        component = f".{self.component}" if self.component else ""
        return (self.name + component + at + seen_from + (f"{BY}{', '.join(self.by)}" if self.by else "")).strip()


def _point(text: str) -> Point:
    cells = list(_cells(text[1:-1])) if text.startswith("(") and text.endswith(")") else []
    if len(cells) != 3:
        raise FormulaError("a point has three coordinates in brackets, as in 'tool at (0.1, 0, L2)'")
    x, y, z = (Formula.parse(" ".join(cell.split())) for cell in cells)
    return x, y, z


def _cells(text: str) -> Iterator[str]:
    """Parts of a text between commas outside brackets."""
    start = depth = 0
    for position, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if character == "," and depth == 0:
            yield text[start:position]
            start = position + 1
    yield text[start:]
