"""Generated code against a 50-digit reference, at moderate and at extreme states.

The error of a result is its largest difference over its largest reference entry, or over 1 where
the result is zero. It may be 1e-12; where it is more, 64 times the change that one ulp of the inputs
and of sines and cosines makes (and, at extreme states, one ulp of A and H).
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import CompiledPackage, CompilerMissing, compile_package
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import CheckedBy
from symoro_elastic.models.drives.control import CONTROLLERS
from symoro_elastic.models.dynamics.load_coordinates import chains, load_positions
from symoro_elastic.models.packaging import Traced, trace_models
from symoro_elastic.models.programs.catalogue import MODELS, TracedModel
from symoro_elastic.numerics.evaluation.linear_systems import REFERENCE_ZERO, Numbers, Singular, distance, dot
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.verification.coupled_disagreement import branch_error, newton_euler_disagreement
from symoro_elastic.numerics.verification.implementations import (
    Implementation,
    ResultArrays,
    c_code,
    equations_on_floats,
    import_package,
    numpy_code,
)
from symoro_elastic.numerics.verification.reference import DIGITS, Reference, StateReference
from symoro_elastic.numerics.verification.states import States, depends_on_state, extreme_states, moderate_states
from symoro_elastic.quantities import HIGHEST_DERIVATIVE, MOTION
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.decimals import in_digits
from symoro_elastic.symbolic.duals import Dual, differentiating

Runs = list[tuple[str, ResultArrays]]

BOUND = 1e-12
ULPS = 64
ULP_MOVES = 4
AGREEMENT = 1e-20
MOST_SOLVED = 40
MANY_STATEMENTS, MOST_STATEMENTS = 10_000, 15_000


@dataclass(frozen=True)
class Worst:
    """The worst relative errors of an implementation of a model.

    `share` is the largest error over its bound, `at` the state where that is.
    """

    moderate: float = 0.0
    extreme: float = 0.0
    share: float = 0.0
    at: str = ""

    @property
    def error(self) -> float:
        """The worst error of all."""
        return max(self.moderate, self.extreme)

    @property
    def ok(self) -> bool:
        """Whether every error is within its bound."""
        return self.share <= 1.0

    def __or__(self, other: Worst) -> Worst:
        first = self if self.share >= other.share else other
        return Worst(max(self.moderate, other.moderate), max(self.extreme, other.extreme), first.share, first.at)


@dataclass(frozen=True)
class ModelVerification:
    """Verification of a model: worst errors of the generated code and of the equations on floats.

    `c` is None without a compiler. `moderate` and `extreme` count the states that were judged,
    `bound` is the largest error allowed at one of them, `unjudged` names the others and why.
    """

    name: str
    numpy: Worst
    c: Worst | None
    equations: Worst
    moderate: int
    extreme: int
    bound: float
    unjudged: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether states were judged and all errors are within their bounds."""
        implementations = (self.numpy, self.equations, *((self.c,) if self.c else ()))
        return self.moderate > 0 and all(worst.ok for worst in implementations)


@dataclass(frozen=True, repr=False)
class Verification(Result):
    """Verification of all models of a scene.

    `missing` says what kept the C code from being compared (empty when nothing did);
    `disagreement` is how far A and H are from the recursive Newton-Euler algorithm in 50 digits, and the motion of a
    feed-forward from the equations of motion.
    """

    models: tuple[ModelVerification, ...]
    states: int
    disagreement: float
    missing: str = ""
    name: str = ""

    @property
    def ok(self) -> bool:
        """Whether everything that was compared is within its bound."""
        return self.disagreement <= AGREEMENT and all(model.ok for model in self.models)

    @property
    def headline(self) -> str:
        """Machine, models and the verdict."""
        verdict = "every error is within its bound" if self.ok else "out of bounds"
        return f"Verification of {self.name}: {len(self.models)} models, {verdict}"


def verify(
    machine: Machine,
    scene: Scene | None = None,
    *,
    states: tuple[int, int] | None = None,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Verification:
    """Compare generated C, generated numpy and the equations on floats with a 50-digit reference.

    `machine` is the whole machine, `scene` the parts and models to verify (default models
    where it names none), `states` how many moderate and extreme states. Parameters that have no
    value get a plausible one. `progress(done, total)` is called after each state.
    Raises `NoValues`, `SingularPivot`, `CompilationFailed`.
    """
    programs = trace_models(machine, scene or Scene(), grouping_by_rank)
    with temporary_folder() as folder:
        code = build_code(programs.package, render_verified(programs.package), Path(folder))
        return compare(programs, code, states=states, seed=seed, progress=progress)


def render_verified(package: Package) -> Files:
    """Return the files that are verified: the numpy package and the C library."""
    return render_numpy(package) | render_c_batch(package)


@dataclass(frozen=True)
class Code:
    """Generated code that can be run: the numpy package, the C library, or the reason why that is missing."""

    module: ModuleType
    library: CompiledPackage | None
    missing: str = ""


def build_code(package: Package, files: Files, folder: Path) -> Code:
    """Return the rendered files of a package, imported and compiled in a folder; raises `CompilationFailed`."""
    python = {name: text for name, text in files.items() if name.endswith(".py")}
    module = import_package(python, folder / "numpy")
    sources = {name: text for name, text in files.items() if name not in python}
    try:
        return Code(module, compile_package(package, folder / "c", sources))
    except CompilerMissing as error:
        return Code(module, None, error.what)


@in_digits(DIGITS)
def compare(
    programs: Traced,
    code: Code,
    *,
    states: tuple[int, int] | None = None,
    seed: int = 0,
    progress: Progress = no_progress,
) -> Verification:
    """Compare code, and the equations on floats, with a 50-digit reference; arguments as for `verify`."""
    machine, models = programs.machine, programs.models
    values = parameter_values(machine, seed)
    moderate, extreme = states or _how_many(models)
    stacked = moderate_states(machine, moderate, seed, values) + extreme_states(machine, extreme, seed, values)
    runs = _run(code, programs, values, stacked)
    reference = Reference(machine, values, programs.folded, solved=len(machine.independent) <= MOST_SOLVED)
    tallies = [_Tally(model, runs[model.model.name]) for model in models]
    for k in range(len(stacked)):
        state = _TestState(k, stacked.titles[k], dict(stacked[k].blocks), k >= moderate, f"{seed} {k}")
        point = reference.at(state.arguments)
        for tally in tallies:
            tally.add(state, point)
        progress(k + 1, len(stacked))
    disagreement = _disagreement(reference, models, stacked)
    verified = tuple(tally.verification() for tally in tallies)
    return Verification(verified, len(stacked), disagreement, code.missing, programs.whole.name)


def _how_many(traced: Sequence[TracedModel]) -> tuple[int, int]:
    """Return the numbers of moderate and extreme states: fewer for large models."""
    statements = sum(len(model.program.once) + len(model.program.statements) for model in traced)
    if statements < MANY_STATEMENTS:
        return 32, 32
    return (8, 16) if statements < MOST_STATEMENTS else (2, 4)


def _run(code: Code, programs: Traced, values: Mapping[str, float], states: States) -> dict[str, Runs]:
    """Return the results of every implementation by model."""
    p = np.array([values[parameter.name] for parameter in programs.package.parameters], dtype=float)
    implementations: list[tuple[str, Implementation]] = [
        ("numpy", numpy_code(code.module, p, stacked=False)),
        ("numpy", numpy_code(code.module, p, stacked=True)),
        ("equations", equations_on_floats(values)),
    ]
    if code.library:
        implementations += [("c", c_code(code.library, p, batch)) for batch in (False, True)]
    return {x.model.name: [(name, run(x, states)) for name, run in implementations] for x in programs.models}


@dataclass(frozen=True)
class _TestState:
    number: int
    title: str
    arguments: dict[str, Array]
    extreme: bool
    seed: str

    def __str__(self) -> str:
        return f"state {self.number + 1} ({self.title})"


class _Tally:
    """Accumulates the errors of a model, state by state."""

    def __init__(self, traced: TracedModel, runs: Runs) -> None:
        self.traced, self.runs = traced, runs
        self.worst = {name: Worst() for name, _ in runs}
        self.judged = {False: 0, True: 0}
        self.bound = BOUND
        self.unjudged: list[str] = []

    def add(self, state: _TestState, point: StateReference) -> None:
        """Compare all implementations at a state."""
        try:
            wanted = _reference_results(point, self.traced)
            errors = [(name, self._error(results, wanted, state.number)) for name, results in self.runs]
            bound = BOUND
            if max(size for _, size in errors) > BOUND:
                bound = max(BOUND, ULPS * self._effect(state, point.reference, wanted))
        except (Singular, ZeroDivisionError) as reason:
            self.unjudged.append(f"{state}: {reason}")
            return
        if bound >= 1:
            self.unjudged.append(f"{state}: one ulp of the inputs changes the result completely")
            return
        self.judged[state.extreme] += 1
        self.bound = max(self.bound, bound)
        for name, error in errors:
            moderate, extreme = (0.0, error) if state.extreme else (error, 0.0)
            self.worst[name] |= Worst(moderate, extreme, error / bound, str(state))

    def verification(self) -> ModelVerification:
        """Return the errors at all states."""
        return ModelVerification(
            self.traced.model.name,
            self.worst["numpy"],
            self.worst.get("c"),
            self.worst["equations"],
            self.judged[False],
            self.judged[True],
            self.bound,
            tuple(self.unjudged),
        )

    def _error(self, results: ResultArrays, wanted: Mapping[str, Numbers], state: int) -> float:
        """Return the error of the worst result; infinite where one is not a number."""
        return max(_error(results[name][state].ravel(), entries) for name, entries in wanted.items())

    def _effect(self, state: _TestState, reference: Reference, wanted: Mapping[str, Numbers]) -> float:
        """Return the largest change of the results by one ulp of the inputs."""
        source = random.Random(state.seed)
        near = [reference.near(state.arguments, source, state.extreme) for _ in range(ULP_MOVES)]
        moved = [_reference_results(point, self.traced) for point in near]
        return max(distance(other[name], entries) for other in moved for name, entries in wanted.items())


def _reference_results(point: StateReference, traced: TracedModel) -> Mapping[str, Numbers]:
    """Return the results of the reference."""
    put_back = traced.model.checked_by is CheckedBy.EQUATIONS_OF_MOTION and point.reference.solved
    results = torques(point, traced) if put_back else point.model(traced)
    if any(math.isnan(x) for entries in results.values() for x in entries):
        raise Singular("formulas or their slopes have no value at this state")
    return results


def _error(computed: Array, wanted: Numbers) -> float:
    """Return the `distance` of floats from the reference, rounded to a sum of two doubles."""
    high = np.array([float(x) for x in wanted])
    low = np.array([float(x - Decimal(h)) for x, h in zip(wanted, high.tolist(), strict=True)])
    with np.errstate(all="ignore"):
        difference = float(np.abs((computed - high) - low).max(initial=0.0))
    scale = float(np.abs(high).max(initial=0.0))
    error = difference / (scale if scale > REFERENCE_ZERO else 1.0)
    return error if math.isfinite(error) else math.inf


def _disagreement(reference: Reference, traced: Sequence[TracedModel], states: States) -> float:
    """Return the error of A and H against recursive Newton-Euler, and of traced models against solved ones."""
    rows = [states[k].blocks for k in range(len(states))]
    first = reference.at(rows[0])
    worst = max(newton_euler_disagreement(first), *(branch_error(reference, row) for row in rows))
    following = [model for model in traced if model.model.checked_by is CheckedBy.EQUATIONS_OF_MOTION]
    points = [reference.at(row) for row in (rows if following else ())]
    worst = max([worst, *(residual(point, model) for model in following for point in points)])
    if reference.solved:
        return worst
    for model in traced:
        wanted = first.model(model, solved=True)
        worst = max(worst, *(distance(x, wanted[name]) for name, x in first.model(model).items()))
    return worst


def refuse_unverifiable(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a model whose arguments are not a state: it has no reference."""
    for name in scene.models:
        if not depends_on_state(MODELS[name].arguments):
            put_back = "put its solutions back into geometric_model, jacobian or inverse_dynamics"
            of_drives = name in {model.name for model in CONTROLLERS}
            what = f"there is no reference for it: {'simulate with drives = true' if of_drives else put_back}"
            raise machine.error(f"check, {name}", what)


# Residual of the feed-forward in the equations of motion, in many digits.
#
# The program is evaluated at y(t) with its rate, which gives q(t), its velocity and acceleration; A and H [8] then give
# the torques. The springs' law, and the sum of motor and springs being y, are checked apart.
@dataclass(frozen=True)
class FeedForwardMotion:
    """q, qd, qdd of all joints on a reference trajectory, and the forces A qdd + H less those of springs."""

    q: Numbers
    qd: Numbers
    qdd: Numbers
    forces: Numbers


def feed_forward_motion(point: StateReference, traced: TracedModel) -> FeedForwardMotion:
    """Return the motion of a feed-forward, differentiated by time, and its forces."""
    symbols: dict[str, Any] = dict(point.names)
    for argument in traced.program.inputs:
        rate = min(len(argument.name), HIGHEST_DERIVATIVE)  # of the highest derivative, any
        rates = point.numbers(MOTION[rate].name)
        symbols |= zip(argument.symbols, map(Dual, point.numbers(argument.name), rates), strict=True)
    outputs = {o.name: o.entries for o in traced.program.outputs}
    value = evaluate((*outputs["q"], *outputs["qd"]), symbols, differentiating(point.arithmetic))
    q, qd = ([value(x) for x in outputs[name]] for name in ("q", "qd"))
    place, velocity, acceleration = [_value(x) for x in q], [_slope(x) for x in q], [_slope(x) for x in qd]
    A = point.run(point.reference.inertia, {"q": place})["A"]
    H = point.run(point.reference.bias, {"q": place, "qd": velocity})["H"]
    n = len(place)
    rows = [A[row * n : (row + 1) * n] for row in range(n)]
    springs = _springs(point, place, velocity)
    forces = [dot(row, acceleration) + h - x for row, h, x in zip(rows, H, springs, strict=True)]
    return FeedForwardMotion(place, velocity, acceleration, forces)


def _springs(point: StateReference, q: Numbers, qd: Numbers) -> Numbers:
    """Return the forces of springs and dampers on the independent variables, with those of changing stiffness."""
    bound = _bound(point)
    passive, friction = bound.passive_forces(), bound.friction_forces()
    exerted = [passive[j] + friction[j] for j in bound.machine.independent]
    entries = bound.arguments()
    symbols = point.names | dict(zip((*entries["q"], *entries["qd"]), (*q, *qd), strict=True))
    return list(map(evaluate(exerted, symbols, point.arithmetic), exerted))


def torques(point: StateReference, traced: TracedModel) -> dict[str, Numbers]:
    """Return reference results of a feed-forward: q, its derivative, and torques by the equations of motion."""
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    by_name = {"tau": motion.forces, "q": motion.q, "qd": motion.qd}
    by_joint = {name: dict(zip(machine.independent, x, strict=True)) for name, x in by_name.items()}
    return {name: [by_joint[name][j] for j in rows] for name, rows in traced.rows.items()}


def residual(point: StateReference, traced: TracedModel) -> float:
    """Return the largest relative residual: of forces on elastic joints, and of load positions against the reference y.

    It is 0 where no deflection balances the load of a spring whose stiffness changes with positions: such a state is
    not judged.
    """
    try:
        return _residual(point, traced)
    except ZeroDivisionError:
        return 0.0


def _residual(point: StateReference, traced: TracedModel) -> float:
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    pairs = zip(machine.independent_joints, motion.forces, strict=True)
    unbalanced = [abs(x) for joint, x in pairs if joint.kind is Kind.ELASTIC]
    q = dict(zip(machine.independent, motion.q, strict=True))
    bound = _bound(point)
    positions = load_positions(bound, chains(bound))
    symbols = point.names | machine.by_variable(q)
    value = evaluate(positions.values(), symbols, point.arithmetic)
    sums = [value(positions[j]) for j in machine.motors]
    scale = max(map(abs, motion.forces), default=0) or 1
    return max(float(max(unbalanced, default=0) / scale), distance(sums, point.numbers("y")))


def _bound(point: StateReference) -> Bound:
    coupled = point.reference.coupled
    return coupled.bound if coupled else Bound(point.reference.machine)


def _value(x: Any) -> Any:
    return x.value if x.__class__ is Dual else x


def _slope(x: Any) -> Any:
    return x.tangent if x.__class__ is Dual else x * 0
