"""Machines with congruent limbs: a tree that is drawn, copied onto a trunk with other numbers and other signs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symoro_elastic.machine.columns import Cell, Dimension, with_cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from tests.references.random_machines import random_machine

OF_EITHER_SIGN = (Dimension.LENGTH, Dimension.FIRST_MOMENT)


def with_limbs(seed: int, copies: int, *, joints: int = 3, symbolic: bool = False) -> Machine:
    """A drawn trunk of two rows with so many copies of a drawn limb of `joints` rows on the second."""
    trunk = random_machine(seed, joints=2, branching=0, massless=0, wrenches=False, symbolic=symbolic)
    limb = random_machine(seed + 500, joints=joints, massless=0, wrenches=False, symbolic=symbolic)
    table, parameters = [*trunk.joints], [*trunk.parameters]
    for copy in range(copies):
        rng = np.random.default_rng([seed, copy])
        before = len(table)
        table += [_copied(joint, copy, before, rng) for joint in limb.joints]
        parameters += [
            Parameter(f"{p.name}_{copy}", Formula.parse(p.value.value() * rng.uniform(0.5, 1))) for p in limb.parameters
        ]
    return Machine(f"limbs{seed}", tuple(table), tuple(parameters), trunk.base)


def _copied(joint: Joint, copy: int, before: int, rng: np.random.Generator) -> Joint:
    """A row of a limb as one of its copy, after the rows `before`."""

    def changed(cell: Cell, formula: Formula) -> Formula:
        dimension = cell.column.dimension
        if formula.is_zero or dimension is Dimension.SHARE:
            return formula
        if formula.names:
            return Formula.parse(f"{formula}_{copy}")
        sign = rng.choice([-1, 1]) if dimension in (*OF_EITHER_SIGN, Dimension.ANGLE) else 1
        if dimension is Dimension.ANGLE:
            return Formula.parse(f"-({formula})") if sign < 0 else formula
        return Formula.parse(sign * formula.value() * rng.uniform(0.5, 1))

    number = before + int(joint.name.removeprefix("joint").removeprefix("frame"))
    return replace(
        with_cells(joint, changed),
        name=f"{joint.name}_{copy}",
        antecedent=joint.antecedent + before if joint.antecedent else 2,
        variable=joint.variable and f"q{number}",
    )
