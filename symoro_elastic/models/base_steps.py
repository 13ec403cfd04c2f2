"""What time steps of a machine on a floating base call beside the dynamic models: its pose, and rates of its state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symoro_elastic.machine.machine import Machine, Orientation
from symoro_elastic.mechanics.base_motion import (
    pose_rates,
    quaternion_change,
    rotation_change,
    shift,
    velocity_rates,
)
from symoro_elastic.mechanics.spatial import Twist, Vector
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.implicit_steps import FAMILY
from symoro_elastic.models.model import Model, Result, Results, TracedModel
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import operand
from symoro_elastic.symbolic.functions import square_root
from symoro_elastic.symbolic.program import Input, Output, prune, schedule

DISPLACEMENT, RATES = "base_displacement", "base_rates"


def base_models(machine: Machine, folded: Sequence[str] = ()) -> tuple[TracedModel, TracedModel]:
    """Return the models `base_displacement` and `base_rates` of a machine on a floating base."""
    orientation = orientation_of(machine)
    displacement = Model(
        DISPLACEMENT,
        "displacement of a floating base within a time step",
        "[2]",
        (orientation, "x0"),
        (f"{orientation}_change", "P0_change"),
        _displacement,
        FAMILY,
    )
    rates = Model(
        RATES,
        "rates of the coordinates and of the velocity of a floating base",
        "[3], [6]",
        ("x0", "V0", "V0d"),
        ("x0d", "V0_rate"),
        _rates,
        FAMILY,
    )
    return _traced(displacement, Bound(machine, folded)), _traced(rates, Bound(machine, folded))


def orientation_of(machine: Machine) -> str:
    """Return the argument that says how the base of a machine is turned: Q0 or R0."""
    assert machine.floating is not None
    return "Q0" if machine.floating.orientation is Orientation.QUATERNION else "R0"


def _traced(model: Model, bound: Bound) -> TracedModel:
    results, entries = model.run(bound, ()), bound.arguments()
    outputs = [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in results.items()]
    inputs = [Input(name, entries[name]) for name in model.arguments]
    return TracedModel(model, results, schedule(inputs, prune(outputs, bound.names)))


def _displacement(bound: Bound, _: object) -> Results:
    s, u = _twist(bound, "x0")
    changed: tuple[Scalar, ...]
    if orientation_of(bound.machine) == "Q0":
        changed = quaternion_change(bound.on_base["Q0"], u, partial(square_root, bound.graph))
    else:
        changed = tuple(x for row in rotation_change(bound.base_rotation, u) for x in row)
    name = f"{orientation_of(bound.machine)}_change"
    return {name: _vector(changed), "P0_change": _vector(shift(bound.base_rotation, s))}


def _rates(bound: Bound, _: object) -> Results:
    (_, u), V, Vd = (_twist(bound, name) for name in ("x0", "V0", "V0d"))
    return {"x0d": _vector(pose_rates(u, V).entries), "V0_rate": _vector(velocity_rates(V, Vd).entries)}


def _twist(bound: Bound, argument: str) -> Twist:
    entries = list(map(bound.graph.symbol, bound.arguments()[argument]))
    return Twist(Vector(*entries[:3]), Vector(*entries[3:]))


def _vector(entries: Sequence[Scalar]) -> Result:
    return Result(None, tuple(entries), (len(entries),))
