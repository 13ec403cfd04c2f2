"""`check --self`: digits of the results of generated C that survive rounding, by rounding modes alone."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.rounding import RoundingModes, Spread
from symoro_elastic.numerics.states import States, extreme_states, moderate_states
from symoro_elastic.numerics.values import parameter_values
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.traced import traced

CHECKED_STATES = 1000


@dataclass(frozen=True)
class Surviving:
    """The spread of a result over some states: worst, median, decimal digits that survive at worst, and where."""

    worst: float
    typical: float
    digits: float
    at: str


@dataclass(frozen=True)
class ResultCheck:
    """One result of a model, at moderate and at extreme states."""

    model: str
    result: str
    moderate: Surviving
    extreme: Surviving


def self_check(
    machine: Machine, scene: Scene, *, states: int = CHECKED_STATES, seed: int = 0, progress: Progress = no_progress
) -> list[ResultCheck]:
    """Return the check of every result of the models of a scene, run in the four rounding modes.

    `states` moderate and as many extreme states; parameters without value get a plausible one. Raises `NoValues`,
    `CompilerMissing`, `CompilationFailed`.
    """
    programs = traced(machine, scene)
    kept = programs.machine
    values = parameter_values(kept, seed)
    p = np.array([values[parameter.name] for parameter in programs.package.parameters], dtype=float)
    drawn = [draw(kept, states, seed, values) for draw in (moderate_states, extreme_states)]
    checks = []
    with tempfile.TemporaryDirectory() as folder:
        modes = RoundingModes(programs.package, Path(folder))
        for k, model in enumerate(programs.models, start=1):
            spreads = [_run(modes, model.model.name, model.model.arguments, some, p) for some in drawn]
            for name in model.results:
                survive = (_surviving(spread[name], some) for spread, some in zip(spreads, drawn, strict=True))
                checks.append(ResultCheck(model.model.name, name, *survive))
            progress(k, len(programs.models))
    return checks


def _run(modes: RoundingModes, model: str, arguments: tuple[str, ...], states: States, p: Array) -> dict[str, Spread]:
    return modes.run(model, len(states), {name: getattr(states, name) for name in arguments} | {"p": p})


def _surviving(spread: Spread, states: States) -> Surviving:
    worst = int(np.argmax(spread.spread))
    return Surviving(
        float(spread.spread[worst]),
        float(np.median(spread.spread)),
        float(spread.digits[worst]),
        f"state {worst + 1} ({states.titles[worst]})",
    )
