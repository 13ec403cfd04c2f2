"""FMUs run by FMPy: values, derivatives, steps and states are those of the models."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(not shutil.which("cc") and not shutil.which("gcc"), reason="needs a C compiler"),
    pytest.mark.sampled(3),
]

from fmpy import simulate_fmu  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

import symoro_elastic as se  # noqa: E402
from symoro_elastic.machine.constants import with_free_numbers  # noqa: E402
from symoro_elastic.machine.scene import Scene  # noqa: E402
from tests.generation.fmu.machines import elastic_arm, four_bar  # noqa: E402
from tests.generation.fmu.running import CO_SIMULATION, MODEL_EXCHANGE, Running, running  # noqa: E402

PUSH = {"drive.tau": 6.0, "tool.fx": 20.0, "tool.fy": -5.0, "tool.mz": 1.0}
DURATION = 0.2


@pytest.fixture(params=["arm", "linkage"])
def started(request: pytest.FixtureRequest) -> Iterator[Running]:
    """Each FMU at some state, for Model Exchange."""
    with running(request.getfixturevalue(request.param)) as found:
        found.begin()
        source = np.random.default_rng(3)
        size = found.nominals() * source.uniform(-0.3, 0.3, len(found.states))
        found.set(dict(zip(found.states, found.get(found.states) + size, strict=True)))
        yield found


PARAMETERS = {"L": "L", "arm.mass": "M2", "arm.stiffness": "k2", "rod.center_of_mass.z": "cz3", "rod.damping": "d3"}
"""Names in the FMU, and in the models of the arm with parameters in place of numbers."""
WRENCH = [PUSH.get(f"tool.{name}", 0.0) for name in ("fx", "fy", "fz", "mx", "my", "mz")]


@cache
def arm_code() -> Any:
    """Models of the arm with the numbers of its tables as parameters."""
    machine = with_free_numbers(elastic_arm(), ("bodies", "springs"), {})
    models = ("direct_dynamics", "direct_dynamics_derivatives", "direct_dynamics_parameter_derivatives")
    by = {"direct_dynamics_parameter_derivatives": (f"by {', '.join(PARAMETERS.values())}",)}
    return se.load(machine, *models, scene=Scene(forces=("tool",)), only=by)


def accelerations_of_arm(q: np.ndarray, qd: np.ndarray) -> Any:
    return arm_code().direct_dynamics(q, qd, [PUSH["drive.tau"]], WRENCH)


def test_it_starts_at_rest_in_equilibrium(arm: Path, linkage: Path) -> None:
    for path in (arm, linkage):
        with running(path) as one:
            rates = one.get(one.rates) / np.tile(one.nominals()[len(one.states) // 2 :], 2)
            assert np.abs(rates).max() < 1e-8
            assert any(float(one.variables[name].start) for name in one.named("input"))


def test_a_start_value_moves_the_equilibrium_no_further(arm: Path) -> None:
    with running(arm) as one:
        one.set({"drive.tau": 0.0})
        assert one.get(["der(drive.qd)"])[0] < -1.0


def test_accelerations_are_those_of_the_model(arm: Path) -> None:
    with running(arm) as one:
        one.begin()
        one.set({**PUSH, "drive.q": 0.3, "arm.q": -0.01, "rod.q": 0.02, "drive.qd": 1.0, "rod.qd": -0.2})
        q, qd = np.split(one.get(one.states), 2)
        expected = accelerations_of_arm(q, qd)
        np.testing.assert_allclose(one.get(one.rates), [*qd, *expected], rtol=1e-13)


def test_outputs_are_places_of_frames_and_deflections(arm: Path) -> None:
    with running(arm) as one:
        one.begin()
        one.set({"drive.q": 0.3, "arm.q": -0.01, "rod.q": 0.025})
        assert one.get(["rod.deflection"])[0] == pytest.approx(0.005, abs=1e-17)
        T = se.load(elastic_arm(), "geometric_model").geometric_model([0.3, -0.01, 0.025])
        point = T[3] @ [0.1, 0.0, 0.6, 1.0]
        np.testing.assert_allclose(one.get([f"'tool at (0.1, 0, L)'.{axis}" for axis in "xy"]), point[:2], rtol=1e-14)


def test_joints_that_follow_from_loops_are_outputs(linkage: Path) -> None:
    with running(linkage) as one:
        one.begin()
        one.set({"crank.q": 0.9, "crank.qd": 2.0})
        code = se.load(four_bar(), "dependent_coordinates", "coupling_matrix")
        q, qd = np.split(one.get(one.states), 2)
        x = code.dependent_coordinates(q)
        S, _ = code.coupling_matrix(q, qd)
        np.testing.assert_allclose(one.get(["coupler.q", "rocker.q"]), x[1:3], rtol=1e-13)
        np.testing.assert_allclose(one.get(["coupler.qd", "rocker.qd"]), (S @ qd)[1:3], rtol=1e-12)


def test_directional_derivatives_are_those_of_the_derivative_models(arm: Path) -> None:
    """Columns by recursion and linear systems, or of the graph one by one; here one pass along a seed."""
    with running(arm) as one:
        one.begin()
        one.set({**PUSH, "drive.q": 0.3, "arm.q": -0.01, "rod.q": 0.02, "drive.qd": 1.0, "rod.qd": -0.2})
        q, qd = np.split(one.get(one.states), 2)
        state = (q, qd, [PUSH["drive.tau"]], WRENCH)
        by_state = np.hstack(arm_code().direct_dynamics_derivatives(*state))
        by_p = arm_code().direct_dynamics_parameter_derivatives(*state)
        found = np.array([one.along(one.rates[3:], {name: 1.0}) for name in [*one.states, "drive.tau"]]).T
        np.testing.assert_allclose(found, by_state, rtol=1e-12, atol=1e-12 * np.abs(by_state).max())
        found = np.array([one.along(one.rates[3:], {name: 1.0}) for name in PARAMETERS]).T
        np.testing.assert_allclose(found, by_p, rtol=1e-11, atol=1e-12)
        both = one.along(one.rates, {"arm.q": 2.0, "L": -3.0})
        np.testing.assert_allclose(both[3:], 2 * by_state[:, 1] - 3 * by_p[:, 0], rtol=1e-11)


def test_directional_derivatives_are_central_differences_of_the_unit_itself(started: Running) -> None:
    """Of fourth order: the error is h^4 and the rounding of values over h."""
    unknowns = [*started.rates, *started.named("output")]
    sizes = dict(zip(started.states, started.nominals(), strict=True))
    for name in [*started.states, *started.named("input"), *started.named("parameter")]:
        (x,) = started.get([name])
        h = 1e-3 * sizes.get(name, max(abs(x), 1.0))

        def at(change: float, name: str = name, x: float = x) -> np.ndarray:
            started.set({name: x + change})
            return started.get(unknowns)

        differences = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
        values = at(0.0)
        exact = started.along(unknowns, {name: 1.0})
        bound = 1e-8 * np.maximum(np.abs(exact), np.abs(exact).max() * 1e-3) + 1e-14 * np.abs(values) / h
        assert (np.abs(differences - exact) <= bound).all(), name


def test_what_is_no_dependency_has_no_derivative(started: Running) -> None:
    structure = started.description.derivatives + started.description.outputs
    known = [*started.states, *started.named("input")]
    columns = {name: started.along([one.variable.name for one in structure], {name: 1.0}) for name in known}
    for row, one in enumerate(structure):
        needed = {name for name in known if columns[name][row] != 0}
        assert needed <= {x.name for x in one.dependencies}
    inputs = {x.name for one in started.description.derivatives for x in one.dependencies}
    assert {name for name in known if any(columns[name][: len(started.rates)])} == inputs & {*known}


def test_model_exchange_and_co_simulation_end_where_the_model_does(arm: Path) -> None:
    """Co-simulation to 1e-11, Model Exchange by CVODE to 1e-8: DOP853 on the generated model."""
    with running(arm) as one:
        start = one.get(one.states)
        names = one.states

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[3:], accelerations_of_arm(y[:3], y[3:])])

    expected = solve_ivp(rate, (0, DURATION), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    for kind, bound in ((MODEL_EXCHANGE, 1e-8), (CO_SIMULATION, 1e-11)):
        made = simulate_fmu(
            str(arm),
            fmi_type=kind,
            start_values=PUSH,
            stop_time=DURATION,
            output_interval=0.02,
            output=names,
            relative_tolerance=1e-12,
        )
        assert np.abs(np.array([made[name][-1] for name in names]) - expected)[:3].max() < bound, kind
        assert np.abs(expected - start)[0] > 0.1


def test_the_error_of_co_simulation_follows_the_tolerance(arm: Path) -> None:
    ends = []
    for tolerance in (1e-5, 1e-7, 1e-12):
        with running(arm, CO_SIMULATION, tolerance) as one:
            one.set(PUSH)
            one.begin()
            one.step(0.0, DURATION)
            ends.append(one.get(one.states) / one.nominals())
    coarse, fine = (np.abs(end - ends[-1]).max() for end in ends[:2])
    assert fine < coarse / 10
    assert coarse < 100 * 1e-5


def test_the_size_of_communication_steps_does_not_matter(linkage: Path) -> None:
    ends = []
    for count in (1, 7):
        with running(linkage, CO_SIMULATION, 1e-11) as one:
            one.set({"crank.tau": 3.0})
            one.begin()
            for k in range(count):
                one.step(k * DURATION / count, DURATION / count)
            ends.append(one.get(one.states) / one.nominals())
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-7)


def test_derivatives_of_inputs_are_followed(arm: Path) -> None:
    """A ramp in one step beside the equations of motion, integrated by another method to 1e-13.

    Inner stages see the input at their own times: at nodes rounded to whole numbers the error is 1e-6 and more.
    """
    rate, length = 40.0, 0.1
    with running(arm, CO_SIMULATION, 1e-10) as one:
        one.begin()
        size, start = one.nominals(), one.get(one.states)
        (held,) = one.get(["drive.tau"])
        wrench = one.get([f"tool.{name}" for name in ("fx", "fy", "fz", "mx", "my", "mz")])
        one.fmu.setRealInputDerivatives([one.references["drive.tau"]], [1], [rate])
        one.step(0.0, length)
        ramp = one.get(one.states)
    n = len(start) // 2

    def derivative(t: float, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[n:], arm_code().direct_dynamics(x[:n], x[n:], [held + rate * t], wrench)])

    exact = solve_ivp(derivative, (0.0, length), start, method="DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
    assert np.abs((exact - start) / size).max() > 0.01
    assert (np.abs(ramp - exact) / (size + np.abs(exact))).max() < 1e-9


@pytest.mark.parametrize("name", ["arm", "linkage"])
def test_a_state_that_is_kept_gives_the_same_steps_again(name: str, request: pytest.FixtureRequest) -> None:
    with running(request.getfixturevalue(name), CO_SIMULATION) as one:
        one.set({one.named("input")[0]: 2.0})
        one.begin()
        one.step(0.0, 0.01)
        kept = one.state()
        text = one.as_bytes(kept)
        one.step(0.01, 0.02)
        first = one.get(one.states)
        one.go_back(kept)
        one.step(0.01, 0.02)
        np.testing.assert_array_equal(one.get(one.states), first)
        one.go_back(one.of_bytes(text))
        one.step(0.01, 0.02)
        np.testing.assert_array_equal(one.get(one.states), first)
        one.fmu.reset()
        np.testing.assert_array_equal(one.get(one.states), [float(one.variables[x].start) for x in one.states])


def test_inputs_that_are_not_finite_are_an_error_and_no_endless_step(arm: Path) -> None:
    with running(arm, CO_SIMULATION) as one:
        one.set({"drive.tau": float("nan")})
        one.begin()
        with pytest.raises(Exception, match="fmi2DoStep"):
            one.step(0.0, 0.01)


def test_the_steps_inside_a_communication_step_have_a_limit(
    short_of_steps: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with running(short_of_steps, CO_SIMULATION) as one:
        one.set({"drive.qd": 1e7})
        one.begin()
        with pytest.raises(Exception, match="fmi2DoStep"):
            one.step(0.0, 0.1)
        assert 0 < one.get(["time"])[0] < 0.1
    assert "50 steps did not reach the end of the communication step" in capfd.readouterr().out


def test_the_form_of_the_accelerations_is_the_one_that_is_asked_for(arm: Path, short_of_steps: Path) -> None:
    """Both forms have the same values, derivatives too, and other programs."""
    found = []
    for path in (arm, short_of_steps):
        with running(path) as one:
            one.begin()
            one.set({**PUSH, "drive.q": 0.3, "arm.q": -0.01, "rod.q": 0.02, "drive.qd": 1.0, "rod.qd": -0.2})
            found.append([one.get(one.rates), one.along(one.rates, {"arm.q": 2.0, "L": -3.0, "drive.tau": 1.0})])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-11)
    sources = [zipfile.ZipFile(path).read("sources/elastic_arm.c") for path in (arm, short_of_steps)]
    assert [b"through the inertia matrix" in text for text in sources] == [False, True]


def test_model_exchange_of_a_stiff_machine_runs_with_all_defaults(stiff: Path) -> None:
    """CVODE is given 500 steps between two times of output by FMPy."""
    made = simulate_fmu(str(stiff), fmi_type=MODEL_EXCHANGE, start_values={"drive.tau": 40.0})
    assert len(made) > 400
    assert np.isfinite(made["arm.q"]).all() and np.ptp(made["rod.q"]) > 0


def test_what_cannot_be_set_is_an_error(arm: Path, linkage: Path) -> None:
    for path in (arm, linkage):
        with running(path) as one, pytest.raises(Exception, match=r"fmi[23]Set"):
            one.set({one.rates[0]: 1.0})
