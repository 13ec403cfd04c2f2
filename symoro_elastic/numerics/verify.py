"""Generated code against a 50-digit reference, at moderate and at extreme states.

The error of a result is its largest difference over its largest reference entry. At moderate
states it may be 1e-12. At extreme states it may also be 64 times the change that moving the
inputs by one ulp makes, since no code in double precision can do much better than that.
"""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.codegen.compile import CompilerMissing, compile_package
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets import render_c, render_numpy
from symoro_elastic.generate import package
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import folded, restricted
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.catalogue import TracedModel, trace_scene
from symoro_elastic.numerics.candidates import Candidate, c_code, equations_on_floats, import_package, numpy_code
from symoro_elastic.numerics.reference import Numbers, Point, Reference, Singular, distance
from symoro_elastic.numerics.states import States, extreme_states, moderate_states
from symoro_elastic.numerics.values import parameter_values

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

BOUND = 1e-12
ULPS = 64
MOVES = 3
AGREEMENT = 1e-20
MOST_SOLVED = 40
FEW_STATES = 10_000


@dataclass(frozen=True)
class Worst:
    """Worst relative errors of one implementation of a model; `share` is the worst error over its bound."""

    moderate: float = 0.0
    extreme: float = 0.0
    share: float = 0.0

    @property
    def error(self) -> float:
        """The worst of all."""
        return max(self.moderate, self.extreme)

    @property
    def ok(self) -> bool:
        """Whether every error is within its bound."""
        return self.share <= 1.0

    def __or__(self, other: Worst) -> Worst:
        return Worst(
            max(self.moderate, other.moderate), max(self.extreme, other.extreme), max(self.share, other.share)
        )


@dataclass(frozen=True)
class ModelVerification:
    """One model: worst errors of the generated code and of the equations on floats.

    `c` is None without a compiler. `bound` is the largest error allowed at an extreme state;
    `moderate` and `extreme` count the states compared, `unjudged` names the others and why.
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
        """Whether states were compared and all errors are within their bounds."""
        implementations = (self.numpy, self.equations, *((self.c,) if self.c else ()))
        return self.moderate > 0 and all(worst.ok for worst in implementations)


@dataclass(frozen=True)
class Verification:
    """What was found; `missing` says what kept the C code from being compared, `disagreement` how

    far A and H are from Newton and Euler's recursion in 50 digits.
    """

    models: tuple[ModelVerification, ...]
    states: int
    disagreement: float
    missing: str = ""

    @property
    def ok(self) -> bool:
        """Whether everything that was compared is within its bound."""
        return self.disagreement <= AGREEMENT and all(model.ok for model in self.models)


@dataclass
class _Judged:
    """Reference of one model: entries as sums of two doubles, bound and reason against, by state."""

    high: dict[str, list[list[float]]]
    low: dict[str, list[list[float]]]
    bounds: dict[str, list[float]]
    unjudged: dict[int, str] = field(default_factory=dict)


def verify(
    machine: Machine,
    scene: Scene | None = None,
    *,
    states: tuple[int, int] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Verification:
    """Compare generated C, generated numpy and the equations on floats with a 50-digit reference.

    `machine` is the whole machine, `scene` what is asked of it (its models; the default ones
    where it names none), `states` how many moderate and extreme states. Parameters that have no
    value get a plausible one. `progress(done, total)` is called after each state.
    Raises `NoValues`, `SingularPivot`, `CompilationFailed`.
    """
    scene = scene or Scene()
    kept, constants = restricted(machine, scene), folded(machine, scene)
    traced = trace_scene(machine, scene)
    described = package(kept, traced, constants)
    values = parameter_values(kept, seed)
    reference = Reference(kept, values, constants, solved=len(kept.moving) <= MOST_SOLVED)
    moderate, extreme = states or _how_many(traced)
    stacked = moderate_states(kept, moderate, seed, values) + extreme_states(kept, extreme, seed, values)
    judged = _reference(reference, traced, stacked, moderate, seed, progress)
    p = np.array([values[parameter.name] for parameter in described.parameters], dtype=float)
    with tempfile.TemporaryDirectory() as folder:
        candidates, missing = _candidates(described, p, values, Path(folder))
        models = [_compared(model, stacked, moderate, judged[model.model.name], candidates) for model in traced]
    disagreement = _disagreement(reference, traced, stacked)
    return Verification(tuple(models), len(stacked), disagreement, missing)


def _how_many(traced: Sequence[TracedModel]) -> tuple[int, int]:
    """Fewer states for large models."""
    statements = sum(len(t.program.once) + len(t.program.statements) for t in traced)
    return (32, 32) if statements < FEW_STATES else (8, 16)


def _candidates(
    described: Package, p: Array, values: dict[str, float], folder: Path
) -> tuple[dict[str, list[Candidate]], str]:
    """The implementations by name, and what is missing for C."""
    module = import_package(render_numpy(described), folder / "numpy")
    found = {
        "numpy": [numpy_code(module, p, stacked) for stacked in (False, True)],
        "equations": [equations_on_floats(values)],
    }
    try:
        compiled = compile_package(described, folder / "c", render_c(described))
    except CompilerMissing as error:
        return found, str(error)
    return found | {"c": [c_code(compiled, p)]}, ""


def _reference(
    reference: Reference,
    traced: Sequence[TracedModel],
    states: States,
    moderate: int,
    seed: int,
    progress: Progress | None,
) -> dict[str, _Judged]:
    names = {model.model.name: tuple(model.rows) for model in traced}
    found = {model: _Judged(*({name: [] for name in results} for _ in range(3))) for model, results in names.items()}
    for state in range(len(states)):
        source = random.Random(f"{seed} {state}")
        point = reference.at(states.at(state))
        moved = [reference.at(states.at(state), source) for _ in range(MOVES)] if state >= moderate else []
        for model in traced:
            _judge(found[model.model.name], model, state, point, moved)
        if progress:
            progress(state + 1, len(states))
    return found


def _judge(judged: _Judged, traced: TracedModel, state: int, point: Point, moved: Sequence[Point]) -> None:
    """Add the reference of a model at a state, and its bound."""
    try:
        wanted = point.model(traced)
        changed = [at.model(traced) for at in moved]
    except (Singular, ZeroDivisionError) as error:
        judged.unjudged[state] = str(error) or "division by zero"
        wanted, changed = {output.name: [math.nan] * len(output.entries) for output in traced.program.outputs}, []
    for name, entries in wanted.items():
        high = [float(x) for x in entries]
        effect = max((distance(other[name], entries) for other in changed), default=0.0)
        if not all(map(math.isfinite, high)):
            judged.unjudged.setdefault(state, f"{name} is not finite")
        if ULPS * effect >= 1:
            judged.unjudged.setdefault(state, f"one ulp of the inputs changes {name} altogether")
        judged.high[name].append(high)
        judged.low[name].append([float(x - h) for x, h in zip(entries, high, strict=True)])
        judged.bounds[name].append(max(BOUND, ULPS * effect))


def _compared(
    traced: TracedModel, states: States, moderate: int, judged: _Judged, candidates: dict[str, list[Candidate]]
) -> ModelVerification:
    kept = np.array([state not in judged.unjudged for state in range(len(states))])
    worst = {
        name: _worst([candidate(traced, states) for candidate in runs], judged, kept, moderate)
        for name, runs in candidates.items()
    }
    bounds = [np.array(bounds)[kept] for bounds in judged.bounds.values()]
    return ModelVerification(
        traced.model.name,
        worst["numpy"],
        worst.get("c"),
        worst["equations"],
        int(kept[:moderate].sum()),
        int(kept[moderate:].sum()),
        max((float(b.max(initial=BOUND)) for b in bounds), default=BOUND),
        tuple(f"state {k + 1} ({states.titles[k]}): {why}" for k, why in sorted(judged.unjudged.items())),
    )


def _worst(runs: Sequence[dict[str, Array]], judged: _Judged, kept: NDArray[np.bool_], moderate: int) -> Worst:
    worst = Worst()
    for results in runs:
        for name, array in results.items():
            high, low = np.array(judged.high[name]), np.array(judged.low[name])
            errors = _errors(array.reshape(high.shape), high, low)
            share = errors / np.array(judged.bounds[name])
            ordinary, special = errors[:moderate][kept[:moderate]], errors[moderate:][kept[moderate:]]
            worst |= Worst(
                float(ordinary.max(initial=0.0)), float(special.max(initial=0.0)), float(share[kept].max(initial=0.0))
            )
    return worst


def _errors(found: Array, high: Array, low: Array) -> Array:
    """Largest difference over largest entry, by state; infinite where a result is not a number."""
    with np.errstate(all="ignore"):
        difference = np.abs((found - high) - low).max(axis=1, initial=0.0)
        scale = np.abs(high).max(axis=1, initial=0.0)
        errors = np.where(difference == 0, 0.0, difference / scale)
    return np.where(np.isnan(errors), np.inf, errors)


def _disagreement(reference: Reference, traced: Sequence[TracedModel], states: States) -> float:
    """A and H against Newton and Euler; where the models were not solved for, one of them that is."""
    found = reference.disagreement(states.at(0))
    if reference.solved:
        return found
    solving = Reference(reference.machine, reference.values, (), solved=True)
    for model in traced:
        point, other = reference.at(states.at(0)), solving.at(states.at(0))
        wanted = other.model(model)
        found = max(found, *(distance(x, wanted[name]) for name, x in point.model(model).items()))
    return found
