"""The state of a machine: one record of named blocks, and the rows of the blocks that a machine has.

A block is a quantity of the table with the role STATE: whoever adds a row there has its block in test states,
trajectories and calls of generated functions. Code that passes a state on does not depend on its blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any, Self

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.machine.arguments import arguments, known_of_base
from symoro_elastic.machine.machine import Machine, Orientation
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.quantities import OF_JOINTS, ON_BASE, QUANTITIES, Quantity, Role

DEPENDENT = "q_dep"
"""The block of loops without a closed form."""


@dataclass(frozen=True)
class State:
    """Blocks by name: samples along the first axis, entries along the last one, SI units, radians.

    A block is an attribute, `state.qd`; one that a machine does not have is without entries.
    """

    blocks: Mapping[str, Array]

    def __getattr__(self, name: str) -> Array:
        blocks: Mapping[str, Array] = self.__dict__.get("blocks", {})
        if name in blocks:
            return blocks[name]
        if name not in QUANTITIES or Role.STATE not in QUANTITIES[name].roles:
            raise AttributeError(name)
        return next(iter(blocks.values()))[..., :0]

    def __len__(self) -> int:
        return len(next(iter(self.blocks.values()), ()))

    def __getitem__(self, samples: Any) -> Self:
        """The state at some samples, or at one, then without the axis of samples."""
        return self.map(lambda block: block[samples])

    def map(self, change: Callable[[Array], AnyArray]) -> Self:
        """The state with every block changed."""
        return replace(self, blocks={name: change(block) for name, block in self.blocks.items()})

    def with_blocks(self, **blocks: Array) -> Self:
        """The state with these blocks in place of its own, or in addition."""
        return replace(self, blocks={**self.blocks, **blocks})

    def only(self, names: Iterable[str]) -> dict[str, Array]:
        """The blocks of the state with these names, such as the arguments of a generated function."""
        return {name: self.blocks[name] for name in names if name in self.blocks}

    def results(self, function: Callable[..., Any], **others: Array) -> tuple[Array, ...]:
        """Results of a generated function at the state, with further arguments."""
        blocks = self.only(signature(function).parameters)
        results = function(**{**blocks, **others})
        return results if isinstance(results, tuple) else (results,)

    @property
    def base(self) -> dict[str, Array]:
        """The blocks of the state that belong to a base that moves freely."""
        return self.only(row.name for row in ON_BASE)


def split_into(blocks: Mapping[str, Array], entries: Array) -> dict[str, Array]:
    """Split concatenated entries into blocks with the names and lengths of `blocks`."""
    ends = np.cumsum([block.shape[-1] for block in blocks.values()])
    return dict(zip(blocks, np.split(entries, ends[:-1], axis=-1), strict=True))


def rows_of_state(machine: Machine) -> tuple[Quantity, ...]:
    """Quantities of all blocks that the state of a machine may have, with prescribed motions of its motors."""
    entries, fixed = arguments(machine), () if machine.degrees_of_base else ON_BASE
    rows = (row for row in QUANTITIES.values() if Role.STATE in row.roles and row not in fixed)
    return tuple(row for row in rows if row in OF_JOINTS or entries[row.name])


def rows_carried(machine: Machine) -> tuple[Quantity, ...]:
    """Quantities of the blocks that time steps of a machine integrate."""
    left_out = {"R0" if orientation_of(machine) == "Q0" else "Q0"}
    left_out |= set() if lacks_closed_form(machine) else {DEPENDENT}
    left_out |= {row.name for row in ON_BASE} if "V0d" in known_of_base(machine) else set()
    rows = rows_of_state(machine)
    return tuple(row for row in rows if Role.CARRIED in row.roles and row.name not in left_out)


def orientation_of(machine: Machine) -> str:
    """Name of the block with the orientation of the base: Q0 or R0."""
    orientation = machine.floating and machine.floating.orientation
    return "Q0" if orientation is Orientation.QUATERNION else "R0"


def closing_models(machine: Machine) -> tuple[str, ...]:
    """Names of the models that close loops from a nearby position; empty where all have closed forms."""
    return ("assemble",) if lacks_closed_form(machine) else ()


def position_blocks(machine: Machine) -> tuple[str, ...]:
    """Names of the blocks with joint positions: q, and q_dep where loops lack closed forms."""
    return ("q", DEPENDENT) if lacks_closed_form(machine) else ("q",)
