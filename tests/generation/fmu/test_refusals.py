"""Calls that FMUs refuse or warn of: out of order, from another time, bytes that are no state, values below `min`."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(not shutil.which("cc") and not shutil.which("gcc"), reason="needs a C compiler")

from tests.generation.fmu.running import CO_SIMULATION, Running, running  # noqa: E402

ERROR = r"status 3 \(error\)"
Output = pytest.CaptureFixture[str]
BOUNDED = ("arm.mass", "rod.mass", "arm.stiffness", "rod.stiffness")


@pytest.fixture(params=["arm", "linkage"])
def path(request: pytest.FixtureRequest) -> Path:
    """An FMU of FMI 2.0, and one of 3.0."""
    found: Path = request.getfixturevalue(request.param)
    return found


def again(one: Running) -> None:
    one.fmu.reset()
    one.fmu.enterInitializationMode()
    one.begin()


def before_the_end_of_the_initialization(one: Running) -> None:
    one.step(0.0, 0.01)


def after_the_end(one: Running) -> None:
    one.begin()
    one.fmu.terminate()
    one.step(0.0, 0.01)


def after_a_reset(one: Running) -> None:
    one.begin()
    one.fmu.reset()
    one.step(0.0, 0.01)


def from_another_time(one: Running) -> None:
    one.begin()
    one.step(0.0, 0.01)
    one.step(5.0, 0.01)


def from_the_time_before_a_reset(one: Running) -> None:
    one.begin()
    one.step(0.0, 0.01)
    again(one)
    one.step(0.01, 0.01)


def of_no_length(one: Running) -> None:
    one.begin()
    one.step(0.0, 0.0)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("step", "said"),
    [
        (before_the_end_of_the_initialization, "after initialization mode was entered and left"),
        (after_the_end, "after initialization mode was entered and left, and before the end"),
        (after_a_reset, "after initialization mode was entered and left"),
        (from_another_time, "a communication step begins where the last one ended"),
        (from_the_time_before_a_reset, "a communication step begins where the last one ended"),
        (of_no_length, "a communication step is a positive number"),
    ],
)
def test_steps_out_of_order_are_errors(step: Callable[[Running], None], said: str, path: Path, capfd: Output) -> None:
    with running(path, CO_SIMULATION) as one, pytest.raises(Exception, match=f"DoStep.*{ERROR}"):
        step(one)
    assert said in capfd.readouterr().out


@pytest.mark.thorough
def test_calls_out_of_order_are_errors(path: Path, capfd: Output) -> None:
    with running(path, CO_SIMULATION) as one:
        with pytest.raises(Exception, match=f"EnterInitializationMode.*{ERROR}"):
            one.fmu.enterInitializationMode()
        with pytest.raises(Exception, match=f"Terminate.*{ERROR}"):
            one.fmu.terminate()
        one.begin()
        with pytest.raises(Exception, match=f"ExitInitializationMode.*{ERROR}"):
            one.begin()
        one.step(0.0, 0.01)
        again(one)
        one.step(0.0, 0.01)
    assert capfd.readouterr().out.count("this is called out of order") == 3


@pytest.mark.thorough
def test_steps_of_model_exchange_are_errors(arm: Path, capfd: Output) -> None:
    with running(arm) as one:
        one.begin()
        step = one.fmu.dll.fmi2DoStep
        step.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int]
        assert step(one.fmu.component, 0.0, 0.01, 0) == 3
    assert "for Model Exchange, which takes no steps" in capfd.readouterr().out


@pytest.mark.thorough
def test_times_that_an_importer_adds_up_are_those_of_the_steps(arm: Path) -> None:
    """Sums of steps differ from their products by rounding."""
    with running(arm, CO_SIMULATION) as one:
        one.begin()
        time, size = 0.0, 0.1 / 3
        for k in range(30):
            one.step(time if k % 2 else k * size, size)
            time += size
        assert one.get(["time"])[0] == pytest.approx(1.0, abs=1e-12)


def damaged(text: bytes, at: int) -> bytes:
    return text[:at] + bytes([text[at] ^ 1]) + text[at + 1 :]


@pytest.mark.thorough
def test_bytes_that_are_no_state_are_errors(path: Path, short_of_steps: Path, capfd: Output) -> None:
    with running(path, CO_SIMULATION) as one, running(short_of_steps, CO_SIMULATION) as other:
        for each in (one, other):
            each.begin()
        one.step(0.0, 0.01)
        before = one.get(one.states)
        text = one.as_bytes(one.state())
        places = [0, 10, 50, len(text) // 2, len(text) - 1]
        bad = [damaged(text, at) for at in places]
        bad += [bytes(len(text)), b"\xff" * len(text), text[:-1], text + b"\0", b"", other.as_bytes(other.state())]
        for one_bad in bad:
            with pytest.raises(Exception, match=ERROR):
                one.of_bytes(one_bad)
        assert capfd.readouterr().out.count("these bytes are not a state of this FMU") == len(bad)
        np.testing.assert_array_equal(one.get(one.states), before)
        one.go_back(one.of_bytes(text))
        one.step(0.01, 0.01)


@pytest.mark.thorough
def test_values_below_their_least_are_warned_of_once(arm: Path, capfd: Output) -> None:
    with running(arm, CO_SIMULATION) as one:
        one.set(dict.fromkeys(one.named("parameter"), -5.0))
        one.set({"arm.mass": -6.0})
        out = capfd.readouterr().out
        assert out.count("[WARNING]") == len(BOUNDED)
        assert all(out.count(f"{name} is below its min of 0") == 1 for name in BOUNDED)
        one.fmu.reset()
        one.set({"rod.stiffness": -0.1, "arm.mass": 0.0, "rod.damping": -1.0})
        assert capfd.readouterr().out.count("[WARNING]") == 1


def test_a_parameter_that_is_not_finite_is_named_by_its_kind(arm: Path, capfd: Output) -> None:
    with running(arm, CO_SIMULATION) as one:
        one.set({"arm.mass": float("nan")})
        one.begin()
        with pytest.raises(Exception, match=f"DoStep.*{ERROR}"):
            one.step(0.0, 0.01)
    assert "accelerations are not finite: an input, a state or a parameter is not" in capfd.readouterr().out


@pytest.mark.thorough
def test_messages_are_switched_off_and_on(path: Path, capfd: Output) -> None:
    def fail(one: Running) -> str:
        with pytest.raises(Exception, match=ERROR):
            one.set({one.rates[0]: 1.0})
        return capfd.readouterr().out

    with running(path) as one:
        for on, categories, is_told in (
            (False, [], False),
            (True, [], True),
            (False, ["logStatusWarning"], True),
            (False, ["logStatusError"], False),
            (True, ["logStatusError"], True),
        ):
            one.fmu.setDebugLogging(on, categories)
            assert ("cannot be set" in fail(one)) == is_told, (on, categories)
        one.fmu.setDebugLogging(True, [])
        one.fmu.setDebugLogging(True, ["logOfNothing"])
        assert "[WARNING]" in capfd.readouterr().out
