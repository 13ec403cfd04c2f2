"""Dynamic models: direct, inverse, and the parts of the Lagrange form."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.frames import row_under
from symoro_elastic.machine.scene import Parts
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.energy import gravity_energy, kinetic_energy
from symoro_elastic.mechanics.factorization import by_minimum_degree, factorization, share, share_or_one
from symoro_elastic.mechanics.kinematics import frames, velocities
from symoro_elastic.mechanics.mechanism import Mechanism, without_loads
from symoro_elastic.mechanics.spatial import NO_WRENCH, ZERO, RigidInertia, Twist, Wrench, cross
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.bound.model import (
    MOVING,
    ORIENTATION,
    CheckedBy,
    Frames,
    Joints,
    Model,
    Pivots,
    Result,
    Results,
)
from symoro_elastic.models.bound.naming import name_composites, name_dynamics, name_factors, name_twists
from symoro_elastic.models.bound.rules import (
    base_rule,
    direct_motion,
    given_rules,
    held_rules,
    inverse_by_motors,
    inverse_motion,
    still_rules,
    with_loop_forces,
)
from symoro_elastic.models.dynamics.floating_base import BASE_ROWS, forces, found_of_base, inertia, solution_with_base
from symoro_elastic.quantities import Quantity, quantity
from symoro_elastic.symbolic.expression import is_constant


def _direct_dynamics(bound: Bound, joints: Joints) -> Results:
    motion = direct_motion(bound)
    recursion = motion.dynamics_by_cells(bound.without_tip_angles)
    name_dynamics(bound, recursion, "[28]-[32]", "[33]-[36]")
    qdd = motion.accelerations(recursion)
    own = {"qdd": Result(joints, tuple(qdd[j] for j in joints))}
    return {**own, **_of_bristles(bound), **found_of_base(bound, recursion)}


def _of_bristles(bound: Bound) -> Results:
    """Rates of the states of friction, where there are any."""
    rates = {j: bound.friction_of(j).rate_of_bristle() for j in bound.machine.bristles}
    return {"zd": Result(tuple(rates), tuple(rates.values()))} if rates else {}


def _direct_dynamics_by_inertia_matrix(bound: Bound, joints: Joints) -> Results:
    """qdd of A qdd = Gamma - H [8].

    Fewer operations than the recursion up to some ten joints in series. Less accurate: two or three times on an arm,
    a thousand times on 50 equal bodies, a million times where their masses grow; not for chains in single precision.
    """
    mechanism = bound.unaccelerated_mechanism if base_rule(bound) else bound.without_tip_angles
    recursion = dynamics(mechanism, bound.rates(), held_rules(bound))
    matrix = coordinate_inertia(bound)
    order, by = bound.machine.independent[::-1], share
    if bound.machine.is_coupled:
        order, by = by_minimum_degree(order, matrix.A, is_constant), share_or_one
    factors = factorization(order, matrix.A, by)
    exerted, bias = bound.exerted_forces(), bound.on_independent(recursion.Gamma)
    right = {j: exerted[j] - bias[j] for j in bound.machine.independent}
    qdd, of_base = solution_with_base(bound, factors, matrix, recursion, right)
    name_dynamics(bound, recursion, "[15]", "[61]")
    name_composites(bound, matrix)
    name_factors(bound.names, factors, right, qdd)
    return {"qdd": Result(joints, tuple(qdd[j] for j in joints)), **_of_bristles(bound), **of_base}


def _inverse_dynamics(bound: Bound, joints: Joints) -> Results:
    if any(j not in bound.machine.independent for j in bound.motors):
        return _inverse_by_motors(bound, joints)
    motion = inverse_motion(bound)
    recursion = motion.dynamics_by_cells(bound.without_tip_angles)
    name_dynamics(bound, recursion, "[50]-[56]", "[57]-[61]")
    motors = tuple(j for j in joints if j in bound.motors)
    unactuated = joints if joints == bound.machine.independent else tuple(j for j in joints if j not in bound.motors)
    needed, passive, udd = motion.forces(recursion), bound.passive_forces(), motion.accelerations(recursion)
    tau = tuple(needed[j] - passive[j] for j in motors)
    qdd = tuple(udd[j] for j in unactuated)
    on_joints = {"tau": Result(motors, tau), "qdd": Result(unactuated, qdd)}
    return {**on_joints, **_of_bristles(bound), **found_of_base(bound, recursion)}


def _inverse_by_motors(bound: Bound, joints: Joints) -> Results:
    """Inverse dynamics of a machine with motors on dependent joints (L30)."""
    driven = inverse_by_motors(bound)
    everything = joints == bound.machine.independent
    motors = bound.motors if everything else tuple(j for j in joints if j in bound.motors)
    unactuated = joints if everything else tuple(j for j in joints if j not in bound.motors)
    tau, qdd = tuple(driven.tau[j] for j in motors), tuple(driven.udd[j] for j in unactuated)
    return {"tau": Result(motors, tau), "qdd": Result(unactuated, qdd), **_of_bristles(bound)}


def _bias_forces(bound: Bound, joints: Joints) -> Results:
    recursion = dynamics(bound.unaccelerated_mechanism, bound.rates(), held_rules(bound))
    name_dynamics(bound, recursion, "[15]", "[61]")
    Gamma, friction = bound.on_independent(recursion.Gamma), bound.friction_forces()
    return {"H": forces(recursion, joints, tuple(Gamma[j] + friction[j] for j in joints))}


def _inertia_matrix(bound: Bound, joints: Joints) -> Results:
    matrix = coordinate_inertia(bound)
    name_composites(bound, matrix)
    return {"A": inertia(bound, matrix, joints)}


def _inertia_matrix_packed(bound: Bound, joints: Joints) -> Results:
    matrix = coordinate_inertia(bound)
    name_composites(bound, matrix)
    full = inertia(bound, matrix, joints)
    n = full.shape[1]
    lower = tuple(full.entries[n * i + j] for i in range(n) for j in range(i + 1))
    return {"A_packed": Result(None, lower, (len(lower),))}


def _coriolis_forces(bound: Bound, joints: Joints) -> Results:
    """H(q, qd) without gravity, friction and external wrenches; the effect of a moving base is part of it."""
    unloaded = without_loads(bound.mechanism)
    loaded = replace(unloaded, velocity=bound.mechanism.velocity, acceleration=bound.held_base_acceleration)
    return _bias_of(bound, joints, loaded)


def _gravity_forces(bound: Bound, joints: Joints) -> Results:
    """H(q, 0) under gravity only, on a base at rest: the derivative of the gravity energy by q."""
    loaded = replace(without_loads(bound.mechanism), acceleration=Twist(-bound.gravity, ZERO))
    return _bias_of(bound, joints, loaded, at_rest=True)


def _external_forces(bound: Bound, joints: Joints) -> Results:
    """Torques that balance the external wrenches."""
    bodiless = tuple(replace(link, body=RigidInertia(), modes=None) for link in bound.mechanism.links)
    base = None if bound.mechanism.body is None else RigidInertia()
    return _bias_of(bound, joints, replace(bound.mechanism, links=bodiless, body=base, wrench=NO_WRENCH), at_rest=True)


def _friction_forces(bound: Bound, joints: Joints) -> Results:
    friction = bound.friction_forces()
    rows, on_base = (BASE_ROWS, bound.mechanism.wrench.entries) if bound.machine.degrees_of_base else ((), ())
    return {"H": Result((*rows, *joints), (*on_base, *(friction[j] for j in joints)))}


def _bias_of(bound: Bound, joints: Joints, mechanism: Mechanism, at_rest: bool = False) -> Results:
    rates = [0] * (len(bound.mechanism.links) + 1) if at_rest else bound.rates()
    recursion = dynamics(mechanism, rates, still_rules(bound.machine) if at_rest else held_rules(bound))
    name_dynamics(bound, recursion, "[15]", "[61]")
    Gamma = bound.on_independent(recursion.Gamma)
    return {"H": forces(recursion, joints, tuple(Gamma[j] for j in joints))}


def _reaction_wrenches(bound: Bound, joints: Frames) -> Results:
    recursion = dynamics(with_loop_forces(bound), bound.rates(), given_rules(bound))
    name_dynamics(bound, recursion, "[15]", "[61]")
    entries = [x for frame in joints for part in _wrench_in(bound, recursion, frame.number) for x in part]
    return {"f": Result(tuple(frame.number for frame in joints), tuple(entries), (6,), joints)}


def _wrench_in(bound: Bound, recursion: Dynamics, number: int) -> Wrench:
    """The wrench on the body of a frame, about the origin of the frame, in axes of it."""
    wrench, pose = recursion.f[row_under(bound.machine, number)], bound.fixed_link(number).transform
    moment = wrench.moment - cross(pose.origin, wrench.force)
    return Wrench(pose.to_child(wrench.force), pose.to_child(moment))


def _forces(meaning: str) -> Quantity:
    """The quantity H with the meaning of a part of it."""
    return replace(quantity("H"), meaning=meaning)


def _energy(bound: Bound, _: Joints) -> Results:
    mechanism, rates = bound.mechanism, bound.rates()
    name_twists(bound, velocities(mechanism, rates), frames(mechanism), "V", "[3]")
    elastic: Scalar = 0
    for j in bound.machine.with_variable:
        elastic = elastic + bound.spring_of(j).energy()
    parts = (kinetic_energy(mechanism, rates), gravity_energy(mechanism, bound.gravity, bound.depth), elastic)
    return {"E": Result(None, parts, (3,))}


DYNAMIC = (
    Model(
        "direct_dynamics",
        "direct dynamic model",
        "[12]-[36]",
        ("q", "qd", "tau"),
        ("qdd",),
        _direct_dynamics,
        on_base=MOVING,
        pivots=Pivots.ALL,
        checked_by=CheckedBy.DIRECT,
    ),
    Model(
        "direct_dynamics_by_inertia_matrix",
        "direct dynamic model through the inertia matrix: less accurate",
        "[8]",
        ("q", "qd", "tau"),
        ("qdd",),
        _direct_dynamics_by_inertia_matrix,
        on_base=MOVING,
        pivots=Pivots.ALL,
        checked_by=CheckedBy.DIRECT,
        other_way_of="direct_dynamics",
    ),
    Model(
        "inverse_dynamics",
        "inverse dynamic model: motor torques and elastic accelerations",
        "[37]-[61]",
        ("q", "qd", "qdd_motor"),
        ("tau", "qdd"),
        _inverse_dynamics,
        on_base=MOVING,
        pivots=Pivots.WITHOUT_MOTOR,
        checked_by=CheckedBy.INVERSE,
    ),
    Model(
        "inertia_matrix",
        "inertia matrix",
        "[8]",
        ("q",),
        ("A",),
        _inertia_matrix,
        on_base=(),
        checked_by=CheckedBy.INERTIA,
    ),
    Model(
        "inertia_matrix_packed",
        "packed inertia matrix",
        "[8]",
        ("q",),
        ("A_packed",),
        _inertia_matrix_packed,
        Parts.WHOLE,
        on_base=(),
        checked_by=CheckedBy.INERTIA,
    ),
    Model(
        "bias_forces",
        "forces at zero joint acceleration",
        "[8]",
        ("q", "qd"),
        ("H",),
        _bias_forces,
        on_base=(ORIENTATION, "V0"),
        checked_by=CheckedBy.BIAS,
    ),
    Model(
        "coriolis_forces",
        "Coriolis and centrifugal forces, those of a moving base too",
        "[8]",
        ("q", "qd"),
        ("H",),
        _coriolis_forces,
        own=(_forces("Coriolis and centrifugal forces, and those of a moving base"),),
        on_base=("V0",),
    ),
    Model(
        "gravity_forces",
        "gravity forces",
        "[8]",
        ("q",),
        ("H",),
        _gravity_forces,
        own=(_forces("gravity forces"),),
        on_base=(ORIENTATION,),
    ),
    Model(
        "friction_forces",
        "friction forces",
        "[61]",
        ("qd",),
        ("H",),
        _friction_forces,
        own=(_forces("friction forces"),),
        on_base=(),
    ),
    Model(
        "external_forces",
        "forces that balance the external wrenches",
        "[8]",
        ("q",),
        ("H",),
        _external_forces,
        own=(_forces("forces that balance the external wrenches"),),
        on_base=(),
    ),
    Model(
        "reaction_wrenches",
        "reaction wrenches of bodies",
        "[15], [35], [58]",
        ("q", "qd", "qdd"),
        ("f",),
        _reaction_wrenches,
        Parts.BODIES,
        on_base=(ORIENTATION, "V0", "V0d"),
        keeps_grouping=False,
        has_loop_forces=True,
    ),
    Model(
        "energy",
        "kinetic, gravity and elastic energy",
        "[8], [9]",
        ("q", "qd"),
        ("E",),
        _energy,
        Parts.WHOLE,
        on_base=(ORIENTATION, "P0", "V0"),
    ),
)
