"""Conversion of a machine and its traced models to a package for the targets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import PurePath

from symoro_elastic.codegen.package import Argument, Axis, Function, Package, ParameterValue, Result
from symoro_elastic.codegen.targets import KEYWORDS, RESERVED
from symoro_elastic.machine.machine import Given, Kind, Machine
from symoro_elastic.machine.names import IN_USE, LIBRARY, Reasons
from symoro_elastic.machine.scene import BASE, Asked
from symoro_elastic.machine_constants import constants_of
from symoro_elastic.models.base_steps import orientation_of
from symoro_elastic.models.catalogue import MODELS, Model, TracedModel
from symoro_elastic.models.model import Pivots
from symoro_elastic.models.model import Result as TracedResult
from symoro_elastic.quantities import quantity

KEYWORD = "it is a keyword of C, C++ or Python"


def package(
    machine: Machine, traced: Sequence[TracedModel], folded: Sequence[str], scene: str = "", steps: Sequence[str] = ()
) -> Package:
    """The package of these models of a machine; raises `InputError` for reserved names."""
    refuse_taken_names(machine)
    coupled = machine.is_coupled
    return Package(
        name=machine.name,
        scene=scene,
        axes=_axes(machine, machine.moving),
        motors=machine.motor_entries,
        elastic=machine.elastic_entries,
        frames=tuple(joint.name for joint in machine.joints),
        joint_names=(*(joint.name for joint in machine.joints), *_point_names(machine, traced)),
        parameters=tuple(
            ParameterValue(p.name, math.nan if p.value is None else p.value.value(), p.unit)
            for p in machine.parameters
            if p.name not in folded
        ),
        functions=tuple(_function(machine, model, folded) for model in traced),
        antecedents=tuple(joint.antecedent for joint in machine.joints),
        source=PurePath(machine.source).name,
        options=_options(machine, folded, scene),
        dependent=_axes(machine, machine.dependent) if coupled else None,
        driven=_axes(machine, machine.motors) if coupled else None,
        following=tuple((row.name, row.kind.value) for row in machine.joints if row.kind in (Kind.COUPLED, Kind.CUT)),
        steps=tuple(steps),
        base=_base_state(machine),
    )


def _base_state(machine: Machine) -> tuple[Argument, ...]:
    """The arguments that are the state of a floating base under a known wrench."""
    if machine.floating is None or machine.floating.known is Given.ACCELERATION:
        return ()
    rows = map(quantity, (orientation_of(machine), "P0", "V0"))
    return tuple(Argument(row, len(row.entries)) for row in rows)


def _axes(machine: Machine, joints: Sequence[int]) -> tuple[Axis, ...]:
    """Joints by number, with their own variables."""
    rows = map(machine.joint, joints)
    return tuple(Axis(joint.name, joint.kind, f"{joint.variable}, {joint.unit}") for joint in rows)


def _options(machine: Machine, folded: Sequence[str], scene: str) -> tuple[str, ...]:
    """Options that shaped the code: scene, base inertial parameters, folded parameters."""
    found = [scene] if scene else []
    found += ["base inertial parameters"] if machine.is_grouped else []
    found += [f"constants: {', '.join(folded)}"] if folded else []
    return tuple(found)


def _function(machine: Machine, traced: TracedModel, folded: Sequence[str]) -> Function:
    model, program = traced.model, traced.program
    return Function(
        model.name,
        model.title,
        model.equations,
        program,
        tuple(Argument(model.quantity(a.name), len(a.symbols)) for a in program.inputs),
        tuple(
            Result(
                model.quantity(o.name),
                o.shape,
                _row_names(machine, traced.results[o.name]),
                traced.results[o.name].column_labels,
                traced.whole,
            )
            for o in program.outputs
        ),
        _divides(machine, model),
        model.least_bits,
        constants_of(machine, traced, folded),
    )


def _divides(machine: Machine, model: Model) -> bool:
    """Whether a model of a machine divides by the inertia of a joint or of a floating base."""
    if model.pivots is None:
        return False
    free_base = machine.floating is not None and machine.floating.known is Given.WRENCH
    without_motor = len(machine.motors) < len(machine.moving)
    return free_base or without_motor or (model.pivots is Pivots.ALL and bool(machine.moving))


def _row_names(machine: Machine, result: TracedResult) -> tuple[str, ...]:
    """Labels of the first axis of a result: `tool`, `tool in bed_x`, `tool at (0.1, 0, L2)`."""
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


def reserved_words() -> Reasons:
    """Names that no machine may use: those of models, and those of the languages and libraries of targets; reasons."""
    libraries, keywords = dict.fromkeys(RESERVED, LIBRARY), dict.fromkeys(KEYWORDS, KEYWORD)
    return {**libraries, **keywords, **dict.fromkeys(MODELS, IN_USE)}


def refuse_taken_names(machine: Machine) -> None:
    """Raise `InputError` for a name of the machine that a language or its libraries use, or a model."""
    words = reserved_words()
    used = [p.name for p in machine.parameters] + [joint.variable for joint in machine.joints if joint.variable]
    for name in (machine.name, *(joint.name for joint in machine.joints), *used):
        if name in words:
            raise machine.error(name, f"{words[name]}: choose another")
