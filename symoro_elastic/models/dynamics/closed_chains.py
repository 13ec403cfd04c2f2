"""Models of machines whose joints are coupled: dependent variables, assembly, S and gam, forces of constraints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar, sum_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Joints, Model, Result, Results
from symoro_elastic.models.bound.naming import name_dynamics, name_geometry
from symoro_elastic.models.bound.rules import coupling_forces, given_rules, loop_forces
from symoro_elastic.models.loops.coordinates import name_newton_step
from symoro_elastic.symbolic.differentiation import substitute
from symoro_elastic.symbolic.functions import square_root
from symoro_elastic.symbolic.program import Section

NEWTON_STEPS = 5


def of_closed_chain(model: Model, bound: Bound, results: Results) -> Model:
    """The model with the arguments and results that it has on a coupled machine.

    Velocities of joints follow from q and qd; dependent variables without closed form are an argument after q.
    """
    arguments = model.arguments
    if "qd" in arguments and "q" not in arguments:
        arguments = ("q", *arguments)
    if bound.assembled and "q" in arguments and "q_dep" not in arguments:
        k = arguments.index("q") + 1
        arguments = (*arguments[:k], "q_dep", *arguments[k:])
    if model.has_loop_forces and any(j in bound.machine.dependent for j in bound.motors):
        arguments = (*arguments, "tau")
    return replace(model, arguments=arguments, results=tuple(results))


def _dependent_coordinates(bound: Bound, _: Joints) -> Results:
    _refuse_without_couplings(bound, "dependent_coordinates")
    _name_geometry(bound)
    owners = bound.machine.with_variable
    return {"x": Result(owners, tuple(bound.variables[j] for j in owners))}


def _coupling_matrix(bound: Bound, _: Joints) -> Results:
    _refuse_without_couplings(bound, "coupling_matrix")
    _name_geometry(bound)
    coordinates, joints, independent = bound.coordinates, bound.machine.articulated, bound.machine.independent
    entries = tuple(coordinates.S[j].get(k, 0) for j in joints for k in independent)
    return {
        "S": Result(joints, entries, (len(independent),)),
        "gam": Result(joints, tuple(coordinates.gam[j] for j in joints)),
    }


def _assemble(bound: Bound, _: Joints) -> Results:
    """Dependent variables by a fixed number of steps of Newton's method, from a guess (L18)."""
    if not bound.assembled:
        what = "no loop needs it, for the dependent variables have closed forms: ask for dependent_coordinates"
        raise bound.machine.error("assemble", what)
    errors, steps = _newton_step(bound)
    names = [str(bound.machine.joint(j).variable) for j in bound.assembled]
    positions: Sequence[Scalar] = [bound.variables[j] for j in bound.assembled]
    for step in range(1, NEWTON_STEPS + 1):
        moves = substitute(bound.graph, steps, dict(zip(names, positions, strict=True)))
        positions = [x - move for x, move in zip(positions, moves, strict=True)]
        name_newton_step(bound.names, step, dict(zip(bound.assembled, positions, strict=True)))
    position = dict(zip(names, positions, strict=True))
    errors_left = substitute(bound.graph, errors, position)
    closed = [bound.variables[j] for j in bound.machine.dependent]
    return {
        "q_dep": Result(bound.machine.dependent, tuple(substitute(bound.graph, closed, position))),
        "residual": Result(None, (square_root(bound.graph, sum_of(x * x for x in errors_left)),), (1,)),
    }


def _newton_step(bound: Bound) -> tuple[list[Scalar], list[Scalar]]:
    """Closing errors in the selected rows, and W_d^-1 times them, block by block (L18)."""
    steps: dict[int, Scalar] = {}
    errors: list[Scalar] = []
    for block in bound.coordinates.assembled_blocks:
        error = bound.coordinates.errors_of(block)
        (step,) = solve(bound.coordinates.columns_of(block), [error])
        steps |= zip(bound.coordinates.unknown(block), step, strict=True)
        errors += error
    return errors, [steps[j] for j in bound.assembled]


def _constraint_forces(bound: Bound, _: Joints) -> Results:
    """Forces of loops and couplings in a motion: S^T rho = 0, W_d^T mu = rho_d (L32)."""
    _refuse_without_couplings(bound, "constraint_forces")
    recursion = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    name_dynamics(bound, recursion, "[15]", "[61]")
    results: Results = {}
    wrenches = loop_forces(bound, recursion)
    if bound.machine.loops:
        entries = tuple(x for loop in bound.machine.loops for x in wrenches[loop.name].entries)
        results["mu"] = Result(None, entries, (len(bound.machine.loops), 6))
    forces = coupling_forces(bound, recursion, wrenches)
    if forces:
        results["lam"] = Result(tuple(forces), tuple(forces.values()))
    if not results:
        what = "there is no loop, and every joint has a variable of its own, which nothing constrains: leave it out"
        raise bound.machine.error("constraint_forces", what)
    return results


def _name_geometry(bound: Bound) -> None:
    """Name cosines and sines by their joint where loops close."""
    if bound.loops:
        name_geometry(bound, lambda j: Section("Geometry", j, "[1]"))


def _refuse_without_couplings(bound: Bound, model: str) -> None:
    machine: Machine = bound.machine
    if not machine.is_coupled:
        raise machine.error(model, "no joint depends on another here, by a coupling or a loop: leave the model out")


CLOSED_CHAINS = (
    Model(
        "dependent_coordinates",
        "joint coordinates of all joints",
        "(L1), (L12)-(L17)",
        ("q",),
        ("x",),
        _dependent_coordinates,
        Parts.WHOLE,
    ),
    Model(
        "coupling_matrix",
        "velocities and accelerations of all joints from those of the independent variables",
        "(L2), (L10), (L11)",
        ("q", "qd"),
        ("S", "gam"),
        _coupling_matrix,
        Parts.WHOLE,
    ),
    Model(
        "assemble",
        "dependent variables from a guess: five steps of Newton's method",
        "(L18)",
        ("q", "q_dep"),
        ("q_dep", "residual"),
        _assemble,
        Parts.WHOLE,
    ),
    Model(
        "constraint_forces",
        "forces of loops and couplings",
        "(L32), (L33)",
        ("q", "qd", "qdd"),
        ("mu", "lam"),
        _constraint_forces,
        Parts.WHOLE,
        keeps_grouping=False,
        has_loop_forces=True,
    ),
)
