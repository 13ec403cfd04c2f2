"""`check` finds no error in the code of examples, with all models they have, of drawn trees, clusters and loops."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.elimination import SingularPivot
from symoro_elastic.models.programs.catalogue import MODELS, trace
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.verification.verify import refuse_unverifiable, verify
from tests.closed_chains.machines import FILES
from tests.closed_chains.machines import machine as closed_chain
from tests.examples import EXAMPLES, example
from tests.references.random_machines import led_by_the_first, random_machine

MACHINES = sorted(path.name for path in EXAMPLES.iterdir() if path.suffix in (".toml", ".par", ".xml", ".urdf"))
SHORT = (
    "backlash.toml",
    "ball_screw_rigid.toml",
    "floating_arm.toml",
    "linkage.toml",
    "planar_2r.toml",
    "two_axis.toml",
)
"""Examples of each kind, whose code is compiled in a second."""
LOOPS = ("geared_five_bar", "press_cut_at_crank", "wedge")
"""Loops and couplings with motors on several joints, which load what is below them."""
SINGULAR = "two_axis_printed.par"
"""The table whose inertia matrix is singular: no state of what divides by it can be judged."""
FORCES = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces")


def cell(value: float | str) -> Formula:
    return Formula.parse(value)


def offered(machine: Machine) -> tuple[str, ...]:
    """The models that a machine has, of those that have a reference."""
    names = []
    for name in MODELS:
        try:
            refuse_unverifiable(machine, Scene(models=(name,)))
            trace(machine, name, grouping_of=grouping_by_rank)
        except (InputError, SingularPivot):
            continue
        names.append(name)
    return tuple(names)


def on_a_motor(machine: Machine) -> Machine:
    """The machine on a body that a motor turns about a horizontal axis."""
    body = Body(cell(4), (cell(0.4), cell(0.8), cell(1.2)), (cell(2), ZERO, ZERO, cell(3), ZERO, cell(2.5)))
    turned = Joint("turned", 0, Kind.MOTOR, 0, alpha=cell(1.2), variable="qt", body=body)
    joints = (turned, *(replace(joint, antecedent=joint.antecedent + 1) for joint in machine.joints))
    loops = tuple(replace(loop, cut=loop.cut + 1, meets=loop.meets + 1) for loop in machine.loops)
    return replace(machine, name=f"turned_{machine.name}", joints=joints, loops=loops)


def assert_checked(machine: Machine, models: tuple[str, ...]) -> None:
    checked = verify(machine, Scene(models=models), states=(2, 2))
    assert checked.ok and not checked.missing, checked


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.thorough] * (x not in SHORT)) for x in MACHINES])
def test_all_models_of_an_example_are_those_of_the_reference(name: str) -> None:
    machine = example(name)
    models = offered(machine)
    if name == SINGULAR:
        assert "direct_dynamics" not in models
        models = tuple(model for model in models if model != "direct_dynamics_by_inertia_matrix")
    else:
        assert {"direct_dynamics", "inverse_dynamics", "geometric_model"} <= {*models}
    assert_checked(machine, models)


@pytest.mark.thorough
@pytest.mark.sampled(6)
@pytest.mark.parametrize("seed", range(24))
def test_models_of_drawn_trees_are_those_of_the_reference(seed: int) -> None:
    assert_checked(random_machine(seed + 1000, joints=3 + seed % 4, moving_base=seed % 3 == 0), FORCES)


@pytest.mark.sampled(6)
@pytest.mark.parametrize("seed", range(24))
def test_models_of_drawn_clusters_on_a_motor_are_those_of_the_reference(seed: int) -> None:
    """A joint follows another one, and the bodies that move with both load the motor below them."""
    assert_checked(on_a_motor(led_by_the_first(random_machine(seed + 2000, joints=3 + seed % 3))), FORCES)


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.thorough] * (x not in LOOPS)) for x in FILES])
def test_models_of_loops_on_a_motor_are_those_of_the_reference(name: str) -> None:
    assert_checked(on_a_motor(closed_chain(name)), FORCES)
