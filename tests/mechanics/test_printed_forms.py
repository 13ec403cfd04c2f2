"""The printed forms of [12], [14], [29], [30] and [34] beside the cheaper ones: equal in the finite field."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from symoro_elastic.mechanics.elimination import (
    eliminate,
    eliminate_as_printed,
    joint_acceleration,
    joint_acceleration_as_printed,
)
from symoro_elastic.mechanics.mechanism import Link
from symoro_elastic.mechanics.newton_euler import bias_wrench, newton_euler, newton_euler_as_printed
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    ArticulatedInertia,
    AxialTransform,
    Axis,
    Matrix,
    RigidInertia,
    Symmetric,
    Transform,
    Twist,
    Vector,
    Wrench,
    X,
    Z,
    cross,
    dot,
    hat_plus_hat_squared,
)
from symoro_elastic.symbolic.finite_field import PRIME, Residue

SEEDS = range(5)
MOVING = (Axis.REVOLUTE, Axis.PRISMATIC)
Draw = Callable[[], Residue]


def drawing(seed: int) -> Draw:
    source = random.Random(seed)
    return lambda: Residue(source.randrange(1, PRIME))


def vector(draw: Draw) -> Vector:
    return Vector(draw(), draw(), draw())


def symmetric(draw: Draw) -> Symmetric:
    return Symmetric(*(draw() for _ in range(6)))


def step(axis: int, draw: Draw) -> AxialTransform:
    t = draw()
    return AxialTransform(axis, (1 - t * t) / (1 + t * t), (t + t) / (1 + t * t), draw())


def link(draw: Draw, axis: Axis, rotor_inertia: Residue | int) -> Link:
    transform = Transform((step(Z, draw), step(X, draw), step(Z, draw)))
    return Link(0, axis, transform, rotor_inertia=rotor_inertia)


def articulated(draw: Draw) -> ArticulatedInertia:
    return ArticulatedInertia(symmetric(draw), Matrix(vector(draw), vector(draw), vector(draw)), symmetric(draw))


def residues(*parts: object) -> list[int]:
    """All entries, as numbers of the field."""
    found: list[int] = []
    for part in parts:
        if isinstance(part, tuple):
            found += residues(*part)
        elif isinstance(part, ArticulatedInertia):
            found += residues(part.A, part.B, part.D)
        else:
            found.append((part if isinstance(part, Residue) else Residue(part)).value)  # type: ignore[arg-type]
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_newton_euler_is_equation_12(seed: int) -> None:
    draw = drawing(seed)
    body = RigidInertia(draw(), vector(draw), symmetric(draw))
    w, wd, vd = vector(draw), vector(draw), vector(draw)
    cheaper = newton_euler(body, w, wd, vd, hat_plus_hat_squared(w, wd))
    assert residues(cheaper) == residues(newton_euler_as_printed(body, w, Twist(vd, wd)))


@pytest.mark.parametrize("seed", SEEDS)
def test_bias_wrench_is_equation_14(seed: int) -> None:
    """Without a bias it is beta of [14], which is what [12] leaves without an acceleration."""
    draw = drawing(seed)
    body, w = RigidInertia(draw(), vector(draw), symmetric(draw)), vector(draw)
    printed = -newton_euler_as_printed(body, w, AT_REST)
    assert residues(bias_wrench(body, w, AT_REST)) == residues(printed)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_bias_of_the_acceleration_changes_no_wrench(seed: int) -> None:
    """JJ remainder - beta with the bias taken apart is F [12] of the whole acceleration."""
    draw = drawing(seed)
    body, w = RigidInertia(draw(), vector(draw), symmetric(draw)), vector(draw)
    bias, remainder = Twist(vector(draw), vector(draw)), Twist(vector(draw), vector(draw))
    split = body.spatial * remainder - bias_wrench(body, w, bias)
    assert residues(split) == residues(newton_euler_as_printed(body, w, bias + remainder))


@pytest.mark.parametrize("rotor", [True, False], ids=["rotor", "no rotor"])
@pytest.mark.parametrize("axis", MOVING, ids=lambda axis: axis.name.lower())
@pytest.mark.parametrize("seed", SEEDS)
def test_elimination_is_equations_29_and_30(seed: int, axis: Axis, rotor: bool) -> None:
    """K and alpha in the frame before the joint's rotation are those of frame j, rotated."""
    draw = drawing(seed)
    joint = link(draw, axis, draw() if rotor else 0)
    Js, betas, torque = articulated(draw), Wrench(vector(draw), vector(draw)), draw()
    gamma = Twist(vector(draw), vector(draw))
    R = joint.joint_rotation
    K, alpha = eliminate_as_printed(joint, torque, Js, betas, R * gamma)
    cheaper = eliminate(joint, torque, Js, betas, gamma)
    assert residues(cheaper.K, cheaper.alpha) == residues(K.rotated_back(R), R.T * alpha)


@pytest.mark.parametrize("rotor", [True, False], ids=["rotor", "no rotor"])
@pytest.mark.parametrize("axis", MOVING, ids=lambda axis: axis.name.lower())
@pytest.mark.parametrize("seed", SEEDS)
def test_joint_acceleration_is_equation_34(seed: int, axis: Axis, rotor: bool) -> None:
    draw = drawing(seed)
    joint = link(draw, axis, draw() if rotor else 0)
    Js, betas, torque = articulated(draw), Wrench(vector(draw), vector(draw)), draw()
    V = Twist(vector(draw), vector(draw))
    cheaper = joint_acceleration(joint, eliminate(joint, torque, Js, betas, AT_REST), V)
    assert residues(*cheaper) == residues(*joint_acceleration_as_printed(joint, torque, Js, betas, V))


@pytest.mark.parametrize("seed", SEEDS)
def test_steps_make_the_screw_transform_of_equation_5(seed: int) -> None:
    """jTi V = [jAi (v - iPj x w); jAi w], and jTi^T does the same work."""
    draw = drawing(seed)
    X_ = link(draw, Axis.REVOLUTE, 0).transform
    V, f = Twist(vector(draw), vector(draw)), Wrench(vector(draw), vector(draw))
    printed = Twist(X_.to_child(V.linear - cross(X_.origin, V.angular)), X_.to_child(V.angular))
    assert residues(X_ * V) == residues(printed)
    work = [dot(a.linear, b.linear) + dot(a.angular, b.angular) for a, b in ((X_ * V, f), (V, X_.T * f))]
    assert residues(work[0]) == residues(work[1])


@pytest.mark.parametrize("seed", SEEDS)
def test_congruence_keeps_the_power(seed: int) -> None:
    """V^T (jTi^T K jTi) V = (jTi V)^T K (jTi V), for articulated and rigid inertias alike [32]."""
    draw = drawing(seed)
    X_, V = link(draw, Axis.REVOLUTE, 0).transform, Twist(vector(draw), vector(draw))
    body = RigidInertia(draw(), vector(draw), symmetric(draw))
    assert residues(X_.T * (body.spatial * (X_ * V))) == residues(body.to_antecedent(X_).spatial * V)
    K = articulated(draw)
    assert residues(X_.T * (K * (X_ * V))) == residues(K.to_antecedent(X_) * V)
