"""The models that can be asked for: each a function from a bound machine to a traced program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symoro_elastic.equations.dynamics import dynamics
from symoro_elastic.equations.kinematics import frames
from symoro_elastic.equations.lagrange import inertia_matrix
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.naming import name_composites, name_dynamics, name_frames
from symoro_elastic.symbolic.expression import Scalar
from symoro_elastic.symbolic.program import Input, Output, Program, build

Joints = tuple[int, ...]


@dataclass(frozen=True)
class Result:
    """A result of a model: the joints (or frames) along its first axis, its entries, its other axes."""

    rows: Joints
    entries: tuple[Scalar, ...]
    columns: tuple[int, ...] = ()


Results = dict[str, Result]


@dataclass(frozen=True)
class Model:
    """A model that can be generated: what it gives, by which equations, from which arguments."""

    name: str
    title: str
    equations: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]
    run: Callable[[Bound, Joints], Results]


def _direct_dynamics(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.direct_rules())
    name_dynamics(bound, found, "[28]-[32]", "[33]-[36]")
    return {"qdd": Result(asked, tuple(found.qdd[j] for j in asked))}


def _inverse_dynamics(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.inverse_rules())
    name_dynamics(bound, found, "[50]-[56]", "[57]-[61]")
    motors = tuple(j for j in asked if j in bound.motors)
    others = asked if asked == bound.machine.moving else tuple(j for j in asked if j not in bound.motors)
    tau = tuple(found.Gamma[j] + bound.friction(j) for j in motors)
    return {"tau": Result(motors, tau), "qdd": Result(others, tuple(found.qdd[j] for j in others))}


def _bias_forces(bound: Bound, asked: Joints) -> Results:
    found = dynamics(bound.mechanism, bound.rates(), bound.held_rules())
    name_dynamics(bound, found, "[15]", "[61]")
    return {"H": Result(asked, tuple(found.Gamma[j] + bound.friction(j) for j in asked))}


def _inertia_matrix(bound: Bound, asked: Joints) -> Results:
    found = inertia_matrix(bound.mechanism)
    name_composites(bound, found)
    entries = tuple(found.A[i][j] for i in asked for j in asked)
    return {"A": Result(asked, entries, (len(asked),))}


def _geometric_model(bound: Bound, asked: Joints) -> Results:
    placed = frames(bound.mechanism)
    name_frames(bound, placed)
    entries: list[Scalar] = []
    for j in asked:
        rotation, position = placed[j]
        for row, x in zip(rotation, position, strict=True):
            entries += [*row, x]
        entries += [0, 0, 0, 1]
    return {"T": Result(asked, tuple(entries), (4, 4))}


MODELS = {
    model.name: model
    for model in (
        Model("direct_dynamics", "direct dynamic model", "[12]-[36]", ("q", "qd", "tau"), ("qdd",), _direct_dynamics),
        Model(
            "inverse_dynamics",
            "inverse dynamic model: motor torques and elastic accelerations",
            "[37]-[61]",
            ("q", "qd", "qdd_motor"),
            ("tau", "qdd"),
            _inverse_dynamics,
        ),
        Model("inertia_matrix", "inertia matrix", "[8]", ("q",), ("A",), _inertia_matrix),
        Model(
            "bias_forces",
            "forces at zero joint acceleration",
            "[8]",
            ("q", "qd"),
            ("H",),
            _bias_forces,
        ),
        Model("geometric_model", "placement of the frames in frame 0", "[1], [2]", ("q",), ("T",), _geometric_model),
    )
}
DEFAULT_MODELS = ("direct_dynamics", "inverse_dynamics")


@dataclass(frozen=True)
class TracedModel:
    """A model of one machine as a program; `rows` gives the joints (or frames) of each result."""

    model: Model
    rows: dict[str, tuple[int, ...]]
    program: Program


def trace(machine: Machine, name: str, asked: Sequence[int] = (), folded: Sequence[str] = ()) -> TracedModel:
    """Run the equations of a model on the symbols of a machine, prune and schedule.

    `asked` are joint numbers (all when empty), `folded` names of parameters that become constants.
    Raises `SingularPivot` where a joint has no inertia.
    """
    model = MODELS[name]
    bound = Bound(machine, folded)
    everything = range(1, len(machine.joints) + 1) if name == "geometric_model" else machine.moving
    results = model.run(bound, tuple(asked) or tuple(everything))
    inputs = [Input(argument, bound.arguments()[argument]) for argument in model.arguments]
    outputs = [Output(name, (len(r.rows), *r.columns), r.entries) for name, r in results.items()]
    rows = {name: r.rows for name, r in results.items()}
    return TracedModel(model, rows, build(inputs, outputs, bound.names))


def trace_scene(machine: Machine, scene: Scene) -> list[TracedModel]:
    """Every model that a scene asks of a machine; the default models where it names none.

    `machine` is the whole machine; locked joints and gravity are seen to here.
    """
    kept = restricted(machine, scene)
    numbers = {joint.name: j for j, joint in enumerate(kept.joints, start=1)}
    constants = folded(machine, scene)
    return [
        trace(kept, name, tuple(numbers[output] for output in scene.outputs.get(name, ())), constants)
        for name in scene.models or DEFAULT_MODELS
    ]
