"""Digits told by rounding modes alone: close to the truth, and without trace in the processor."""

from __future__ import annotations

import ctypes
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from symoro_elastic.cli import cli
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.verification.self_check import DOUBLE_ULP, RoundingModes, self_check
from tests.extremes import states as at
from tests.extremes.brackets import bracketed
from tests.extremes.machines import EXAMPLES, elastic_arm, nearly_parallel, six_axes
from tests.references.random_machines import planar_2r, random_machine

MACHINES = {"RX90": six_axes(), "elastic arm": elastic_arm(1000.0), "tree": random_machine(5, joints=7, symbolic=True)}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_the_spread_covers_the_true_error(machine: Machine) -> None:
    states = at.moderate(machine, 2000) + at.extreme(machine, 2000)
    for model, result, covered, share in bracketed(machine, states):
        assert covered >= 0.999 and share < 3, (model, result)


@pytest.mark.thorough
def test_results_are_those_of_the_generated_code_and_the_mode_is_put_back(tmp_path: Path) -> None:
    machine = planar_2r(elastic=(2,))
    traced = trace(machine, "direct_dynamics")
    described, states = package(machine, [traced], ()), at.moderate(machine, 50)
    p = np.array([parameter.value for parameter in described.parameters])
    arguments = {name: getattr(states, name) for name in ("q", "qd", "tau")} | {"p": p}
    found = RoundingModes(described, tmp_path / "modes").run("direct_dynamics", 50, arguments)["qdd"]
    plain = compile_package(described, tmp_path / "plain").call("direct_dynamics", **arguments)["qdd"]
    assert np.abs(found.results - plain).max() <= 1e-14 * np.abs(plain).max()
    assert (found.spread >= DOUBLE_ULP).all() and (found.spread > DOUBLE_ULP).any()
    assert ctypes.CDLL(None).fegetround() == 0 and 1.0 + 2.0**-53 == 1.0 and -1.0 - 2.0**-53 == -1.0


@pytest.mark.thorough
def test_lost_digits_show() -> None:
    """Axes 1e-8 rad apart: eight digits are lost, and said to be."""
    kept, lost = (
        self_check(nearly_parallel(angle), Scene(models=("inverse_dynamics",)), states=40) for angle in (0.5, 1e-8)
    )
    assert min(check.moderate.digits for check in kept) > 12
    assert min(check.moderate.digits for check in lost) < 10


@pytest.mark.thorough
def test_machines_without_motors_parameters_or_any_result() -> None:
    passive = random_machine(8, joints=4, kinds=(Kind.PASSIVE, Kind.ELASTIC))
    checks = self_check(passive, Scene(models=("inverse_dynamics", "geometric_model")), states=16)
    assert [(check.model, check.result) for check in checks] == [
        ("inverse_dynamics", "tau"),
        ("inverse_dynamics", "qdd"),
        ("geometric_model", "T"),
    ]
    assert all(check.moderate.worst < 1e-10 for check in checks) and checks[0].moderate.worst == DOUBLE_ULP


@pytest.mark.thorough
def test_on_the_command_line(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = ["check", "--self", str(EXAMPLES / "planar_2r.toml")]
    said = CliRunner().invoke(cli, asked)
    assert said.exit_code == 0 and "digits survive in the worst case" in said.stdout and "tau" in said.stdout
    figures = json.loads(CliRunner().invoke(cli, [*asked, "--json"]).stdout)["models"]
    assert 12 < figures["direct_dynamics"]["qdd"]["moderate"]["digits"] < 16
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler"):
        CliRunner().invoke(cli, asked, catch_exceptions=False)
