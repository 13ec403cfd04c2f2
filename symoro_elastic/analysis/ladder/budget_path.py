"""The path of a budget: every step omits what saves the most operations for the error that it adds.

Candidates are the next springs in the order of the ladder, one or several at once; numbers of bodies and rotors; static
springs that are held where they are neutral instead of where the motion starts. Numbers stay where drives feed the
inverse model forward, which has them, too. What a number saves is estimated by
uses (`savings`), then counted in the programs without it. Errors are those of the linear model along the motions, and
add up by the triangle inequality. The path begins at the shares of the ladder, a quarter of the tolerances for time
steps; the slack at its end is spent on longer steps.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import takewhile
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.analysis.ladder.predicted_rungs import Prediction, held_springs, zeros_of
from symoro_elastic.analysis.ladder.rung import PREDICTED_FRACTION, Expense, PathStep, Rung, Steps
from symoro_elastic.analysis.simulation.compiled_steps import ways_of
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative
from symoro_elastic.analysis.simulation.simulate import SHARE, StepCost
from symoro_elastic.codegen.integration.tableaus import METHODS, Method
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.columns import with_cells
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Machine, Parameter
from symoro_elastic.machine.reduced import with_coupling
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.zeroed import couplings_of, name_of, numbers_of
from symoro_elastic.models.steps.implicit_steps import Motors
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.within.budget import ErrorBudget, Item, by_gain, spend
from symoro_elastic.numerics.within.liveness import Liveness
from symoro_elastic.numerics.within.tape import Change, Kind, Tape

NEARLY = 0.25
"""Of the best gain: numbers that gain as much are left out at once."""
ONE = Formula.parse("1")
Errors = Mapping[str, float]
LEAST_INERTIA = 0.5
"""Of the inertia that a motion sees along any combination of joints: how much stays of it."""


class Candidate(NamedTuple):
    """Candidate for omission: its parts, the error that it adds by output, and the estimated operations saved."""

    expense: Expense
    names: tuple[str, ...]
    added: Errors
    saved: float


class BudgetPath:
    """Search for the parts to omit within the tolerances, over all motions; `rungs` is the list of models."""

    def __init__(
        self, prediction: Prediction, rungs: Sequence[Rung], spent: Collection[Expense] = frozenset(Expense)
    ) -> None:
        """Prepare the search; `spent` are the kinds of simplification that may use the tolerances."""
        self._spent = spent
        self.prediction, self.tolerance = prediction, prediction.tolerance
        self._budget = ErrorBudget(self.tolerance, PREDICTED_FRACTION)
        self._rungs = [rung for rung in rungs if not rung.locked]
        self._numbers = [LeftOutNumbers(path) for path in prediction.paths]
        models = [[path.following(rung.left_out) for path in prediction.paths] for rung in self._rungs]
        self._of_springs = [[Deviations(path).with_springs([x])[1][:, 0] for path, x in pairs] for pairs in models]
        """Outputs (N, names), motion by motion, where springs and parts of drives follow."""
        self._steps = {k: rung.chosen for k, rung in enumerate(self._rungs) if rung.chosen}
        self._changes: dict[int, dict[str, list[Array]]] = {}
        self._savings: dict[tuple[int, str], Savings] = {}
        self._rejected: set[tuple[tuple[str, ...], tuple[str, ...]]] = set()
        """Springs left out, and items that do not fit or save with them: later the slack is smaller."""
        self._ranked: list[Item[Candidate]] = []

    def run(self, progress: Progress = no_progress) -> tuple[PathStep, ...]:
        """Return the steps of the search, from the full machine until no candidate that saves operations fits."""
        steps = self._rungs[0].chosen or self.prediction.steps_of(self._rungs[0])
        none = dict.fromkeys(self.tolerance, 0.0)
        first = replace(self._rungs[0], predicted=none, chosen=steps)
        path = [PathStep(Expense.WHOLE, (), dict(steps.predicted), dict(steps.predicted), first)]
        with suppress(KeyboardInterrupt):  # the path so far is simulated, too
            for step in spend(path[0], self._items, self._accept):
                path.append(step)
                progress(round(100 * self._budget.used_fraction(step.total)), 100)
        last = self._with_longer_steps(path[-1]) if Expense.STEPS in self._spent else None
        return (*path, last) if last else tuple(path)

    def _items(self, now: PathStep) -> list[Item[Candidate]]:
        """Return the candidates after a step that fit and are not rejected."""
        slack = self._budget.slack(now.rung.predicted)
        candidates = [x for x in self._candidates(now) if x.expense in self._spent and _fits(x.added, slack)]
        items = [Item(x, x.saved, relative(x.added, self.tolerance)) for x in candidates]
        self._ranked = by_gain(x for x in items if self._key(now, x.what) not in self._rejected)
        return self._ranked

    def _accept(self, now: PathStep, candidate: Candidate) -> PathStep | None:
        """Return the next step, with the candidate and numbers of similar gain omitted; None if it saves nothing."""
        for choice in (*self._together(now, candidate), candidate):
            following = self._without(now, choice)
            if following and following.steps.cost < now.steps.cost and self._budget.fits(following.total):
                return following
            self._rejected.add(self._key(now, choice))
        return None

    def _key(self, now: PathStep, candidate: Candidate) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return now.rung.left_out, candidate.names

    def _together(self, now: PathStep, candidate: Candidate) -> list[Candidate]:
        """Return one candidate that omits a number and others of nearly its gain together, if they fit; else none."""
        if candidate.expense is not Expense.NUMBERS:
            return []
        changes, slack = self._changes_at(self._place(now.rung)), self._budget.slack(now.rung.predicted)
        first = next(k for k, item in enumerate(self._ranked) if item.what is candidate)
        least = NEARLY * self._ranked[first].gain
        similar = takewhile(lambda x: x.what.expense is Expense.NUMBERS and x.gain >= least, self._ranked[first:])
        group = [item.what for item in similar]
        while len(group) > 1:
            names = tuple(name for x in group for name in x.names)
            added = self._largest([changes[name] for name in names])
            if _fits(added, slack):
                return [Candidate(Expense.NUMBERS, names, added, sum(x.saved for x in group))]
            group = group[: len(group) // 2]
        return []

    def _candidates(self, now: PathStep) -> Iterator[Candidate]:
        rung = now.rung
        k = self._place(rung)
        yield from self._springs(now, k)
        if not now.steps.method or any(drive.torque_forward for drive in self.prediction.references[0].drives):
            return
        changes, savings = self._changes_at(k), self._savings_at(k, now.steps.method)
        omitted = (*rung.zero, *rung.neutral)
        before = savings.of(omitted)
        static = tuple(name for name in changes if name in rung.left_out and name not in rung.neutral)
        groups: list[tuple[tuple[str, ...], Expense]]
        groups = [((name,), Expense.NUMBERS) for name in changes if name not in rung.left_out and name not in omitted]
        groups += [(names, Expense.NEUTRAL) for names in (*((name,) for name in static), *[static] * (len(static) > 1))]
        for names, spent in groups:
            saved = (savings.of((*omitted, *names)) - before) * now.steps.steps
            if saved > 0:
                yield Candidate(spent, names, self._largest([changes[name] for name in names]), saved)

    def _springs(self, now: PathStep, k: int) -> Iterator[Candidate]:
        """Yield candidates that make the next one, two, ... springs of the ladder static."""
        for following in range(k + 1, len(self._rungs)):
            pairs = zip(self._of_springs[k], self._of_springs[following], strict=True)
            added = self._largest([[y - x for x, y in pairs]])
            steps = self._steps_at(following, self._budget.slack(now.rung.predicted), added)
            if steps is not None:
                share = steps.cost / self._steps.get(k, now.steps).cost
                names = tuple(name for name in self._rungs[following].left_out if name not in now.rung.left_out)
                yield Candidate(Expense.SPRINGS, names, added, now.steps.cost * (1 - share))

    def _without(self, now: PathStep, candidate: Candidate) -> PathStep | None:
        """Return the next step, with the candidate omitted and its operations; None if the inertia gets too small."""
        rung, names = now.rung, candidate.names
        if candidate.expense is Expense.SPRINGS:
            left_out = tuple(sorted((*rung.left_out, *names), key=self._rungs[-1].left_out.index))
            rung = replace(rung, left_out=left_out)
            steps = self._steps_at(self._place(rung), self._budget.slack(now.rung.predicted), candidate.added)
            assert steps is not None
        else:
            zero, neutral = (names, ()) if candidate.expense is Expense.NUMBERS else ((), names)
            rung, steps = replace(rung, zero=(*rung.zero, *zero), neutral=(*rung.neutral, *neutral)), now.steps
        if rung.zero and not all(x.has_inertia(rung.zero, rung.left_out) for x in self._numbers):
            return None
        steps = replace(steps, operations=self.prediction.operations_of(rung, steps.method))
        predicted = _sum(now.rung.predicted, candidate.added)
        rung = replace(rung, predicted=predicted, chosen=steps)
        total = _sum(predicted, steps.predicted)
        total = {name: max(x, now.total[name]) for name, x in total.items()}
        return PathStep(candidate.expense, names, candidate.added, total, rung)

    def _with_longer_steps(self, now: PathStep) -> PathStep | None:
        """Return the same model with the cheapest time steps for the remaining tolerance; None without saving."""
        if not now.steps.method:
            return None
        slack = self._budget.slack(now.rung.predicted)
        steps = self.prediction.steps_of(now.rung, tolerance=slack, share=1.0)
        if steps.cost >= now.steps.cost or not _fits(steps.predicted, slack):
            return None
        total = {name: max(x, now.total[name]) for name, x in _sum(now.rung.predicted, steps.predicted).items()}
        added = {name: x - now.total[name] for name, x in total.items()}
        return PathStep(Expense.STEPS, (), added, total, replace(now.rung, chosen=steps))

    def _steps_at(self, k: int, slack: Errors, added: Errors) -> Steps | None:
        """Return the time steps of rung k that fit into the slack after its added errors; None if none do."""
        slack_of_steps = {name: x - added[name] for name, x in slack.items()}
        if min(slack_of_steps.values()) <= 0 or not self.prediction.holds(self._rungs[k]):
            return None
        if k not in self._steps or not _fits(self._steps[k].predicted, slack_of_steps):
            limits = {name: min(x, SHARE * self.tolerance[name]) for name, x in slack_of_steps.items()}
            self._steps[k] = self.prediction.steps_of(self._rungs[k], tolerance=limits, share=1.0)
        return self._steps[k] if _fits(self._steps[k].predicted, slack_of_steps) else None

    def _place(self, rung: Rung) -> int:
        return next(k for k, other in enumerate(self._rungs) if {*other.left_out} == {*rung.left_out})

    def _changes_at(self, k: int) -> dict[str, list[Array]]:
        """Return, by name and motion, the output changes (N, names) of a number omitted or a static spring shifted."""
        if k not in self._changes:
            left_out = self._rungs[k].left_out
            names = (*self._numbers[0].numbers, *(x for x in self._numbers[0].neutral if x in left_out))
            changes = [numbers.changes([(name,) for name in names], left_out) for numbers in self._numbers]
            self._changes[k] = {name: [x[:, row] for x in changes] for row, name in enumerate(names)}
        return self._changes[k]

    def _savings_at(self, k: int, method: str) -> Savings:
        """Return the operations saved per step by numbers set to zero and springs fixed at neutral, for one rung."""
        if (k, method) not in self._savings:
            prediction, rung = self.prediction, self._rungs[k]
            machine, symbols = with_symbols(prediction.references[0].loaded)
            positions = held_springs(prediction.machine, prediction.references[0], rung)
            shifted = [name for name in rung.left_out if name in self._numbers[0].neutral]
            own = {name: f"held{j}" for j, name in enumerate(shifted)}
            new = tuple(Parameter(own[name], positions[name]) for name in shifted)
            machine = replace(machine, parameters=(*machine.parameters, *new))
            static = {name: Formula.parse(own[name]) if name in own else x for name, x in positions.items()}
            symbols = symbols | own
            restricted = restrict(machine, Scene(static=dict(static), zero=zeros_of(replace(rung, zero=()), positions)))
            self._savings[k, method] = Savings(restricted, ways_of(prediction.references[0]), symbols, METHODS[method])
        return self._savings[k, method]

    def _largest(self, changes: Sequence[Sequence[Array]]) -> dict[str, float]:
        """Return the largest absolute sum of changes by output, over all motions."""
        by_motion = [np.abs(sum(parts)).max(axis=0) for parts in zip(*changes, strict=True)]
        return dict(zip(self.tolerance, np.max(by_motion, axis=0).tolist(), strict=True))


def _fits(errors: Errors, slack: Errors) -> bool:
    return all(errors[name] <= x for name, x in slack.items())


def _sum(first: Errors, second: Errors) -> dict[str, float]:
    return {name: x + second[name] for name, x in first.items()}


class Savings:
    """Operations that a time step saves if parameters of a machine are zero."""

    def __init__(self, machine: Machine, motors: Motors, symbols: Mapping[str, str], method: Method) -> None:
        """Trace a step's programs; `symbols` maps names of omitted parts to parameters, all others are constants."""
        constants = [p.name for p in machine.parameters if p.value is not None and p.name not in symbols.values()]
        self._programs = [(times, Tape(x)) for times, x in StepCost(machine, motors, constants).programs(method)]
        self._symbols = symbols

    def of(self, names: Collection[str]) -> int:
        """Return the operations that a step saves without these parts."""
        return sum(times * (Liveness(tape).cost - self._without(tape, names)) for times, tape in self._programs)

    def _without(self, tape: Tape, names: Collection[str]) -> int:
        live = Liveness(tape)
        for name in names:
            place = tape.symbols.get(self._symbols.get(name, ""))
            if place is not None and live.is_possible(change := Change(Kind.FREEZE, place, constant=0.0)):
                live.apply(change)
        return live.cost


class LeftOutNumbers:
    """Changes of outputs along one motion if numbers of bodies are zero or static springs are fixed at neutral."""

    def __init__(self, path: LinearPath) -> None:
        self.path = path
        machine = path.reference.machine
        for j in machine.loaded:
            what = "a budget does not know how numbers change the torque that passes: leave load out, or the budget"
            raise machine.error(f"friction, {machine.joint(j).name}, load", what)
        named, self._symbols = with_symbols(machine)
        self.numbers = tuple(self._symbols)
        self._motion = EquationsOfMotion(named)
        self._joints = tuple(self._motion.names)
        neutral = [joint.spring.neutral.value(self._motion.parameters) for joint in machine.independent_joints]
        shifts = np.array(neutral) - path.reference.start.q
        self.neutral = {path.joints[k]: float(shifts[k]) for k in path.springs if shifts[k]}
        """By spring: from where the motion starts to its neutral position, rad or m."""

    def changes(self, sets: Sequence[Collection[str]], left_out: Collection[str]) -> Array:
        """Return output changes (N, sets, outputs) by the names in each set, springs and drive parts static.

        A name is that of a number, which is zero, or of a static spring, which is held at its neutral position.
        """
        path, springs = self.path.following(left_out)
        motion, n = path.driven_by(path.R[:, None], springs), len(self._joints)
        small = (motion.d, motion.dd, motion.ddd)
        states = [x[:, :n] + d[:, 0, :n] for x, d in zip(path.states(path.t), small, strict=True)]
        exact = self._forces(states, ())
        forces = np.stack([exact - self._forces(states, names) for names in sets], axis=1)
        more = len(path.joints) - n
        return Deviations(path).under(np.pad(forces, ((0, 0), (0, 0), (0, more))), springs)

    def has_inertia(self, names: Collection[str], left_out: Collection[str]) -> bool:
        """Whether the inertia matrix without these numbers stays large enough along the motion."""
        rows = [k for k, name in enumerate(self._joints) if name not in left_out]
        full, reduced = (self._inertia(x)[:, rows][:, :, rows] for x in ((), names))
        return bool((np.linalg.eigvalsh(reduced - LEAST_INERTIA * full) >= 0).all())

    def _forces(self, states: Sequence[Array], names: Collection[str]) -> Array:
        """Return ID (N, n) with numbers zero, minus the forces of springs that are fixed at their neutral positions."""
        q, v, a = states
        shift = np.array([self.neutral[name] if name in names else 0.0 for name in self._joints])
        rows = self._values(self._motion.residual, (q + shift, v, a), names)
        return np.asarray(rows - self.path.stiffness[: len(shift)] * shift)

    def _inertia(self, names: Collection[str]) -> Array:
        """Return M (N, n, n) along the reference."""
        n = len(self._joints)
        (M,) = (output.entries for output in self._motion.linear_model.outputs if output.name == "M")
        states = [x[:, :n] for x in self.path.states(self.path.t)]
        return self._values(M, states, names).reshape(-1, n, n)

    def _values(self, roots: Sequence[Scalar], states: Sequence[Array], names: Collection[str]) -> Array:
        """Return values of expressions (N, roots) at states, with the named numbers zero."""
        bound, zero = self._motion.bound, {self._symbols[name] for name in names if name in self._symbols}
        symbols: dict[str, Any] = {name: 0.0 if name in zero else x for name, x in self._motion.parameters.items()}
        for by_joint, block in zip((bound.q, bound.qd, bound.qdd), states, strict=True):
            symbols |= {str(x.operands[0]): row for x, row in zip(by_joint.values(), block.T, strict=True)}
        return values_along(roots, symbols, len(self.path.t)).T


def with_symbols(machine: Machine) -> tuple[Machine, dict[str, str]]:
    """Return the machine with numbers of bodies and rotors as parameters, and the parameters by number's name.

    The coupling of a rotor is a factor 1 of the inertia that turns with its carrier; the rest turns with the joint.
    """
    couplings = couplings_of(machine)
    numbers = numbers_of(machine) | dict.fromkeys(couplings, ONE)
    used = {parameter.name for parameter in machine.parameters}
    stem = next(x for x in ("number", *(f"number{k}_" for k in range(len(used) + 1))) if f"{x}1" not in used)
    symbols = {name: f"{stem}{k}" for k, name in enumerate(numbers, 1)}
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    new = tuple(Parameter(symbols[name], Formula.parse(x.value(values))) for name, x in numbers.items())
    cells = {name: Formula.parse(symbol) for name, symbol in symbols.items()}
    factors = {joint: symbols[name] for name, joint in couplings.items()}

    def with_names(joint: Joint) -> Joint:
        named = with_cells(joint, lambda cell, x: cells.get(name_of(joint, cell), x))
        return with_coupling(named, factors[joint.name]) if joint.name in factors else named

    joints = tuple(map(with_names, machine.joints))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *new)), symbols
