"""What was identified, and the machine with these values, for files and other commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.described import with_changed_scene
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import INERTIAL, Cogging
from symoro_elastic.machine.machine import Body, Joint, Machine, Spring
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.measured.fitting.estimates import Estimate
from symoro_elastic.measured.logs.estimation import POSITIVE
from symoro_elastic.measured.logs.friction_laws import COSINE, LOAD, SINE, STATIC
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.result import Identification
from symoro_elastic.measured.logs.sensors import DELAY, OFFSET, shows
from symoro_elastic.measured.logs.validation import Fit
from symoro_elastic.measured.vibration_tests.updated import Updated
from symoro_elastic.numerics.linear.regressor import RegressorColumn

MOST_LOAD = 0.9  # share of the load above which a joint locks itself
RowValues = Mapping[tuple[int, str], float]
"""Values by row of the table and quantity."""
Refit = Callable[[Mapping[str, float]], Identification]
"""The same identification with more values known, by label."""


@dataclass(frozen=True, repr=False)
class Identified(Result):
    """Identified parameters of a machine, and their prediction of another record.

    `joint` is the fit of the log and of vibration tests, if any were given: its estimates replace those of the log.
    """

    found: Identification
    records: tuple[Measurements, ...]
    of_file: Machine
    settings: LogSettings
    validation: Fit | None = None
    joint: Updated | None = None

    @property
    def estimates(self) -> Mapping[str, float]:
        """Estimated values by label of the parameter or group; of a joint fit, of the parameters of its tests."""
        return self.joint.values if self.joint else {e.unknown.label: e.value for e in self.found.estimates}

    @property
    def headline(self) -> str:
        """Machine, parameters and samples."""
        return self.found.headline

    def saved(self, step: Announce = announce_nothing) -> tuple[Machine, list[str]]:
        """Return the machine with the estimates, and lines about estimates that no physical machine has."""
        if self.joint:
            return self.joint.saved()
        result = self.found
        if result.possible:
            return self._written(result), _not_saved(result)

        def again(fixed: Mapping[str, float]) -> Identification:
            fixed_values = {**self.settings.known, **dict.fromkeys(self.settings.unseen, 0.0), **fixed}
            settings = replace(self.settings, known=fixed_values, unseen=(), seek=(), trust=None, laws=result.laws)
            return identify(result.machine, self.records, settings, step, result.equations.Y)

        fitted, lines = without_negatives(result, again)
        return self._written(fitted), [*lines, *_not_saved(fitted)]

    def _written(self, result: Identification) -> Machine:
        return replace(
            machine_with_estimates(result, self.settings.values, self.settings.unseen), loops=self.of_file.loops
        )


def machine_with_estimates(
    result: Identification, values: Mapping[str, float] | None = None, unseen: Collection[str] = ()
) -> Machine:
    """Return the machine with the estimates in place of inertial parameters, friction and springs.

    Where bodies are possible all parameters are their own. Else inertial parameters are those of groups, so bodies are
    not real ones: torques are right. Parameters that joined
    others or have no effect are zero, and so are those that were not found, for what they exert is within the others;
    friction and springs that were not found keep the values of the file. Rotors have no ratio: their inertia is that
    which the joint feels. `values` are those of named parameters, `unseen` labels that keep the values of the file.
    """
    machine, bodies = result.machine, result.possible
    columns = result.equations.Y.columns
    hidden = {(column.row, column.quantity) for column in columns if column.label in unseen}
    every = {**(bodies.values if bodies else _values(result)), **_of_laws(result)}
    estimated = {key: x for key, x in every.items() if key not in hidden}
    joints = tuple(_with(joint, j, estimated, (j, "IA") in hidden) for j, joint in enumerate(machine.joints, start=1))
    bare = replace(machine, joints=joints, is_grouped=bodies is None)
    before, after = ({name for _, formula in formulas(x) for name in formula.names} for x in (machine, bare))
    parameters = [
        replace(p, value=Formula.parse(values[p.name])) if values and p.name in values else p
        for p in machine.parameters
        if p.name not in before - after
    ]
    return with_changed_scene(
        replace(bare, parameters=tuple(parameters)), lambda scene: _without(scene, before - after)
    )


def _not_saved(result: Identification) -> list[str]:
    """Return a line on offsets and the delay of sensors that show, which no machine has."""
    of_sensors = [e for e in result.estimates if e.unknown.quantity in (OFFSET, DELAY) and shows(e)]
    lost = [
        f"{e.unknown.label} = {e.value:.4g} is not saved, no friction has it: leave {e.unknown.joint} out of the law"
        for e in result.estimates
        if e.unknown.quantity in (LOAD, STATIC) and not _is_possible(e)
    ]
    if not of_sensors:
        return lost
    named = ", ".join(f"{e.unknown.label} = {e.value:.4g} {e.unknown.unit}" for e in of_sensors)
    what = "of the sensors, not of the machine, so the file does not hold them: correct records by them"
    return [*lost, f"{named}: {what}"]


def _is_possible(e: Estimate) -> bool:
    """Whether an estimate of a friction law is physically possible."""
    return 0 < e.value < (MOST_LOAD if e.unknown.quantity == LOAD else math.inf)


def without_negatives(result: Identification, refit: Refit) -> tuple[Identification, list[str]]:
    """Return a fit without negative masses, friction and other impossible values, and a line for each of them.

    They are known to be 0 there, stiffnesses to be those of the file, and the others are fitted again. Raises
    `InputError` for a negative stiffness where the file gives none.
    """
    fixed: dict[str, float] = {}
    lines = []
    while negative := [
        (column, x) for column, x in _estimated_columns(result) if column.quantity in POSITIVE and x < 0
    ]:
        for column, x in negative:
            fixed[column.label] = value = _least(column, x, result.machine)
            what = f"{column.label} = {x:.4g} is saved as {value:.6g}, because it is physically impossible"
            lines.append(f"{what}; the others are fitted again, as with --known {column.label}={value:.6g}")
        result = refit(fixed)
    return result, lines


def _least(column: RegressorColumn, x: float, machine: Machine) -> float:
    """Return the value that is saved in place of a negative estimate: zero, or a spring's value in the file."""
    if column.quantity != "K":
        return 0.0
    if column.value > 0:
        return column.value
    what = f"{x:.4g} was estimated, which no spring can have, and the file gives no value: give one to save it"
    raise machine.error(f"--known, {column.label}", what)


def _estimated_columns(result: Identification) -> Iterator[tuple[RegressorColumn, float]]:
    """Yield the estimated columns and the fixed ones, with their values."""
    columns, equations = result.equations.Y.columns, result.equations
    yield from ((columns[c], value) for c, value in equations.fixed.items())
    for value, c in zip(result.estimation.solution.X.tolist(), result.estimation.grouping.kept, strict=True):
        if c < len(equations.estimated_columns):  # what follows are offsets and the delay of sensors
            yield columns[equations.estimated_columns[c]], value


def _values(result: Identification) -> RowValues:
    """Return estimated and fixed values by row of the table and quantity."""
    return {(column.row, column.quantity): value for column, value in _estimated_columns(result)}


def _of_laws(result: Identification) -> RowValues:
    """Return load friction, static friction, Stribeck velocity and cogging by row; impossible values are omitted."""
    values = {}
    dry = _values(result)
    for e in result.estimates:
        j = result.machine.rows.get(e.unknown.joint, 0)
        if e.unknown.quantity == LOAD and _is_possible(e):
            values[j, "load"] = e.value
        if e.unknown.quantity == STATIC and _is_possible(e):
            values[j, "static"] = e.value + dry[j, "FS"]
            values[j, "stribeck"] = result.laws.stribeck[j]
        if e.unknown.quantity in (COSINE, SINE):
            values[j, e.unknown.quantity] = e.value
            values[j, "order"] = result.laws.cogging[j]
    return values


def _with(joint: Joint, j: int, values: RowValues, keeps_rotor: bool) -> Joint:
    """Return joint j with the values found."""
    if joint.body.has_inertia:
        body = Body.of({name: Formula.parse(values.get((j, name), 0.0)) for name in INERTIAL})
        joint = replace(joint, body=body)
    if joint.sigma == 2:
        return joint

    def cell(quantity: str, otherwise: Formula) -> Formula:
        return Formula.parse(values[j, quantity]) if (j, quantity) in values else otherwise

    rotor = Formula.parse(values.get((j, "IA"), 0.0))
    law = joint.friction
    friction = replace(law, viscous=cell("FV", law.viscous), coulomb=cell("FS", law.coulomb))
    laws = {key: cell(key, getattr(law, key)) for key in ("load", "static", "stribeck")}
    friction = replace(friction, **laws)
    joint = replace(joint, cogging=_cogging(joint, j, values, keeps_rotor))
    if (j, "DA") in values:
        friction = replace(friction, viscous=Formula.parse(0))
    if joint.has_spring:
        stiffness, damping = cell("K", joint.spring.stiffness), cell("DA", joint.spring.damping)
        joint = replace(joint, spring=Spring(stiffness, damping, _neutral(joint, j, values)))
    if keeps_rotor:
        return replace(joint, friction=friction)
    return replace(joint, rotor_inertia=rotor, ratio=Formula.parse(0), friction=friction)


def _cogging(joint: Joint, j: int, values: RowValues, keeps_rotor: bool) -> Cogging:
    """Return cogging from its cosine and sine terms, on the joint's axis unless the rotor keeps its ratio."""
    if (j, COSINE) not in values:
        return joint.cogging if keeps_rotor else joint.reflected_cogging
    cosine, sine = values[j, COSINE], values[j, SINE]
    cells = (math.hypot(cosine, sine), values[j, "order"], math.atan2(cosine, sine))
    own = Cogging(*map(Formula.parse, cells))
    if not keeps_rotor or joint.ratio.is_zero:
        return own
    ratio = joint.ratio
    over = {key: Formula(f"({x})/({ratio})", ("/", x.tree, ratio.tree)) for key, x in
            (("amplitude", own.amplitude), ("order", own.order))}  # fmt: skip
    return replace(own, **over)


def _neutral(joint: Joint, j: int, values: RowValues) -> Formula:
    """Return q0 = KQ / K, or the value of the file where they were not found."""
    force, stiffness = values.get((j, "KQ"), math.nan), values.get((j, "K"), math.nan)
    return Formula.parse(force / stiffness) if math.isfinite(force) and abs(stiffness) > 0 else joint.spring.neutral


def _without(scene: Scene, gone: set[str]) -> Scene:
    """Return the scene without constants that the machine no longer has."""
    return scene if scene.fold == ALL else replace(scene, fold=tuple(name for name in scene.fold if name not in gone))
