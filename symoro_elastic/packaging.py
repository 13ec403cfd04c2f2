"""What the targets render for a machine: its names, and its traced models as functions."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symoro_elastic.codegen.package import Argument, Axis, Function, Package, ParameterValue, Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import BASE, Asked
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.models.model import Result as TracedResult
from symoro_elastic.quantities import ARGUMENTS, PARTICULAR, RESULTS


def package(machine: Machine, traced: Sequence[TracedModel], folded: Sequence[str], scene: str = "") -> Package:
    """What the targets render for these models of a machine; raises `InputError` for names that are taken."""
    refuse_taken_names(machine, traced)
    return Package(
        name=machine.name,
        scene=scene,
        axes=tuple(Axis(joint.name, joint.kind, f"{joint.variable}, {joint.unit}") for joint in machine.moving_joints),
        motors=machine.motor_entries,
        elastic=machine.elastic_entries,
        frames=tuple(joint.name for joint in machine.joints),
        joint_names=(*(joint.name for joint in machine.joints), *_point_names(machine, traced)),
        parameters=tuple(
            ParameterValue(p.name, math.nan if p.value is None else p.value.value(), p.unit)
            for p in machine.parameters
            if p.name not in folded
        ),
        functions=tuple(_function(machine, model) for model in traced),
    )


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


def refuse_taken_names(machine: Machine, traced: Sequence[TracedModel]) -> None:
    """Raise `InputError` for a parameter or joint variable called like a result or a macro of the header."""
    macros = tuple(f"{machine.name.upper()}_{word}" for word in ("P_", "JOINTS", "MOTORS", "FRAMES", "PARAMETERS"))
    taken = {name for model in traced for name in (*model.results, *model.model.arguments)}
    for name in [p.name for p in machine.parameters] + [str(joint.variable) for joint in machine.joints]:
        if name in taken or name.startswith(macros):
            what = "generated code uses this name: choose another for the parameter or joint variable"
            raise machine.error(name, what)
