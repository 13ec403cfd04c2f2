"""What time steps of a machine on a floating base call beside the dynamic models: its pose, and rates of its state."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.base_motion import pose_rates, quaternion_change, rotation_change, shift, velocity_rates
from symoro_elastic.mechanics.spatial import Twist, Vector
from symoro_elastic.models.implicit_steps import FAMILY
from symoro_elastic.models.model import Model, Result, Results, TracedModel
from symoro_elastic.models.state import orientation_of
from symoro_elastic.models.tree import Tree
from symoro_elastic.symbolic.expression import operand
from symoro_elastic.symbolic.functions import square_root
from symoro_elastic.symbolic.program import Input, Output, prune, schedule

DISPLACEMENT, RATES = "base_displacement", "base_rates"


def base_models(machine: Machine, folded: Sequence[str] = ()) -> tuple[TracedModel, ...]:
    """Return the models `base_displacement` and `base_rates`; none where the base is fixed."""
    if not machine.degrees_of_base:
        return ()
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
    trees = Tree(machine, folded), Tree(machine, folded)
    results = _displacement(trees[0], ()), _rates(trees[1], ())
    return _traced(displacement, trees[0], results[0]), _traced(rates, trees[1], results[1])


def _traced(model: Model, tree: Tree, results: Results) -> TracedModel:
    entries = tree.arguments()
    outputs = [Output(name, r.shape, tuple(map(operand, r.entries))) for name, r in results.items()]
    inputs = [Input(name, entries[name]) for name in model.arguments]
    return TracedModel(model, results, schedule(inputs, prune(outputs, tree.names)))


def _displacement(tree: Tree, _: object) -> Results:
    s, u = _twist(tree, "x0")
    changed: tuple[Scalar, ...]
    if orientation_of(tree.machine) == "Q0":
        changed = quaternion_change(tree.on_base["Q0"], u, partial(square_root, tree.graph))
    else:
        changed = tuple(x for row in rotation_change(tree.base_rotation, u) for x in row)
    name = f"{orientation_of(tree.machine)}_change"
    return {name: _vector(changed), "P0_change": _vector(shift(tree.base_rotation, s))}


def _rates(tree: Tree, _: object) -> Results:
    (_, u), V, Vd = (_twist(tree, name) for name in ("x0", "V0", "V0d"))
    return {"x0d": _vector(pose_rates(u, V).entries), "V0_rate": _vector(velocity_rates(V, Vd).entries)}


def _twist(tree: Tree, argument: str) -> Twist:
    entries = list(map(tree.graph.symbol, tree.arguments()[argument]))
    return Twist(Vector(*entries[:3]), Vector(*entries[3:]))


def _vector(entries: Sequence[Scalar]) -> Result:
    return Result(None, tuple(entries), (len(entries),))
