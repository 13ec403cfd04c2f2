"""The machine with the values that were identified, for files and other commands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.equations.regressor import INERTIA, INERTIAL, MOMENTS
from symoro_elastic.identification.identify import Identification
from symoro_elastic.identification.regression import has_body
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import BASE_PARAMETERS, Body, Friction, Joint, Kind, Machine, Spring
from symoro_elastic.machine.scene import ALL, Scene


def identified(result: Identification, values: Mapping[str, float] | None = None) -> tuple[Machine, list[str]]:
    """Return the machine with the estimates in place of inertial parameters, friction and springs, and warnings.

    Inertial parameters are those of groups, so bodies are not real ones: torques are right. Parameters that joined
    others or have no effect are zero, and so are those that were not found, for what they exert is within the others;
    friction and springs that were not found keep the values of the file. Masses, friction and the like that came out
    negative are zero, for no machine has that. `values` are those of named parameters.
    """
    machine, found, warnings = result.machine, _values(result), []
    joints = []
    for j, joint in enumerate(machine.joints, start=1):
        possible, negative = _possible(_with(joint, j, found), j)
        joints.append(possible)
        warnings += [f"saved as 0: {label} = {x:.4g}, no machine has that: --known {label}=0" for label, x in negative]
    bare = replace(machine, joints=tuple(joints), extras={**machine.extras, BASE_PARAMETERS: "true"})
    before, after = ({name for _, formula in formulas(x) for name in formula.names} for x in (machine, bare))
    given = [
        replace(p, value=Formula.parse(values[p.name])) if values and p.name in values else p
        for p in machine.parameters
        if p.name not in before - after
    ]
    scene = None if machine.scene is None else _without(machine.scene, before - after)
    return replace(bare, parameters=tuple(given), scene=scene), warnings


def _values(result: Identification) -> dict[str, float]:
    """Return values by label: estimates, and those that were known."""
    columns, equations = result.equations.Y.columns, result.equations
    found = {columns[c].label: value for c, value in equations.known.items()}
    X = result.estimation.solution.X
    for value, c in zip(X, result.estimation.grouping.kept, strict=True):
        found[columns[equations.kept[c]].label] = float(value)
    return found


def _with(joint: Joint, j: int, found: Mapping[str, float]) -> Joint:
    """Return a joint with the values found, by label."""
    if has_body(joint.body):
        inertial = {name: Formula.parse(found.get(f"{name}{j}", 0.0)) for name in INERTIAL}
        mx, my, mz = (inertial[name] for name in MOMENTS)
        xx, xy, xz, yy, yz, zz = (inertial[name] for name in INERTIA)
        joint = replace(joint, body=Body(inertial["M"], (mx, my, mz), (xx, xy, xz, yy, yz, zz)))
    if joint.sigma == 2:
        return joint

    def cell(label: str, otherwise: Formula) -> Formula:
        return Formula.parse(found[f"{label}{j}"]) if f"{label}{j}" in found else otherwise

    rotor = Formula.parse(found.get(f"IA{j}", 0.0))
    friction = Friction(cell("FV", joint.friction.viscous), cell("FS", joint.friction.coulomb))
    if joint.kind is Kind.ELASTIC:
        if f"DA{j}" in found:
            friction = replace(friction, viscous=Formula.parse(0))
        law = joint.spring
        joint = replace(
            joint, spring=Spring(cell("K", law.stiffness), cell("DA", law.damping), _neutral(joint, j, found))
        )
    return replace(joint, rotor_inertia=rotor, friction=friction)


def _possible(joint: Joint, j: int) -> tuple[Joint, list[tuple[str, float]]]:
    """Return a joint with zeros for values that must not be negative, and their labels and values."""
    negative = []

    def cell(cell: Cell, formula: Formula) -> Formula:
        if formula.names or formula.value() >= 0 or not cell.column.dimension.is_nonnegative:
            return formula
        negative.append((f"{cell.par}{j}", formula.value()))
        return Formula.parse(0)

    return with_cells(joint, cell), negative


def _neutral(joint: Joint, j: int, found: Mapping[str, float]) -> Formula:
    """Return q0 = KQ / K, or the value of the file where they were not found."""
    force, stiffness = found.get(f"KQ{j}", math.nan), found.get(f"K{j}", math.nan)
    return Formula.parse(force / stiffness) if math.isfinite(force) and abs(stiffness) > 0 else joint.spring.neutral


def _without(scene: Scene, gone: set[str]) -> Scene:
    """Return the scene without constants that the machine no longer has."""
    return scene if scene.fold == ALL else replace(scene, fold=tuple(name for name in scene.fold if name not in gone))
