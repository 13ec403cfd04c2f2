"""States of the machines, drawn near the `start` of their loops: `python -m tests.closed_chains.states NAME...`.

Matrices of small motions about the first one stand beside them. Independent variables move from `start` in steps, the
loops closed at each, so that every state is on its branch. Deflections are those of forces up to some hundred newtons.
"""

from __future__ import annotations

import json
import random
import sys
from typing import Any

import mpmath
import numpy as np
from mpmath import mpf

from symoro_elastic.machine.machine import Joint, Kind
from tests.closed_chains.machines import FOLDER, WITH_RESULTS, machine
from tests.references.closed_chains import Chain, State, in_many_digits, nearest_double
from tests.references.virtual_work import VirtualWork, small_motions

STATES, STEPS, KEPT_DIGITS = 2, 5, 21
REACH = {(Kind.MOTOR, 0): 0.4, (Kind.MOTOR, 1): 0.1, (Kind.PASSIVE, 1): 0.06}
"""How far independent variables go by kind and sigma, rad or m."""
LOAD, FARTHEST = 300.0, 0.02
"""Force on springs, N or N m, and their largest deflection, m or rad."""


def main(names: list[str]) -> None:
    for name in names:
        if name in WITH_RESULTS:
            raise SystemExit(f"{name}: its states belong to results of another program")
        chooser = random.Random(name)
        states = [_state(name, chooser) for _ in range(STATES)]
        lines = ",\n ".join(map(json.dumps, states))
        small = json.dumps(_small_motions(name, states[0]))
        path = FOLDER / "data" / f"{name}.json"
        path.write_text(f'{{"states": [\n {lines}\n],\n"linearization": {small}}}\n', encoding="utf-8")


@in_many_digits
def _small_motions(name: str, state: dict[str, Any]) -> dict[str, list[list[str]]]:
    found = small_motions(machine(name), State(state["u"], state["ud"], state["guess"]), state["tau"], nearest_double)
    return {
        label: [[mpmath.nstr(x, KEPT_DIGITS) for x in row] for row in matrix]
        for label, matrix in zip("MDK", found, strict=True)
    }


@in_many_digits
def _state(name: str, chooser: random.Random) -> dict[str, Any]:
    chain = Chain(machine(name))
    start = {k: value.value() for loop in chain.machine.loops for k, value in loop.start.items()}
    joints = [chain.machine.joint(j) for j in chain.machine.independent]
    first = [start.get(variable, 0.0) for variable in chain.independent]
    shifts = [_reach(chain, joint) * chooser.uniform(-1, 1) for joint in joints]
    u, guess = _reachable(chain, start, first, shifts)
    ud = [_short(_reach(chain, joint) * chooser.gauss(0, 2)) for joint in joints]
    at = VirtualWork(chain.machine, State(u, ud, guess))
    udd = np.array([mpf(chooser.gauss(0, 3)) for _ in joints], dtype=object)
    accelerations = dict(zip(chain.own, at.accelerations(udd), strict=True))
    return {
        "u": u,
        "ud": ud,
        "guess": guess,
        "tau": [_short(chooser.gauss(0, 30)) for _ in chain.motors],
        "qdd_motor": [float(accelerations[motor]) for motor in chain.motors],
    }


def _reachable(
    chain: Chain, start: dict[str, float], first: list[float], shifts: list[float]
) -> tuple[list[float], Any]:
    """As `_walk`, half as far as often as a loop does not close."""
    try:
        return _walk(chain, start, first, shifts)
    except ArithmeticError:
        return _reachable(chain, start, first, [shift / 2 for shift in shifts])


def _walk(chain: Chain, start: dict[str, float], first: list[float], shifts: list[float]) -> tuple[list[float], Any]:
    """The independent variables shifted, and the others there, followed from `start`."""
    guess: Any = start
    for step in range(STEPS + 1):
        u = [_short(a + b * step / STEPS) for a, b in zip(first, shifts, strict=True)]
        guess = chain.assemble(State(u, [0] * len(u), guess))
    return u, {name: _short(guess[name]) for name in [*chain.dependent, *chain.cuts]}


def _reach(chain: Chain, joint: Joint) -> float:
    if joint.kind is Kind.ELASTIC:
        rows = chain.numbers(dict.fromkeys(chain.own, mpf(0))).joints
        return min(FARTHEST, LOAD / float(rows[chain.machine.joints.index(joint)].stiffness))
    return REACH[joint.kind, joint.sigma]


def _short(value: Any) -> float:
    return float(f"{float(value):.7g}")


if __name__ == "__main__":
    main(sys.argv[1:])
