"""The state of a machine: one record of named blocks, and the rows of the blocks that a machine has.

A block is a quantity of the table with the role STATE: whoever adds a row there has its block in test states,
trajectories and calls of generated functions. What passes a state on does not ask which blocks it holds.
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
        """Its blocks among these names: the arguments of a generated function, say."""
        return {name: self.blocks[name] for name in names if name in self.blocks}

    def results(self, function: Callable[..., Any], **others: Array) -> tuple[Array, ...]:
        """Results of a generated function at the state, with further arguments."""
        known = self.only(signature(function).parameters)
        found = function(**{**known, **others})
        return found if isinstance(found, tuple) else (found,)

    @property
    def base(self) -> dict[str, Array]:
        """Its blocks that belong to a base that moves freely."""
        return self.only(row.name for row in ON_BASE)


def split_into(blocks: Mapping[str, Array], entries: Array) -> dict[str, Array]:
    """Blocks of the lengths of these ones, from arrays in which they stand one after the other."""
    ends = np.cumsum([block.shape[-1] for block in blocks.values()])
    return dict(zip(blocks, np.split(entries, ends[:-1], axis=-1), strict=True))


def rows_of_state(machine: Machine) -> tuple[Quantity, ...]:
    """Rows of all blocks that the state of a machine may have, including prescribed motions of its motors."""
    entries, fixed = arguments(machine), () if machine.degrees_of_base else ON_BASE
    rows = (row for row in QUANTITIES.values() if Role.STATE in row.roles and row not in fixed)
    return tuple(row for row in rows if row in OF_JOINTS or entries[row.name])


def rows_carried(machine: Machine) -> tuple[Quantity, ...]:
    """Rows of the blocks that a time step of a machine takes further."""
    left_out = {"R0" if orientation_of(machine) == "Q0" else "Q0"}
    left_out |= set() if lacks_closed_form(machine) else {DEPENDENT}
    left_out |= {row.name for row in ON_BASE} if "V0d" in known_of_base(machine) else set()
    rows = rows_of_state(machine)
    return tuple(row for row in rows if Role.CARRIED in row.roles and row.name not in left_out)


def orientation_of(machine: Machine) -> str:
    """The block that tells how the base of a machine is turned: Q0 or R0."""
    turned = machine.floating and machine.floating.orientation
    return "Q0" if turned is Orientation.QUATERNION else "R0"


def closing_models(machine: Machine) -> tuple[str, ...]:
    """The models that close the loops of a machine from a position nearby: none where all have closed forms."""
    return ("assemble",) if lacks_closed_form(machine) else ()


def position_blocks(machine: Machine) -> tuple[str, ...]:
    """Names of the blocks that tell functions of a machine where its joints are."""
    return ("q", DEPENDENT) if lacks_closed_form(machine) else ("q",)
