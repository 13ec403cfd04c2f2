"""Names of the quantities that a trace computes, and the sections of a program they belong to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.base_body import Solution
from symoro_elastic.mechanics.clusters import ClusterElimination
from symoro_elastic.mechanics.dynamics import Dynamics
from symoro_elastic.mechanics.elastic_cells import CellElimination
from symoro_elastic.mechanics.factorization import Factorization
from symoro_elastic.mechanics.flexible_inertia import Modes
from symoro_elastic.mechanics.kinematics import Frame
from symoro_elastic.mechanics.lagrange import InertiaMatrix
from symoro_elastic.mechanics.spatial import (
    ENTRY,
    NO_WRENCH,
    ArticulatedInertia,
    RigidInertia,
    SpatialVector,
    Symmetric,
    Twist,
    Vector,
)
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import COS, SIGN, SIN, SYMBOL
from symoro_elastic.symbolic.program import Names, Section

AXES = "xyz"
INERTIA_ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")
FORWARD_1 = "Forward recursion: velocities"
KNOWN = "Forward recursion: velocities, accelerations, wrenches"
BACKWARD = "Backward recursion: articulated inertias and wrenches"
OF_CELLS = "(L43)-(L47)"
OF_MODES = ", (L50)-(L54)"
FORWARD_2 = "Forward recursion: accelerations and torques"


def _name_vector(names: Names, vector: Sequence[Any], quantity: str, section: Section) -> None:
    for axis, x in zip(AXES, vector, strict=True):
        names.give(x, f"{quantity}_{axis}", section)


def _name_six(names: Names, V: SpatialVector, quantity: str, section: Section) -> None:
    for k, x in enumerate(V.entries, start=1):
        names.give(x, f"{quantity}_{k}", section)


def _name_symmetric(names: Names, s: Symmetric, quantity: str, section: Section, offset: int = 1) -> None:
    for m in range(3):
        for n in range(m, 3):
            names.give(s[ENTRY[m][n]], f"{quantity}_{m + offset}{n + offset}", section)


def _name_inertia(names: Names, inertia: ArticulatedInertia, quantity: str, section: Section) -> None:
    _name_symmetric(names, inertia.A, quantity, section)
    for m in range(3):
        for n in range(3):
            names.give(inertia.B[m][n], f"{quantity}_{m + 1}{n + 4}", section)
    _name_symmetric(names, inertia.D, quantity, section, offset=4)


def name_geometry(bound: Bound, section: Callable[[int], Section]) -> None:
    """Name sines and cosines after their angle, inertial parameters and offsets after their body."""
    for j, link in bound.mechanism.from_base():
        here = section(j)
        for step in link.transform.steps:
            for x in (step.cosine, step.sine, step.shift):
                _name_function(bound.names, x, here)
        bound.names.give(link.transform.steps[2].cosine, f"cos{j}_theta", here)
        bound.names.give(link.transform.steps[2].sine, f"sin{j}_theta", here)
        bound.names.give(link.transform.steps[2].shift, f"P{j}_r", here)
        if link.modes is not None:
            _name_modes(bound.names, link.modes, here)
        _name_vector(bound.names, link.body.moments, f"MS{j}", here)
        for entry, x in zip(INERTIA_ENTRIES, link.body.inertia, strict=True):
            bound.names.give(x, f"J{j}_{entry}", here)


def _name_function(names: Names, x: Scalar, section: Section) -> None:
    stack, visited = [x], set[int]()
    while stack:
        node = stack.pop()
        if not isinstance(node, Expression) or not node.operands or node.id in visited:
            continue
        visited.add(node.id)
        operand = node.operands[0]
        if node.operation in (SIN, COS, SIGN) and isinstance(operand, Expression) and operand.operation == SYMBOL:
            names.give(node, f"{node.operation}_{operand.operands[0]}", section)
        else:
            stack += node.operands


def name_dynamics(bound: Bound, recursion: Dynamics, backward_equations: str, last: str) -> None:
    """Name the quantities of a dynamic model."""
    _name_forward(bound, recursion)
    for j, _ in bound.mechanism.from_tips():
        equations = OF_CELLS if j in recursion.cells else backward_equations
        _name_backward(bound.names, recursion, j, Section(BACKWARD, j, equations))
    if bound.machine.degrees_of_base:
        _name_base(bound.names, recursion, Section(BACKWARD, 0, backward_equations), Section(FORWARD_2, 0, last))
    for j, _ in bound.mechanism.from_base():
        here = Section(FORWARD_2, j, last)
        _name_six(bound.names, recursion.f.get(j, NO_WRENCH), f"f{j}", here)
        if j in bound.coordinates.S and bound.coordinates.S[j] == {j: 1}:
            bound.names.give(recursion.qdd.get(j, 0), f"qdd{j}", here)
        bound.names.give(recursion.Gamma.get(j, 0), f"Gamma{j}", here)
        if j in recursion.beta:
            _name_acceleration(bound.names, recursion, j, here)


def name_known(bound: Bound, recursion: Dynamics) -> None:
    """Name the quantities at zero joint accelerations (`Vk<j>`, `fk<j>`); accelerated ones are named apart."""
    _name_forward(bound, recursion, "Vk")
    for j, _ in bound.mechanism.from_tips():
        _name_six(bound.names, recursion.f[j], f"fk{j}", Section(BACKWARD, j, "[15]"))


def name_accelerated(bound: Bound, recursion: Dynamics) -> None:
    """Name the contributions of joint accelerations, and the quantities of the accelerated motion."""
    for j, _ in bound.mechanism.from_base():
        here = Section(FORWARD_2, j, "[6], [15]")
        _name_six(bound.names, recursion.remainder[j], f"Vr{j}", here)
        _name_vector(bound.names, recursion.vd[j], f"vd{j}", here)
        _name_six(bound.names, recursion.f[j], f"f{j}", here)


def _name_base(names: Names, recursion: Dynamics, backward: Section, forward: Section) -> None:
    """Name the quantities of the base."""
    if 0 in recursion.Js:
        _name_inertia(names, recursion.Js[0], "Js0", backward)
        _name_six(names, recursion.betas[0], "bs0", backward)
        _name_solution(names, recursion.solved[0], 0, forward)
    _name_acceleration(names, recursion, 0, forward)
    _name_six(names, recursion.f[0], "f0", forward)


def _name_solution(names: Names, solved: Solution, j: int, section: Section) -> None:
    for k, (row, inverse, reduced) in enumerate(zip(solved.left, solved.inverses, solved.reduced, strict=True)):
        for m, x in enumerate(row[: k + 1]):
            names.give(x, f"Lb{j}_{k + 1}{m + 1}", section)
        names.give(inverse, f"Db{j}_{k + 1}", section)
        names.give(reduced, f"fb{j}_{k + 1}", section)


def _name_acceleration(names: Names, recursion: Dynamics, j: int, section: Section) -> None:
    _name_vector(names, recursion.vd[j], f"vd{j}", section)
    _name_vector(names, recursion.wd[j], f"wd{j}", section)
    _name_six(names, recursion.remainder[j], f"Vr{j}", section)


def _name_forward(bound: Bound, recursion: Dynamics, prefix: str = "") -> None:
    """Name the quantities of the forward recursion; `prefix` is that of accelerations at zero joint accelerations."""

    def section(j: int) -> Section:
        more = "" if bound.mechanism.link(j).modes is None else OF_MODES
        if j in recursion.beta:
            return Section(FORWARD_1, j, f"[1], [3], [7], [14]{more}")
        return Section(KNOWN, j, f"[1], [3], [6], [12]{more}")

    for j, _ in bound.mechanism.from_base():
        bound.names.reserve(section(j))
    name_geometry(bound, section)
    carrying = bound.mechanism.carriers
    for j, link in bound.mechanism.from_base():
        here = section(j)
        _name_vector(bound.names, recursion.w[j], f"w{j}", here)
        _name_products(bound.names, recursion.w[j], f"ww{j}", here)
        _name_differences(bound.names, link.body.inertia, f"dJ{j}", here)
        if link.modes is not None and (motion := recursion.flexible.get(link.modes.numbers[0])):
            _name_six(bound.names, motion.bias, f"Fm{j}", here)
            for k, x in motion.f.items():
                bound.names.give(x, f"fm{k}", here)
        if j in recursion.beta:
            if j in carrying:
                _name_six(bound.names, recursion.bias[j], f"Vk{j}", here)
            _name_six(bound.names, recursion.gamma[j], f"g{j}", here)
            _name_six(bound.names, recursion.beta[j], f"b{j}", here)
        else:
            if prefix:
                _name_six(bound.names, Twist(recursion.vd[j], recursion.wd[j]), f"{prefix}{j}", here)
            else:
                _name_acceleration(bound.names, recursion, j, here)
            _name_six(bound.names, recursion.F[j], f"Fb{j}", here)


def _name_modes(names: Names, modes: Modes, section: Section) -> None:
    """Name the wrenches and second moments of the modes of a body by the number of each mode."""
    for (j, U), R in zip(modes.wrenches().items(), modes.R, strict=True):
        _name_six(names, U, f"Um{j}", section)
        for m, row in enumerate(R, start=1):
            for n, x in enumerate(row, start=1):
                names.give(x, f"Rm{j}_{m}{n}", section)


def _name_products(names: Names, w: Vector, quantity: str, section: Section) -> None:
    """Name w_x w_x, w_x w_y...: products of angular velocities that forces and accelerations share."""
    for m in range(3):
        for n in range(m, 3):
            names.give(w[m] * w[n], f"{quantity}_{AXES[m]}{AXES[n]}", section)


def _name_differences(names: Names, inertia: Symmetric, quantity: str, section: Section) -> None:
    """Name differences of moments of inertia, which depend on parameters only."""
    xx, _, _, yy, _, zz = inertia
    for name, x in (("yz", yy - zz), ("xz", xx - zz), ("xy", xx - yy)):
        names.give(x, f"{quantity}_{name}", section)


def _name_backward(names: Names, recursion: Dynamics, j: int, section: Section) -> None:
    if j not in recursion.beta:
        _name_six(names, recursion.f[j], f"f{j}", section)
        return
    _name_inertia(names, recursion.Js[j], f"Js{j}", section)
    _name_six(names, recursion.betas[j], f"bs{j}", section)
    if j in recursion.reduced:
        _name_cluster(names, recursion.reduced[j], j, section)
    if j in recursion.cells:
        _name_cell(names, recursion.cells[j], j, section)
    if j not in recursion.eliminated:
        return
    eliminated = recursion.eliminated[j]
    names.give(eliminated.H, f"H{j}", section)
    names.give(eliminated.Hinv, f"Hinv{j}", section)
    names.give(recursion.Gamma[j] if eliminated.Hinv else 0, f"Gamma{j}", section)
    names.give(eliminated.tau_bias, f"Gb{j}", section)
    names.give(eliminated.rotor_share, f"rho{j}", section)
    names.give(eliminated.qdd_bias, f"qdf{j}", section)
    _name_six(names, eliminated.UH, f"UH{j}", section)
    _name_inertia(names, eliminated.K, f"K{j}", section)
    _name_six(names, eliminated.alpha, f"al{j}", section)


def _name_cluster(names: Names, reduced: ClusterElimination, first: int, section: Section) -> None:
    """Name the pivots of a cluster by coordinate, and its inertia and force on the antecedent by its first joint."""
    for k, pivot in reduced.factors.pivots.items():
        names.give(pivot, f"H{k}", section)
        names.give(reduced.factors.inverses[k], f"Hinv{k}", section)
        names.give(reduced.rho[k], f"Gb{k}", section)
        _name_six(names, reduced.U[k], f"U{k}", section)
    _name_inertia(names, reduced.K, f"K{first}", section)
    _name_six(names, reduced.alpha, f"al{first}", section)


def _name_cell(names: Names, cell: CellElimination, j: int, section: Section) -> None:
    """Name the quantities of an elastic cell by the body that it carries."""
    names.give(cell.geometry.h, f"hc{j}", section)
    _name_six(names, cell.alpha, f"al{j}", section)
    if isinstance(cell.inertia, Solution):
        _name_solution(names, cell.inertia, j, section)
        return
    body = cell.inertia
    names.give(body.Minv, f"Minv{j}", section)
    _name_vector(names, body.c, f"rc{j}", section)
    for quantity, entries in (("Jm", body.J), ("Jminv", body.Jinv)):
        for entry, x in zip(INERTIA_ENTRIES, entries, strict=True):
            names.give(x, f"{quantity}{j}_{entry}", section)


def name_composites(bound: Bound, inertia: InertiaMatrix) -> None:
    """Name composite inertias and the entries of the inertia matrix."""
    name_geometry(bound, lambda j: Section("Geometry", j, "[1]"))
    for j, _ in bound.mechanism.from_tips():
        here = Section("Composite inertias and inertia matrix", j, "[8], [13]")
        name_composite(bound.names, inertia.composite[j], j, here)
        for i in range(1, j + 1):
            bound.names.give(inertia.A[i][j], f"A{i}_{j}", here)


def name_composite(names: Names, composite: RigidInertia, j: int, section: Section) -> None:
    """Name mass, first moments and inertia of body j and all it carries."""
    names.give(composite.mass, f"M{j}_c", section)
    _name_vector(names, composite.moments, f"MS{j}_c", section)
    for entry, x in zip(INERTIA_ENTRIES, composite.inertia, strict=True):
        names.give(x, f"J{j}_c{entry}", section)


def name_factors(names: Names, factors: Factorization, forces: Mapping[int, Scalar], qdd: Mapping[int, Scalar]) -> None:
    """Name the pivots of the inertia matrix, and the accelerations it gives."""
    for j, pivot in factors.pivots.items():
        here = Section("Solution, from the tips to the base", j, "[8]")
        names.give(pivot, f"H{j}", here)
        names.give(factors.inverses[j], f"Hinv{j}", here)
        names.give(forces[j], f"Gb{j}", here)
    for j, x in qdd.items():
        names.give(x, f"qdd{j}", Section("Solution, from the base to the tips", j, "[8]"))


def name_frames(bound: Bound, frames: list[Frame]) -> None:
    """Name the entries of 0Aj and 0Pj."""
    for j, _ in bound.mechanism.from_base():
        bound.names.reserve(Section("Geometry", j, "[1], [2]"))
    name_geometry(bound, lambda j: Section("Geometry", j, "[1], [2]"))
    for j, _ in bound.mechanism.from_base():
        here = Section("Geometry", j, "[1], [2]")
        rotation, position = frames[j]
        for m in range(3):
            for n in range(3):
                bound.names.give(rotation[m][n], f"A{j}_{m + 1}{n + 1}", here)
        _name_vector(bound.names, position, f"P{j}", here)


def name_twists(bound: Bound, twists: list[Twist], frames: list[Frame], quantity: str, equations: str) -> None:
    """Name velocities or accelerations of frames, and where the frames are."""
    name_frames(bound, frames)
    for j, _ in bound.mechanism.from_base():
        _name_six(bound.names, twists[j], f"{quantity}{j}", Section("Forward recursion", j, equations))


def name_jacobian(bound: Bound, columns: dict[int, tuple[Scalar, ...]], frame: int) -> None:
    """Name the entries of the Jacobian of a frame: row, then joint."""
    here = Section("Jacobian", frame, "[3]")
    for j, column in columns.items():
        for k, x in enumerate(column, start=1):
            bound.names.give(x, f"Jc{frame}_{k}_{j}", here)
