"""Models of a machine on a floating base: arguments and results of its six degrees of freedom."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.machine.arguments import PARAMETERS, columns_of_base
from symoro_elastic.machine.machine import Floating, Given, Machine, Orientation
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.factorization import Factorization, solution
from symoro_elastic.mechanics.lagrange import InertiaMatrix, free_solution, wrench_on_base
from symoro_elastic.mechanics.spatial import Scalar, SpatialVector, Twist
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import KNOWN, ORIENTATION, Joints, Model, Result, Results

BASE_ROWS = (0,) * 6


def on_its_base(model: Model, machine: Machine) -> Model:
    """The model with the arguments and results that a floating base adds; as it is where there is none."""
    floating = machine.floating
    if floating is None or model.on_base is None:
        return model
    chosen, found = _chosen(floating)
    arguments = (*model.arguments, *(chosen.get(name, name) for name in model.on_base))
    if KNOWN not in model.on_base:
        return replace(model, arguments=arguments)
    results = _derivatives(model, machine, found) if model.columns else (*model.results, found)
    return replace(model, arguments=arguments, results=results)


def _derivatives(model: Model, machine: Machine, found: str) -> tuple[str, ...]:
    """Results of a model of derivatives with those of the base."""
    names = [name.partition("_") for name in model.results]
    on_base = () if PARAMETERS in model.columns else columns_of_base(machine)
    columns = (*(by for *_, by in names), *(f"d{name}" for name in on_base))
    rows = (*(of for of, *_ in names), f"d{found}")
    return tuple(f"{of}_{by}" for of in dict.fromkeys(rows) for by in dict.fromkeys(columns))


def _chosen(floating: Floating) -> tuple[dict[str, str], str]:
    """Names of the arguments that a file chooses, and of the result that goes with them."""
    orientation = "Q0" if floating.orientation is Orientation.QUATERNION else "R0"
    known, found = ("V0d", "f0") if floating.known is Given.ACCELERATION else ("f0", "V0d")
    return {ORIENTATION: orientation, KNOWN: known}, found


def found_of_base(bound: Bound, found: Dynamics) -> Results:
    """The acceleration of a base on which the wrench is known, or the wrench that its known acceleration needs."""
    if bound.machine.floating is None:
        return {}
    if bound.base_rule is None:
        return _six("f0", found.f[0])
    return _six("V0d", Twist(found.vd[0] + bound.gravity, found.wd[0]))


def solved(
    bound: Bound, factors: Factorization, matrix: InertiaMatrix, held: Dynamics, right: Mapping[int, Scalar]
) -> tuple[dict[int, Scalar], Results]:
    """Solution qdd of A qdd = Gamma - H [8], and the unknown of the base.

    `held` is without accelerations of the joints, and of a base on which the wrench is known.
    """
    if bound.base_rule is None:
        qdd = solution(factors, right)
        return qdd, _six("f0", wrench_on_base(matrix, held.f[0], qdd)) if bound.machine.floating else {}
    base, qdd = free_solution(factors, matrix, bound.base_rule.wrench - held.f[0], right)
    return qdd, _six("V0d", base)


def _six(name: str, V: SpatialVector) -> Results:
    return {name: Result(None, V.entries, (6,))}


def forces(found: Dynamics, asked: Joints, of_joints: tuple[Scalar, ...]) -> Result:
    """Forces of the joints, after the wrench on a base that is part of the machine."""
    if 0 not in found.f:
        return Result(asked, of_joints)
    return Result((*BASE_ROWS, *asked), (*found.f[0].entries, *of_joints))


def without_force_on_base(bound: Bound, asked: Joints, of_joints: tuple[Scalar, ...]) -> Result:
    """Forces of the joints that do not act on the base."""
    rows = BASE_ROWS if bound.machine.floating else ()
    return Result((*rows, *asked), (*rows, *of_joints))


def inertia(bound: Bound, found: InertiaMatrix, asked: Joints) -> Result:
    """A(q): six rows and columns of a floating base before those of the joints."""
    rows = [[found.A[i][j] for j in asked] for i in asked]
    if bound.machine.floating is None:
        return Result(asked, tuple(x for row in rows for x in row), (len(asked),))
    columns = [found.base[j].entries for j in asked]
    base = found.composite[0].spatial.rows
    whole = [[*row, *(column[k] for column in columns)] for k, row in enumerate(base)]
    whole += [[*column, *row] for column, row in zip(columns, rows, strict=True)]
    return Result((*BASE_ROWS, *asked), tuple(x for row in whole for x in row), (6 + len(asked),))
