"""The journey from a machine to files: check, trace, render, write."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.codegen.package import Argument, Axis, Function, Package, ParameterValue, Result
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets import render_targets
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import BASE, Asked, Scene
from symoro_elastic.models.catalogue import DEFAULT_MODELS, TracedModel, trace_scene
from symoro_elastic.models.degenerate import Degeneracy, degeneracies
from symoro_elastic.models.feed_forward import MEANINGS as MOTION_WANTED
from symoro_elastic.models.inverse_geometric import INVERSE_GEOMETRIC
from symoro_elastic.models.model import Result as TracedResult
from symoro_elastic.output_folder import write_files

ARGUMENTS = {
    "q": "joint variables, rad or m",
    "qd": "joint velocities, rad/s or m/s",
    "qdd": "joint accelerations, rad/s2 or m/s2",
    "tau": "motor torques or forces, N m or N",
    "qdd_motor": "motor accelerations, rad/s2 or m/s2",
    "T": "placement of the frame, 4 x 4, row by row, lengths in m",
    "P": "place of the origin of the frame, m",
    "R0": "rotation from the axes of the base to those of the world, 3 x 3, row by row",
    "Q0": "turn of the base in the world, a quaternion w x y z of length 1, which is taken as it is",
    "P0": "place of the origin of the base in the world, m",
    "V0": "velocity of the origin of the base (m/s), its angular velocity (rad/s), in its axes",
    "V0d": "acceleration of the origin of the base (m/s2; dv/dt + w x v of V0), angular one (rad/s2), in its axes",
    "f0": "force on the base (N), moment about its origin (N m), in its axes; its weight is no part of it",
} | MOTION_WANTED
RESULTS = {
    "qdd": "joint accelerations, rad/s2 or m/s2",
    "tau": "motor torques or forces, N m or N",
    "A": "inertia matrix, kg m2, kg m or kg",
    "H": "Coriolis, centrifugal, gravity and friction forces, N m or N",
    "T": "placement of each frame, row by row, lengths in m",
    "V": "velocity of the origin (m/s), angular velocity (rad/s) of each frame, in its axes unless seen from another",
    "Vd": "acceleration of the origin (m/s2), angular one (rad/s2) of each frame, in its axes unless seen from another",
    "J": "Jacobian of each frame, in the axes of the base unless seen from another: V = J qd on a base at rest",
    "f": "force (N), then moment (N m) about its origin, that the antecedent exerts on each body, in its frame",
    "q": "joint variables of each solution, rad or m; NaN where there is none",
    "singularity": "zero where a solution is singular: product of the square roots and distances that vanish there",
    "E": "kinetic energy, gravity energy (zero at the origin of frame 0) and elastic energy, J",
    "Y": "regressor: torques are Y times the parameters that its columns name",
    "V0d": "acceleration of the origin of the base (m/s2; dv/dt + w x v of V0), angular one (rad/s2), in its axes",
    "f0": "force (N) and moment about its origin (N m) that move the base so, in its axes",
    "M": "inertia matrix, kg m2, kg m or kg",
    "D": "damping: derivatives of motor torques by qd, friction included, N m s/rad, N s or N s/m",
    "K": "stiffness: derivatives of motor torques by q, those of springs, gravity and inertia, N m/rad, N or N/m",
    "h": "energy regressor: energy is h times the parameters that its entries name, up to a constant",
    "X": "base inertial parameters",
    "dtau_dq": "derivatives of motor torques by q, springs and friction included",
    "dtau_dqdd_motor": "derivatives of motor torques by qdd_motor: the inertia matrix where every joint has a motor",
    "dqdd_dtau": "derivatives of joint accelerations by tau: columns of the inverse of the inertia matrix",
}
ROWS = {
    "tau": "motor torques",
    "qdd": "joint accelerations",
    "V0d": "the acceleration of the base",
    "f0": "the wrench on the base",
}
COLUMNS = {
    "q": "q",
    "qd": "qd",
    "qdd_motor": "qdd_motor",
    "tau": "tau",
    "p": "the parameters that its columns name",
    "pose": "pose: displacement, rotation (m, rad) in axes of the base, as are V0, V0d, f0",
    "V0": "V0",
    "V0d": "V0d",
    "f0": "f0",
}
RESULTS = {
    f"d{of}_d{by}": f"derivatives of {rows} by {columns}"
    for of, rows in ROWS.items()
    for by, columns in COLUMNS.items()
} | RESULTS
PARTICULAR = {
    ("jacobian_dot_qd", "Vd"): "(dJ/dt) qd of each frame (m/s2, rad/s2), in axes of the base unless seen from another",
    ("coriolis_forces", "H"): "Coriolis and centrifugal forces, and those of a moving base, N m or N",
    ("gravity_forces", "H"): "gravity forces, N m or N",
    ("friction_forces", "H"): "friction forces, N m or N",
    ("feed_forward", "q"): "joint variables: motor positions and deflections of springs, rad or m",
    ("feed_forward", "qd"): "joint velocities, rad/s or m/s",
    ("inverse_dynamics_derivatives", "dqdd_dq"): "derivatives of accelerations of elastic and passive joints by q",
    ("inverse_dynamics_derivatives", "dqdd_dqd"): "derivatives of accelerations of elastic and passive joints by qd",
    ("inverse_dynamics_derivatives", "dqdd_dqdd_motor"): (
        "derivatives of accelerations of elastic and passive joints by qdd_motor"
    ),
    ("inverse_dynamics_parameter_derivatives", "dqdd_dp"): (
        "derivatives of accelerations of elastic and passive joints by the parameters that its columns name"
    ),
    ("external_forces", "H"): "forces that balance the external wrenches, N m or N",
}
"""What results are in the models where `RESULTS` does not say it."""


@dataclass(frozen=True)
class Generated:
    """What was written, and the models it holds; `whole` are the same models of the whole machine."""

    written: list[Path]
    models: list[TracedModel]
    whole: list[TracedModel]


def nothing(_: str) -> None:
    """Progress that nobody watches."""


def generate(
    machine: Machine,
    scene: Scene,
    targets: Sequence[str],
    out: Path,
    step: Callable[[str], None] = nothing,
    precisions: Sequence[Precision] = (DOUBLE,),
) -> Generated:
    """Write the models that a scene asks of a machine to `out/<machine name>/`, C in each of the precisions.

    `step` is told each step of the journey by its verb. Raises `InputError`; nothing is written then.
    """
    step("check")
    refuse_degenerate(machine, scene)
    step("trace")
    models = trace_scene(machine, scene)
    whole = [_of_whole(machine, model) for model in models] if is_part(scene) else models
    step("render")
    described = package(restricted(machine, scene), models, folded(machine, scene), describe(scene, models))
    files = render(described, targets, machine.source, precisions)
    step("write")
    return Generated(write_files(out / machine.name, files), models, whole)


def described(machine: Machine, scene: Scene) -> Package:
    """The models that a scene asks of a machine, ready to be rendered. Raises `InputError`."""
    refuse_degenerate(machine, scene)
    models = trace_scene(machine, scene)
    return package(restricted(machine, scene), models, folded(machine, scene), describe(scene, models))


def render(
    described: Package, targets: Sequence[str], source: str, precisions: Sequence[Precision] = (DOUBLE,)
) -> dict[str, str]:
    """File names and texts; raises `InputError` for constants that no double holds and for too low a precision."""
    _refuse_low_precision(described, source, precisions)
    try:
        return render_targets(described, targets, precisions)
    except OverflowError:
        what = "their products are out of the range of double precision: check the units"
        raise InputError(source or described.name, "numbers of the table", what) from None


def _refuse_low_precision(described: Package, source: str, precisions: Sequence[Precision]) -> None:
    """Inverse geometry tells reachable places from others by bounds that are the rounding errors of doubles."""
    deciding = [f.name for f in described.functions if f.name in {model.name for model in INVERSE_GEOMETRIC}]
    low = [precision.name for precision in precisions if precision.bits < DOUBLE.bits]
    if deciding and low:
        what = f"{deciding[0]} finds no solution in {low[0]} precision: --precision double, or leave the model out"
        raise InputError(source or described.name, "--precision", what)


def refuse_taken_names(machine: Machine, traced: Sequence[TracedModel]) -> None:
    """Raise `InputError` for a parameter or joint variable called like a result or a macro of the header."""
    macros = tuple(f"{machine.name.upper()}_{word}" for word in ("P_", "JOINTS", "MOTORS", "FRAMES", "PARAMETERS"))
    taken = {name for model in traced for name in (*model.results, *model.model.arguments)}
    for name in [p.name for p in machine.parameters] + [str(joint.variable) for joint in machine.joints]:
        if name in taken or name.startswith(macros):
            what = "generated code uses this name: choose another for the parameter or joint variable"
            raise InputError(machine.source or machine.name, name, what)


def refuse_degenerate(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a machine whose asked models would divide by zero at every position."""
    found = found_degeneracies(machine, scene)
    if found:
        message, joints = found[0]
        likewise = "".join(f"; likewise {others}" for _, others in found[1:])
        raise InputError(machine.source or machine.name, joints, message + likewise)


def found_degeneracies(machine: Machine, scene: Scene) -> list[tuple[str, str]]:
    """(message, joints) of each pivot that is zero in one of the asked models."""
    kept, constants = restricted(machine, scene), folded(machine, scene)
    models = scene.models or DEFAULT_MODELS
    found: dict[int, Degeneracy] = {}
    for name, known_motors in (("direct_dynamics", False), ("inverse_dynamics", True)):
        if any(model.startswith(name) for model in models):
            for degeneracy in degeneracies(kept, known_motors, constants):
                found.setdefault(degeneracy.joint, degeneracy)
    ordered = [found[j] for j in sorted(found)]
    return [(d.message(kept), ", ".join(f"joint {j}" if j else BASE for j in d.moving_together)) for d in ordered]


def is_part(scene: Scene) -> bool:
    """Whether a scene asks for less than the whole machine."""
    return bool(scene.outputs or scene.locked or scene.fold or not scene.gravity)


def _of_whole(machine: Machine, part: TracedModel) -> TracedModel:
    """The same model, nothing left out; itself where it exists only with joints locked."""
    try:
        return trace_scene(machine, Scene(models=(part.model.name,)))[0]
    except InputError:
        return part


def describe(scene: Scene, models: Sequence[TracedModel] = ()) -> str:
    """A scene and its models in a few words; empty for the whole machine."""
    parts = [f"{name} held at {value}" for name, value in scene.locked.items()]
    parts += ["without gravity"] if not scene.gravity else []
    if any(model.merged for model in models):
        parts.append(f"angles are summed: valid for |q| <= {scene.merge_angles:g} rad")
    return ", ".join(parts)


def package(machine: Machine, traced: Sequence[TracedModel], folded: Sequence[str], scene: str = "") -> Package:
    """What the targets render for these models of a machine; raises `InputError` for names that are taken."""
    refuse_taken_names(machine, traced)
    moving = [machine.joints[j - 1] for j in machine.moving]
    return Package(
        name=machine.name,
        scene=scene,
        axes=tuple(Axis(joint.name, joint.kind, _unit(joint)) for joint in moving),
        motors=_of_kind(moving, "motor"),
        elastic=_of_kind(moving, "elastic"),
        frames=tuple(joint.name for joint in machine.joints),
        joint_names=(*(joint.name for joint in machine.joints), *_point_names(machine, traced)),
        parameters=tuple(
            ParameterValue(p.name, math.nan if p.value is None else p.value.value(), p.unit)
            for p in machine.parameters
            if p.name not in folded
        ),
        functions=tuple(_function(machine, model) for model in traced),
    )


def _of_kind(moving: Sequence[Joint], kind: str) -> tuple[int, ...]:
    return tuple(k for k, joint in enumerate(moving) if joint.kind == kind)


def _unit(joint: Joint) -> str:
    return f"{joint.variable}, {'m' if joint.sigma else 'rad'}"


def _function(machine: Machine, traced: TracedModel) -> Function:
    program = traced.program
    arguments = tuple(Argument(a.name, len(a.symbols), ARGUMENTS[a.name]) for a in program.inputs)
    results = tuple(
        Result(
            o.name,
            o.shape,
            PARTICULAR.get((traced.model.name, o.name)) or RESULTS[o.name],
            _row_names(machine, traced.results[o.name]),
            traced.results[o.name].column_labels,
            traced.whole,
        )
        for o in program.outputs
    )
    return Function(traced.model.name, traced.model.title, traced.model.equations, program, arguments, results)


def _row_names(machine: Machine, result: TracedResult) -> tuple[str, ...]:
    """What the first axis of a result follows: `tool`, `tool in bed_x`, `tool at (0.1, 0, L2)`."""
    names = [BASE, *(joint.name for joint in machine.joints)]
    if not result.frames:
        return tuple(names[j] for j in result.rows or ())
    return tuple(
        str(Asked(names[f.number], f.at, None if f.seen_from is None else names[f.seen_from])) for f in result.frames
    )


def _point_names(machine: Machine, traced: Sequence[TracedModel]) -> tuple[str, ...]:
    """Points of frames that have equations, in the order of their numbers."""
    names = [BASE, *(joint.name for joint in machine.joints)]
    return tuple(str(Asked(names[j], at)) for j, at in max((model.points for model in traced), key=len, default=()))
