"""What is asked of a machine: models, outputs, locked joints, folded parameters, gravity or none."""

from __future__ import annotations

from dataclasses import dataclass, field

from symoro_elastic.machine.formula import Formula

ALL = "all"
BASE = "base"
SEEN_FROM = " in "


@dataclass(frozen=True)
class Scene:
    """A request; the empty scene asks for the default models of the whole machine.

    `outputs` maps a model's name to joint (or frame) names, a frame also as "tool in bed_x" or
    "tool in base", the frame from which it is seen; `locked` a joint's name to the value
    at which its variable is held; `fold` lists parameters that become constants, or is `ALL`.
    """

    models: tuple[str, ...] = ()
    outputs: dict[str, tuple[str, ...]] = field(default_factory=dict)
    locked: dict[str, Formula] = field(default_factory=dict)
    fold: tuple[str, ...] | str = ()
    gravity: bool = True
