"""One record carries the state of a machine: a further block is one row of the table of quantities."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.reference_motion import Motion
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.machine.machine import KnownOfBase, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.model import Model, Result
from symoro_elastic.models.bound.state import State, rows_carried, rows_of_state, split_into
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.implementations import c_code, equations_on_floats, import_package, numpy_code
from symoro_elastic.numerics.verification.states import extreme_states, moderate_states
from symoro_elastic.quantities import QUANTITIES, Quantity, Role, Samples
from symoro_elastic.quantities.units import same
from tests.closed_chains.machines import machine as closed_chain
from tests.examples import example

CURRENT = Quantity(
    name="i_motor",
    meaning="currents of the motors",
    symbol="i",
    unit=same("A"),
    shape="m",
    roles=(Role.ARGUMENT, Role.STATE, Role.CARRIED),
    entries="i@",
    samples=Samples(3, (-2, 2)),
)
"""A block that no machine has today."""


@pytest.fixture
def with_currents(monkeypatch: pytest.MonkeyPatch) -> Machine:
    """A machine of two motors, while the table of quantities has one row more."""
    monkeypatch.setitem(QUANTITIES, CURRENT.name, CURRENT)
    return example("two_axis.toml")


def losses(name: str = "losses") -> Model:
    """What the new block is for: i_k^2 of each motor."""

    def run(bound, _):
        currents = [bound.graph.symbol(x) for x in bound.arguments()[CURRENT.name]]
        return {"H": Result(bound.machine.motors, tuple(x * x for x in currents))}

    return Model(name, "losses of motors over their resistance", "", ("q", CURRENT.name), ("H",), run)


def names(machine: Machine) -> list[str]:
    return [row.name for row in rows_carried(machine)]


def test_the_blocks_of_a_state_follow_from_the_machine() -> None:
    flying = example("floating_arm.toml")
    moved = replace(flying, floating=replace(flying.floating, known=KnownOfBase.ACCELERATION))
    assert names(example("two_axis.toml")) == names(example("linkage.toml")) == ["q", "qd"]
    assert names(closed_chain("ring")) == ["q", "qd", "q_dep"]
    assert names(flying) == ["q", "qd", "Q0", "P0", "V0"]
    assert names(moved) == ["q", "qd"]
    assert {"q_dep"} == {row.name for row in rows_of_state(example("linkage.toml"))} & {"q_dep", "V0", "f_ext"}


def test_blocks_that_a_machine_does_not_have_are_without_entries() -> None:
    states = moderate_states(example("two_axis.toml"), 3)
    assert states.q_dep.shape == states.V0.shape == states.f_ext.shape == (3, 0)
    with pytest.raises(AttributeError):
        _ = states.qddd


def test_states_are_joined_and_taken_apart() -> None:
    drawn = moderate_states(closed_chain("ring"), 3) + extreme_states(closed_chain("ring"), 2)
    assert len(drawn) == len(drawn.titles) == 5
    part = drawn[np.array([4, 0])]
    assert part.titles == (drawn.titles[4], "moderate") and np.array_equal(part.q_dep, drawn.q_dep[[4, 0]])
    whole = np.concatenate([*drawn.blocks.values()], axis=-1)
    again = State(split_into(drawn.blocks, whole))
    assert again.blocks.keys() == drawn.blocks.keys()
    assert all(np.array_equal(again.blocks[name], block) for name, block in drawn.blocks.items())


def test_a_further_block_is_one_row(with_currents: Machine) -> None:
    """It is in test states, moderate and extreme, in parts of motions, and in what time steps take further."""
    moderate, extreme = (draw(with_currents, 16) for draw in (moderate_states, extreme_states))
    assert np.abs(moderate.i_motor).max() <= 3 and moderate.i_motor.shape == (16, len(with_currents.motors))
    assert np.abs(extreme.i_motor).max() > 3
    assert names(with_currents) == ["q", "qd", CURRENT.name]
    motion = Motion(moderate.blocks, np.arange(16.0))[3:5]
    assert np.array_equal(motion.i_motor, moderate.i_motor[3:5]) and motion.t.tolist() == [3.0, 4.0]


def test_time_steps_are_given_a_further_block(with_currents: Machine) -> None:
    """Their heads in C and numpy have it after the rest of the state, in the order of the record."""
    package = trace_models(with_currents, Scene(models=("direct_dynamics",), steps=("rk4",))).package
    assert [block.name for block in package.state] == ["q", "qd", CURRENT.name]
    header = next(text for name, text in render_c(package).items() if name.endswith(".h"))
    head = next(part for part in header.split(";") if "_step_rk4(" in part)
    assert "double qd[TWO_AXIS_JOINTS], double i_motor[TWO_AXIS_MOTORS]" in " ".join(head.split())
    assert "q, qd, i_motor, p=DEFAULTS" in " ".join(" ".join(render_numpy(package).values()).split())


def test_calls_of_generated_functions_take_a_further_block(
    with_currents: Machine, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(MODELS, "losses", losses())
    programs = trace_models(with_currents, Scene(models=("losses",)))
    values, states = parameter_values(with_currents), moderate_states(with_currents, 4)
    (model,) = programs.models
    p = np.array([values[one.name] for one in programs.package.parameters])
    wanted = states.i_motor**2
    library = CompiledPackage(programs.package, compile_library(render_c(programs.package), tmp_path))
    module = import_package(render_numpy(programs.package), tmp_path / "numpy")
    for run in (c_code(library, p), numpy_code(module, p, stacked=True), equations_on_floats(values)):
        np.testing.assert_allclose(run(model, states)["H"], wanted, rtol=1e-15)
