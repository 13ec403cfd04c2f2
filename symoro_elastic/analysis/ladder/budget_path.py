"""The path of a budget: at each step that is left out which saves the most operations for the error that it adds.

Candidates are the next springs in the order of the ladder, one or several at once; numbers of bodies and rotors; static
springs that are held where they are neutral instead of where the motion starts. Numbers stay where drives feed the
inverse model forward, which has them, too. What a number saves is estimated by
uses (`savings`), then counted in the programs without it. Errors are those of the linear model along the motions, and
add up by the triangle inequality. The shares of the ladder, a quarter of the tolerances for time steps, are where the
path begins; what is left at its end is spent on longer steps.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from symoro_elastic.analysis.ladder.budget import PathStep, Spent
from symoro_elastic.analysis.ladder.numbers import LeftOutNumbers, with_symbols
from symoro_elastic.analysis.ladder.predicted_rungs import Prediction, held_springs, zeros_of
from symoro_elastic.analysis.ladder.rung import Rung, Steps
from symoro_elastic.analysis.ladder.savings import Savings
from symoro_elastic.analysis.simulation.compiled_steps import ways_of
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative
from symoro_elastic.analysis.simulation.simulate import SHARE
from symoro_elastic.codegen.integration.methods import METHODS
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Parameter
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene

FILLED = 0.95
"""Of the tolerances that the path spends; the rest is for what the linear model does not tell."""
FREE = 1e-6
"""Of the tolerances: what adds less is ranked by what it saves alone."""
NEARLY = 0.25
"""Of the best gain: numbers that gain as much are left out at once."""
Errors = Mapping[str, float]


class Candidate(NamedTuple):
    """What may be left out next: what it adds by output, and about how many operations it saves over the motion."""

    spent: Spent
    names: tuple[str, ...]
    added: Errors
    saved: float


class BudgetPath:
    """The search along the motions of a prediction; `rungs` are those of its ladder."""

    def __init__(self, prediction: Prediction, rungs: Sequence[Rung]) -> None:
        self.prediction, self.tolerance = prediction, prediction.tolerance
        self._rungs = [rung for rung in rungs if not rung.locked]
        self._numbers = [LeftOutNumbers(path) for path in prediction.paths]
        self._of_springs = [self._outputs(rung.left_out) for rung in self._rungs]
        self._steps: dict[int, Steps] = {}
        self._changes: dict[int, dict[str, list[Array]]] = {}
        self._savings: dict[tuple[int, str], Savings] = {}
        self._refused: set[tuple[tuple[str, ...], tuple[str, ...]]] = set()
        """Springs, and what does not fit or save beside them: there will be less room later."""

    def run(self, progress: Progress = no_progress) -> tuple[PathStep, ...]:
        """Return the path, from the whole machine to where nothing that saves operations fits."""
        steps = self.prediction.steps_of(self._rungs[0])
        none = dict.fromkeys(self.tolerance, 0.0)
        path = [PathStep(Spent.WHOLE, (), dict(steps.predicted), dict(steps.predicted), self._rungs[0])]
        path = [replace(path[0], rung=replace(self._rungs[0], predicted=none, chosen=steps))]
        while following := self._next(path[-1]):
            path.append(following)
            progress(round(100 * relative(path[-1].total, self.tolerance)), 100)
        last = self._with_longer_steps(path[-1])
        return (*path, last) if last else tuple(path)

    def _next(self, now: PathStep) -> PathStep | None:
        """Return the step that saves most for what it adds; None where none fits."""
        room = self._room(now.rung.predicted)
        by_gain = sorted(self._candidates(now), key=self._gain, reverse=True)
        by_gain = [one for one in by_gain if _fits(one.added, room) and self._key(now, one) not in self._refused]
        together = self._together(by_gain, self._place(now.rung), room)
        for one in (*together, *by_gain):
            found = self._taken(now, one, room)
            if found and found.steps.cost < now.steps.cost and _fits(found.total, self._room({})):
                return found
            self._refused.add(self._key(now, one))
        return None

    def _gain(self, one: Candidate) -> float:
        """Return the operations that a candidate saves for the part of the tolerances that it takes."""
        return one.saved / max(relative(one.added, self.tolerance), FREE)

    def _key(self, now: PathStep, one: Candidate) -> tuple[tuple[str, ...], tuple[str, ...]]:
        return now.rung.left_out, one.names

    def _together(self, by_gain: Sequence[Candidate], k: int, room: Errors) -> list[Candidate]:
        """Return the first numbers as one candidate, while they gain nearly as much as the first one and fit."""
        least, changes = NEARLY * self._gain(by_gain[0]) if by_gain else 0.0, self._changes_at(k) if by_gain else {}
        first = list(takewhile(lambda x: x.spent is Spent.NUMBERS and self._gain(x) >= least, by_gain))
        while len(first) > 1:
            names = tuple(name for one in first for name in one.names)
            added = self._largest([changes[name] for name in names])
            if _fits(added, room):
                return [Candidate(Spent.NUMBERS, names, added, sum(one.saved for one in first))]
            first = first[: len(first) // 2]
        return []

    def _room(self, taken: Errors) -> dict[str, float]:
        """Return what is left of the tolerances."""
        return {name: FILLED * limit - taken.get(name, 0.0) for name, limit in self.tolerance.items()}

    def _candidates(self, now: PathStep) -> Iterator[Candidate]:
        rung = now.rung
        k = self._place(rung)
        yield from self._springs(now, k)
        if not now.steps.method or any(one.torque_forward for one in self.prediction.references[0].drives):
            return
        changes, savings = self._changes_at(k), self._savings_at(k, now.steps.method)
        taken = (*rung.zero, *rung.neutral)
        before = savings.of(taken)
        held = tuple(name for name in changes if name in rung.left_out and name not in rung.neutral)
        groups: list[tuple[tuple[str, ...], Spent]]
        groups = [((name,), Spent.NUMBERS) for name in changes if name not in rung.left_out and name not in taken]
        groups += [((name,), Spent.NEUTRAL) for name in held] + ([(held, Spent.NEUTRAL)] if len(held) > 1 else [])
        for names, spent in groups:
            saved = (savings.of((*taken, *names)) - before) * now.steps.steps
            if saved > 0:
                yield Candidate(spent, names, self._largest([changes[name] for name in names]), saved)

    def _springs(self, now: PathStep, k: int) -> Iterator[Candidate]:
        """The next springs of the ladder, by how many of them."""
        for following in range(k + 1, len(self._rungs)):
            added = self._largest(
                [[y - x for x, y in zip(self._of_springs[k], self._of_springs[following], strict=True)]]
            )
            steps = self._steps_at(following, self._room(now.rung.predicted), added)
            if steps is not None:
                share = steps.cost / self._steps_at_least(k, now).cost
                names = tuple(name for name in self._rungs[following].left_out if name not in now.rung.left_out)
                yield Candidate(Spent.SPRINGS, names, added, now.steps.cost * (1 - share))

    def _taken(self, now: PathStep, one: Candidate, room: Errors) -> PathStep | None:
        """Return the path's next step with its operations counted; None where too little inertia would be left."""
        rung, names = now.rung, one.names
        if one.spent is Spent.SPRINGS:
            left_out = tuple(sorted((*rung.left_out, *names), key=self._rungs[-1].left_out.index))
            rung = replace(rung, left_out=left_out)
            steps = self._steps_at(self._place(rung), room, one.added)
            assert steps is not None
        else:
            zero, neutral = (names, ()) if one.spent is Spent.NUMBERS else ((), names)
            rung, steps = replace(rung, zero=(*rung.zero, *zero), neutral=(*rung.neutral, *neutral)), now.steps
        if not all(self._has_inertia(numbers, rung) for numbers in self._numbers):
            return None
        steps = replace(steps, operations=self.prediction.operations_of(rung, steps.method))
        predicted = _sum(now.rung.predicted, one.added)
        rung = replace(rung, predicted=predicted, chosen=steps)
        total = _sum(predicted, steps.predicted)
        total = {name: max(x, now.total[name]) for name, x in total.items()}
        return PathStep(one.spent, names, one.added, total, rung)

    def _with_longer_steps(self, now: PathStep) -> PathStep | None:
        """Return the same model with the cheapest steps for all that is left of the tolerances; None without gain."""
        if not now.steps.method:
            return None
        room = self._room(now.rung.predicted)
        found = self.prediction.steps_of(now.rung, tolerance=room, share=1.0)
        if found.cost >= now.steps.cost or not _fits(found.predicted, room):
            return None
        total = {name: max(x, now.total[name]) for name, x in _sum(now.rung.predicted, found.predicted).items()}
        added = {name: x - now.total[name] for name, x in total.items()}
        return PathStep(Spent.STEPS, (), added, total, replace(now.rung, chosen=found))

    def _steps_at(self, k: int, room: Errors, added: Errors) -> Steps | None:
        """Return the time steps of a rung of the ladder that fit beside what it adds; None where there is no room."""
        left = {name: x - added[name] for name, x in room.items()}
        if min(left.values()) <= 0 or not self.prediction.holds(self._rungs[k]):
            return None
        if k not in self._steps or not _fits(self._steps[k].predicted, left):
            limits = {name: min(x, SHARE * self.tolerance[name]) for name, x in left.items()}
            self._steps[k] = self.prediction.steps_of(self._rungs[k], tolerance=limits, share=1.0)
        return self._steps[k] if _fits(self._steps[k].predicted, left) else None

    def _steps_at_least(self, k: int, now: PathStep) -> Steps:
        """Return the time steps of a rung where its springs alone are left out."""
        return self._steps.get(k, now.steps)

    def _place(self, rung: Rung) -> int:
        return next(k for k, one in enumerate(self._rungs) if {*one.left_out} == {*rung.left_out})

    def _outputs(self, left_out: Sequence[str]) -> list[Array]:
        """Return the outputs (N, names) of each motion where springs and parts of drives follow."""
        each = [path.following(left_out) for path in self.prediction.paths]
        return [Deviations(path).with_springs([springs])[1][:, 0] for path, springs in each]

    def _changes_at(self, k: int) -> dict[str, list[Array]]:
        """Return the changes of outputs (N, names) of each motion by name, where the springs of a rung are static."""
        if k not in self._changes:
            left_out = self._rungs[k].left_out
            names = (*self._numbers[0].numbers, *(x for x in self._numbers[0].neutral if x in left_out))
            each = [one.changes([(name,) for name in names], left_out) for one in self._numbers]
            self._changes[k] = {name: [x[:, row] for x in each] for row, name in enumerate(names)}
        return self._changes[k]

    def _savings_at(self, k: int, method: str) -> Savings:
        """Return what a step of a rung saves without numbers, and with springs held as neutral."""
        if (k, method) not in self._savings:
            prediction, rung = self.prediction, self._rungs[k]
            machine, symbols = with_symbols(prediction.references[0].loaded)
            held = held_springs(prediction.machine, prediction.references[0], rung)
            shifted = [name for name in rung.left_out if name in self._numbers[0].neutral]
            own = {name: f"held{j}" for j, name in enumerate(shifted)}
            new = tuple(Parameter(own[name], held[name]) for name in shifted)
            machine = replace(machine, parameters=(*machine.parameters, *new))
            static = {name: Formula.parse(own[name]) if name in own else x for name, x in held.items()}
            symbols = symbols | own
            kept = restrict(machine, Scene(static=dict(static), zero=zeros_of(replace(rung, zero=()), held)))
            self._savings[k, method] = Savings(kept, ways_of(prediction.references[0]), symbols, METHODS[method])
        return self._savings[k, method]

    def _has_inertia(self, numbers: LeftOutNumbers, rung: Rung) -> bool:
        return not rung.zero or numbers.has_inertia(rung.zero, rung.left_out)

    def _largest(self, changes: Sequence[Sequence[Array]]) -> dict[str, float]:
        """Return the largest sum of changes by output, over all motions."""
        each = [np.abs(sum(parts)).max(axis=0) for parts in zip(*changes, strict=True)]
        return dict(zip(self.tolerance, np.max(each, axis=0).tolist(), strict=True))


def _fits(errors: Errors, room: Errors) -> bool:
    return all(errors[name] <= x for name, x in room.items())


def _sum(first: Errors, second: Errors) -> dict[str, float]:
    return {name: x + second[name] for name, x in first.items()}
