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
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.model import KNOWN, ORIENTATION, Joints, Model, Result, Results
from symoro_elastic.models.rules import base_rule
from symoro_elastic.models.state import orientation_of

BASE_ROWS = (0,) * 6


def on_its_base(model: Model, machine: Machine) -> Model:
    """The model with the arguments and results that a floating base adds; as it is where there is none."""
    if not machine.degrees_of_base or model.on_base is None:
        return model
    (known,) = known_of_base(machine)
    chosen, found = {ORIENTATION: orientation_of(machine), KNOWN: known}, "V0d" if known == "f0" else "f0"
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


def found_of_base(bound: Bound, found: Dynamics) -> Results:
    """The acceleration of a base on which the wrench is known, or the wrench that its known acceleration needs."""
    if not bound.machine.degrees_of_base:
        return {}
    if base_rule(bound) is None:
        return _six("f0", found.f[0])
    return _six("V0d", Twist(found.vd[0] + bound.gravity, found.wd[0]))


def solution_with_base(
    bound: Bound, factors: Factorization, matrix: InertiaMatrix, held: Dynamics, right: Mapping[int, Scalar]
) -> tuple[dict[int, Scalar], Results]:
    """Solution qdd of A qdd = Gamma - H [8], and the unknown of the base.

    `held` is without accelerations of the joints, and of a base on which the wrench is known.
    """
    rule = base_rule(bound)
    if rule is None:
        qdd = solution(factors, right)
        return qdd, _six("f0", wrench_on_base(matrix, held.f[0], qdd)) if bound.machine.degrees_of_base else {}
    base, qdd = free_solution(factors, matrix, rule.wrench - held.f[0], right)
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
    rows = BASE_ROWS if bound.machine.degrees_of_base else ()
    return Result((*rows, *asked), (*rows, *of_joints))


def inertia(bound: Bound, found: InertiaMatrix, asked: Joints) -> Result:
    """A(q): six rows and columns of the base before those of the joints."""
    rows = [[found.A[i][j] for j in asked] for i in asked]
    if not bound.machine.degrees_of_base:
        return Result(asked, tuple(x for row in rows for x in row), (len(asked),))
    columns = [found.base[j].entries for j in asked]
    base = found.composite[0].spatial.rows
    whole = [[*row, *(column[k] for column in columns)] for k, row in enumerate(base)]
    whole += [[*column, *row] for column, row in zip(columns, rows, strict=True)]
    return Result((*BASE_ROWS, *asked), tuple(x for row in whole for x in row), (6 + len(asked),))
