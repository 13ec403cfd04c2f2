"""The models of a scene, restricted and traced, as a package for the targets."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from pathlib import PurePath

from symoro_elastic.codegen.package import Argument, Axis, Constant, Function, Package, ParameterValue, Result
from symoro_elastic.codegen.printed_order import with_named_sums
from symoro_elastic.codegen.targets import KEYWORDS, RESERVED
from symoro_elastic.codegen.time_steps import CLOSED
from symoro_elastic.machine.arguments import arguments, known_of_base
from symoro_elastic.machine.congruent import congruent_joints, congruent_symbols
from symoro_elastic.machine.formula import FUNCTIONS, Formula, FormulaError
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.names import IN_USE, LIBRARY, Reasons, why_no_joint, why_no_machine
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import INERTIA, RequestedPart, Scene
from symoro_elastic.machine.series_springs import condense
from symoro_elastic.models.bound.model import Frame, Pivots
from symoro_elastic.models.bound.model import Result as TracedResult
from symoro_elastic.models.bound.state import rows_carried
from symoro_elastic.models.drives.drive_states import state_names
from symoro_elastic.models.parameters.base_parameters import GroupingOf, grouping_of_tree
from symoro_elastic.models.programs.catalogue import BY_INERTIA, MODELS, Model, TracedModel, trace_scene
from symoro_elastic.models.steps.time_steps import models_of_steps
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.program import NamedConstant

DERIVED = {
    "MS": "first moment",
    "J": "inertia",
    "dJ": "difference of inertias",
    "M": "mass",
    "Js": "articulated inertia",
    "K": "articulated inertia",
    "H": "inertia moved",
    "Hinv": "inverse of the inertia moved",
    "UH": "articulated inertia over the inertia moved",
    "rho": "share of the rotor in the inertia moved",
    "P": "position of its origin",
}
"""Quantities of the equations that may be constant, by the letters of their names."""
STRUCTURAL = (0, 1, 2, Fraction(1, 2))
"""Numbers of the equations themselves; equal numbers of a machine are not named."""
_NAME = re.compile(r"(?P<letters>[A-Za-z]+)\d+(?P<composite>_c)?_?(?P<component>\w*)", re.ASCII)

KEYWORD = "it is a keyword of C, C++ or Python"


def package(
    machine: Machine, traced: Sequence[TracedModel], folded: Sequence[str], scene: str = "", steps: Sequence[str] = ()
) -> Package:
    """The package of traced models of a machine; raises `InputError` for reserved names."""
    refuse_taken_names(machine)
    coupled, names, limbs = machine.is_coupled, FrameNames(machine), congruent_joints(machine)
    return Package(
        name=machine.name,
        scene=scene,
        axes=_axes(machine, machine.independent),
        motors=machine.motor_entries,
        elastic=machine.elastic_entries,
        frames=tuple(map(names.name, names.all())),
        joint_names=(*(joint.name for joint in machine.joints), *_point_names(machine, traced)),
        parameters=tuple(
            ParameterValue(p.name, math.nan if p.value is None else p.value.value(), p.unit)
            for p in machine.parameters
            if p.name not in folded
        ),
        functions=tuple(_function(machine, model, folded, bool(limbs)) for model in traced),
        antecedents=tuple(joint.antecedent for joint in machine.joints),
        source=PurePath(machine.source).name,
        options=_options(machine, folded, scene),
        dependent=_axes(machine, machine.dependent) if coupled else None,
        driven=_axes(machine, machine.motors) if coupled else None,
        following=tuple((row.name, row.kind.value) for row in machine.joints if row.kind in (Kind.COUPLED, Kind.CUT)),
        steps=tuple(steps),
        state=_state(machine),
        states=state_names(machine, any(model.model.name == CLOSED for model in traced)),
        limbs=limbs,
        congruent=congruent_symbols(machine, limbs),
    )


def _state(machine: Machine) -> tuple[Argument, ...]:
    """The blocks of the state that time steps integrate, with their lengths."""
    entries = arguments(machine)
    return tuple(Argument(row, len(entries[row.name])) for row in rows_carried(machine))


def _axes(machine: Machine, joints: Sequence[int]) -> tuple[Axis, ...]:
    """Joints by number, with their coordinates."""
    rows = map(machine.joint, joints)
    return tuple(Axis(joint.name, joint.kind, f"{joint.variable}, {joint.unit}") for joint in rows)


def _options(machine: Machine, folded: Sequence[str], scene: str) -> tuple[str, ...]:
    """Options of the generated code: scene, gravity, base inertial parameters, folded parameters."""
    options = [*([scene] if scene else []), machine.gravity_in_words]
    options += ["base inertial parameters"] if machine.is_grouped else []
    options += [f"constants: {', '.join(folded)}"] if folded else []
    return tuple(options)


def _function(machine: Machine, traced: TracedModel, folded: Sequence[str], has_limbs: bool) -> Function:
    model = traced.model
    program = with_named_sums(traced.program) if has_limbs else traced.program
    frames_placed = [frame for result in traced.results.values() if result.rows is None for frame in result.frames]
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
        placed=_frame_name(machine, frames_placed[0]) if frames_placed else "",
    )


def _divides(machine: Machine, model: Model) -> bool:
    """Whether a model of a machine divides by the inertia of a joint or of the base."""
    if model.pivots is None:
        return False
    free_base = "f0" in known_of_base(machine)
    without_motor = len(machine.motors) < len(machine.independent)
    return free_base or without_motor or (model.pivots is Pivots.ALL and bool(machine.independent))


def _row_names(machine: Machine, result: TracedResult) -> tuple[str, ...]:
    """Labels of the first axis of a result: `tool`, `tool in bed_x`, `tool at (0.1, 0, L2)`."""
    names = FrameNames(machine)
    if not result.frames:
        return tuple(map(names.joint, result.rows or ()))
    return tuple(_frame_name(machine, frame) for frame in result.frames) if result.rows is not None else ()


def _frame_name(machine: Machine, frame: Frame) -> str:
    name = FrameNames(machine).name
    return str(RequestedPart(name(frame.number), frame.at, None if frame.seen_from is None else name(frame.seen_from)))


def _point_names(machine: Machine, traced: Sequence[TracedModel]) -> tuple[str, ...]:
    """Names of requested points that have equations, in the order of their numbers."""
    name = FrameNames(machine).name
    return tuple(
        str(RequestedPart(name(j), at)) for j, at in max((model.points for model in traced), key=len, default=())
    )


def reserved_words() -> Reasons:
    """Names that no machine may use, with the reason: those of models, and of target languages and libraries."""
    libraries, keywords = dict.fromkeys(RESERVED, LIBRARY), dict.fromkeys(KEYWORDS, KEYWORD)
    return {**libraries, **keywords, **dict.fromkeys(MODELS, IN_USE)}


def refuse_taken_names(machine: Machine) -> None:
    """Raise `InputError` for a name of the machine that a language or its libraries use, or a model."""
    words = reserved_words()
    used = [p.name for p in machine.parameters] + [joint.variable for joint in machine.joints if joint.variable]
    rules = [(why_no_machine, [machine.name]), (why_no_joint, [joint.name for joint in machine.joints])]
    faults = [(name, why(name, words)) for why, names in rules for name in names if name in words]
    for name, reason in (*faults, *((name, words.get(name)) for name in used)):
        if reason:
            raise machine.error(name, f"{reason}: choose another")


# Named numbers of a machine, with meaning and unit: cells of its table, and quantities that turn out constant.
def constants_of(machine: Machine, traced: TracedModel, folded: Sequence[str]) -> tuple[Constant, ...]:
    """Return the named numbers of a model, those of the machine's table first.

    A cell that is nothing but a folded parameter has the parameter's name.
    """
    values = _values(machine, folded)
    constants: list[Constant] = []
    for axis, formula in zip("xyz", machine.base.gravity, strict=True):
        value = _exact(formula, values)
        magnitude = None if value is None else abs(value)
        constants += _cell(f"gravity_{axis}", formula, magnitude, None, f"gravity along {axis}0, magnitude", "m/s2")
    for j, joint in enumerate(machine.joints, start=1):
        constants += _of_joint(j, joint, values)
    constants += [c for constant in traced.program.named_constants for c in _derived_constants(machine, constant)]
    return tuple(c for c in constants if isinstance(c.value, Expression) or abs(c.value) not in STRUCTURAL)


def _values(machine: Machine, folded: Sequence[str]) -> dict[str, Fraction]:
    formulas = {p.name: p.value for p in machine.parameters if p.name in folded and p.value is not None}
    exact = {name: _exact(formula, {}) for name, formula in formulas.items()}
    return {name: value for name, value in exact.items() if value is not None}


def _exact(formula: Formula, values: Mapping[str, Fraction]) -> Fraction | None:
    """Return the value of a formula if it is rational; None for other values."""
    try:
        value = formula.evaluate(values, dict.fromkeys(FUNCTIONS, _irrational), Fraction)
    except (ArithmeticError, FormulaError, KeyError, ValueError):
        return None
    return Fraction(value) if isinstance(value, int | Fraction) else None


def _irrational(*_: object) -> None:
    raise ValueError


def _of_joint(j: int, joint: Joint, values: Mapping[str, Fraction]) -> Iterator[Constant]:
    slides = joint.sigma == 1
    force, angle = ("N", "m") if slides else ("N m", "rad")
    inertia = "kg" if slides else "kg m2"
    rows = (
        ("k", joint.spring.stiffness, "stiffness", f"{force}/{angle}"),
        ("h", joint.spring.damping, "damping", f"{force} s/{angle}"),
        ("n", joint.spring.neutral, "neutral position", angle),
        ("bl", joint.spring.backlash, "backlash", angle),
        ("e", joint.spring.rounding, "rounding of the backlash", angle),
        ("Fv", joint.friction.viscous, "viscous friction", f"{force} s/{angle}"),
        ("Fs", joint.friction.coulomb, "Coulomb friction", force),
        ("vs", joint.friction.creep, "creep velocity of dry friction", f"{angle}/s"),
        ("Ia", joint.reflected_inertia, "rotor inertia", inertia),
        ("b", joint.b, "length b", "m"),
        ("d", joint.d, "length d", "m"),
        ("r", joint.r, "length r", "m"),
        ("M", joint.body.mass, "mass", "kg"),
    )
    for letters, formula, meaning, unit in rows:
        yield from _cell(f"{letters}{j}", formula, _exact(formula, values), j, meaning, unit)


def _cell(
    name: str, formula: Formula, value: Fraction | None, joint: int | None, meaning: str, unit: str
) -> Iterator[Constant]:
    if value is not None:
        yield Constant(str(formula.tree[1]) if formula.tree[0] == "name" else name, value, joint, meaning, unit)


def _derived_constants(machine: Machine, constant: NamedConstant) -> Iterator[Constant]:
    """Yield a named constant with meaning and unit if `DERIVED` knows it, such as an articulated inertia; else none."""
    joint, name = constant.label.section.joint, constant.label.name
    match = _NAME.fullmatch(name)
    if not match or not joint or joint > len(machine.joints) or match["letters"] not in DERIVED:
        return
    letters, component = match["letters"], match["component"]
    words = [DERIVED[letters]]
    words += [component.upper()] if letters in ("MS", "J") and component else []
    words += ["with all it carries"] if match["composite"] else []
    yield Constant(name, constant.value, joint, " ".join(words), _unit(letters, component, machine.joints[joint - 1]))


def _unit(letters: str, component: str, joint: Joint) -> str:
    inertia = "kg" if joint.sigma == 1 else "kg m2"
    if letters in ("Js", "K") and component.isdigit():
        return ("kg", "kg m", "kg m2")[sum(int(digit) > 3 for digit in component)]
    if letters == "UH" and component.isdigit():
        along = {(True, False): "", (True, True): "m", (False, False): "1/m", (False, True): ""}
        return along[joint.sigma == 1, int(component) > 3]
    units = {"MS": "kg m", "J": "kg m2", "dJ": "kg m2", "M": "kg", "H": inertia, "P": "m", "rho": ""}
    return units.get(letters, f"1/{inertia}" if inertia == "kg" else "1/(kg m2)")


@dataclass(frozen=True, eq=False)
class Traced:
    """The models of a scene as programs; `whole` is the unrestricted machine."""

    whole: Machine
    scene: Scene
    models: Sequence[TracedModel]

    @cached_property
    def machine(self) -> Machine:
        """The machine restricted to the scene."""
        return restrict(self.whole, self.scene)

    @cached_property
    def folded(self) -> tuple[str, ...]:
        """Names of the parameters that are constants in the programs."""
        return names_to_fold(self.whole, self.scene)

    @cached_property
    def package(self) -> Package:
        """The package for the targets; raises `InputError` for reserved names."""
        notes = condense(self.whole).notes if self.scene.condense else ()
        scene = ", ".join(filter(None, (summary(self.scene, self.models), *notes)))
        return package(self.machine, self.models, self.folded, scene, self.scene.steps)


def trace_models(machine: Machine, scene: Scene, grouping_of: GroupingOf = grouping_of_tree) -> Traced:
    """The programs of the models of a scene; raises `InputError`."""
    return with_steps(machine, scene, trace_scene(machine, scene, grouping_of))


def with_steps(machine: Machine, scene: Scene, models: Sequence[TracedModel]) -> Traced:
    """The programs of `models` and of the models that the time steps of the scene call."""
    complete = [model for model in models if model.whole]
    called = models_of_steps(restrict(machine, scene), scene.steps, names_to_fold(machine, scene), complete)
    return Traced(machine, scene, [*models, *called])


def summary(scene: Scene, models: Sequence[TracedModel] = ()) -> str:
    """Summary of a scene and its models; empty for an unrestricted machine."""
    parts = [f"{name} held at {value}" for name, value in scene.locked.items()]
    parts += [f"{name} static, held {_position(value)}" for name, value in scene.static.items()]
    parts += [f"without {', '.join(scene.zero)}"] if scene.zero else []
    parts += ["without gravity"] if not scene.gravity else []
    if scene.form == INERTIA:
        by_inertia = [model.model.name for model in models if model.model.name in BY_INERTIA]
        parts += [f"{name} through the inertia matrix" for name in by_inertia]
    if any(model.merged for model in models):
        parts.append(f"angles are summed: valid for |q| <= {scene.merge_angles:g} rad")
    return ", ".join(parts)


def _position(value: Formula | None) -> str:
    return "where its spring is neutral" if value is None else f"at {value}"
