"""S, inertia and velocity forces in numbers at a position, against the formulas evaluated there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Floating, Machine
from symoro_elastic.mechanics.dynamics import dynamics
from symoro_elastic.mechanics.mechanism import without_loads
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.bound.position import Position
from symoro_elastic.models.bound.rules import held_rules
from symoro_elastic.models.dynamics.floating_base import inertia
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.counted_calls import calls_of
from tests.references.random_machines import chain, led_by_the_first, random_machine

EXAMPLES = Path(__file__).parents[2] / "examples"
ROUNDING = 1e-13
"""Of the largest entry: sums of some hundred products along chains of 8 bodies, each rounded by 1.1e-16."""


def machines() -> list[Machine]:
    """Trees, joints that follow others, a loop with a coupling, a base that flies."""
    trees = [random_machine(seed, joints=8) for seed in range(3)]
    body = next(joint.body for joint in random_machine(5, joints=5, massless=0.0).joints)
    flying = replace(random_machine(5, joints=5, wrenches=False), floating=Floating(body=body))
    loop, _ = read_machine(EXAMPLES / "four_bar.par")
    return [*trees, *map(led_by_the_first, trees), loop, flying]


def symbols_of(machine: Machine, bound: Bound) -> dict[str, float]:
    source = np.random.default_rng(7)
    drawn = {str(machine.joint(j).variable): float(source.uniform(-1, 1)) for j in machine.with_variable}
    return {**parameter_values(machine), **drawn}


@pytest.mark.parametrize("machine", machines(), ids=lambda one: one.name)
def test_inertia_and_velocity_forces_are_those_of_the_formulas(machine: Machine) -> None:
    bound = Bound(machine)
    symbols, n = symbols_of(machine, bound), len(machine.independent)
    here = Position(bound, symbols)
    A = _numbers(inertia(bound, coordinate_inertia(bound), machine.independent).entries, symbols)
    size = n + machine.degrees_of_base
    _near(here.inertia(), A.reshape(size, size))
    rates = np.random.default_rng(8).uniform(-1, 1, (3, n))
    found = dynamics(without_loads(bound.without_tip_angles), bound.rates(), held_rules(bound))
    formulas = bound.on_independent(found.Gamma)
    for state, H in zip(rates, here.velocity_forces(rates).T, strict=True):
        known = {**symbols, **dict(zip(bound.arguments()["qd"], state.tolist(), strict=True))}
        _near(H, _numbers([formulas[k] for k in machine.independent], known))


def test_no_formula_is_formed_and_the_steps_grow_with_the_joints() -> None:
    """A formula for each pair of joints would double the graph at least, and take four times the calls."""
    calls = []
    for n in (20, 40):
        bound = Bound(led_by_the_first(chain(n)))
        symbols = symbols_of(bound.machine, bound)
        assert bound.without_tip_angles and bound.coordinates.S and bound.arguments()
        nodes = len(bound.graph)
        calls.append(calls_of(lambda bound=bound, symbols=symbols: Position(bound, symbols).inertia()))
        assert len(bound.graph) == nodes
    assert calls[1] < 2.5 * calls[0]


def _numbers(entries: object, symbols: dict[str, float]) -> Array:
    roots = list(entries)  # type: ignore[call-overload]
    value = evaluate(roots, symbols, FLOATS)
    return np.array([float(value(x)) for x in roots])


def _near(found: Array, wanted: Array) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUNDING * np.abs(wanted).max(initial=1.0))
