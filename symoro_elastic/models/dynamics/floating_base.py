"""Models of a machine on a floating base: arguments and results of its six degrees of freedom."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.machine.arguments import PARAMETERS, columns_of_base, known_of_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.factorization import Factorization, solution
from symoro_elastic.mechanics.lagrange import InertiaMatrix, free_solution, wrench_on_base
from symoro_elastic.mechanics.spatial import Scalar, SpatialVector, Twist
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import KNOWN, ORIENTATION, Joints, Model, Result, Results
from symoro_elastic.models.bound.rules import base_rule
from symoro_elastic.models.bound.state import orientation_of

BASE_ROWS = (0,) * 6


def on_its_base(model: Model, machine: Machine) -> Model:
    """The model with the arguments and results that a floating base adds; unchanged on a fixed base."""
    if not machine.degrees_of_base or model.on_base is None:
        return model
    (argument,) = known_of_base(machine)
    chosen, unknown = {ORIENTATION: orientation_of(machine), KNOWN: argument}, "V0d" if argument == "f0" else "f0"
    arguments = (*model.arguments, *(chosen.get(name, name) for name in model.on_base))
    if KNOWN not in model.on_base:
        return replace(model, arguments=arguments)
    results = _derivatives(model, machine, unknown) if model.columns else (*model.results, unknown)
    return replace(model, arguments=arguments, results=results)


def _derivatives(model: Model, machine: Machine, unknown: str) -> tuple[str, ...]:
    """Names of the derivatives of a model, with those of and by quantities of a floating base."""
    names = [name.partition("_") for name in model.results]
    on_base = () if PARAMETERS in model.columns else columns_of_base(machine)
    columns = (*(by for *_, by in names), *(f"d{name}" for name in on_base))
    rows = (*(of for of, *_ in names), f"d{unknown}")
    return tuple(f"{of}_{by}" for of in dict.fromkeys(rows) for by in dict.fromkeys(columns))


def found_of_base(bound: Bound, recursion: Dynamics) -> Results:
    """The unknown of a floating base: its acceleration, or the wrench that a known acceleration requires."""
    if not bound.machine.degrees_of_base:
        return {}
    if base_rule(bound) is None:
        return _six("f0", recursion.f[0])
    return _six("V0d", Twist(recursion.vd[0] + bound.gravity, recursion.wd[0]))


def solution_with_base(
    bound: Bound, factors: Factorization, matrix: InertiaMatrix, recursion: Dynamics, right: Mapping[int, Scalar]
) -> tuple[dict[int, Scalar], Results]:
    """Solution qdd of A qdd = Gamma - H [8], and the unknown of the base.

    `recursion` has zero accelerations of the joints, and of a base with a known wrench.
    """
    rule = base_rule(bound)
    if rule is None:
        qdd = solution(factors, right)
        return qdd, _six("f0", wrench_on_base(matrix, recursion.f[0], qdd)) if bound.machine.degrees_of_base else {}
    base, qdd = free_solution(factors, matrix, rule.wrench - recursion.f[0], right)
    return qdd, _six("V0d", base)


def _six(name: str, V: SpatialVector) -> Results:
    return {name: Result(None, V.entries, (6,))}


def forces(recursion: Dynamics, joints: Joints, of_joints: tuple[Scalar, ...]) -> Result:
    """Forces of the joints, after the wrench on a base that is part of the machine."""
    if 0 not in recursion.f:
        return Result(joints, of_joints)
    return Result((*BASE_ROWS, *joints), (*recursion.f[0].entries, *of_joints))


def inertia(bound: Bound, matrix: InertiaMatrix, joints: Joints) -> Result:
    """A(q): six rows and columns of the base before those of the joints."""
    rows = [[matrix.A[i][j] for j in joints] for i in joints]
    if not bound.machine.degrees_of_base:
        return Result(joints, tuple(x for row in rows for x in row), (len(joints),))
    columns = [matrix.base[j].entries for j in joints]
    base = matrix.composite[0].spatial.rows
    rows_with_base = [[*row, *(column[k] for column in columns)] for k, row in enumerate(base)]
    rows_with_base += [[*column, *row] for column, row in zip(columns, rows, strict=True)]
    return Result((*BASE_ROWS, *joints), tuple(x for row in rows_with_base for x in row), (6 + len(joints),))
