"""Springs that follow motors: against closed forms, with progress, and refused by name where no steps are enough."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.analysis.vibration import following
from symoro_elastic.analysis.vibration.comparison import along, move
from symoro_elastic.analysis.vibration.following import MotorCurve, _integrate
from symoro_elastic.analysis.vibration.reference_trajectory import ReferenceTrajectory, through
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Friction, Kind, Machine
from tests.analysis.vibration.machines import drive, machine_of, slide, spring
from tests.compiled_models import cell

pytestmark = pytest.mark.sampled(4)


def uniform(seconds: float, acceleration: float = 2.0) -> ReferenceTrajectory:
    """The motor of `drive` from rest at a constant acceleration."""
    t = np.linspace(0.0, seconds, 1001)
    return through(t, {"motor": acceleration * t**2 / 2}, 5)


@pytest.mark.thorough
@pytest.mark.parametrize(("damping", "seconds"), [(0.0, 25.0), (40.0, 5.0)])
def test_the_spring_swings_as_in_the_closed_form(damping: float, seconds: float) -> None:
    """q = -(a/w^2) (1 - exp(-s t) (cos v t + s/v sin v t)), over 250 periods where nothing damps it."""
    mass, stiffness, a = 5.0, 2e4, 2.0
    trajectory = along(drive(m2=mass, k=stiffness, d=damping), uniform(seconds, a))
    s, squared = damping / (2 * mass), stiffness / mass
    v = np.sqrt(squared - s**2)
    t = trajectory.t
    q = -a / squared * (1 - np.exp(-s * t) * (np.cos(v * t) + s / v * np.sin(v * t)))
    assert t[-1] == pytest.approx(seconds)
    rounding = np.finfo(float).eps * trajectory.q[-1, 0] / 1e-3**2  # of second differences at 1000 Hz
    shaken = 3 * (10 * rounding) * 1e-3 / v * np.sqrt(seconds / 1e-3)  # by that noise, a kick a sample, three sigma
    np.testing.assert_allclose(trajectory.q[:, 1], q, rtol=0, atol=1e-5 * np.abs(q).max() + shaken)
    np.testing.assert_allclose(trajectory.qdd[:, 0], a, rtol=0, atol=100 * rounding)


def test_progress_counts_samples() -> None:
    told: list[tuple[int, int]] = []
    trajectory = along(drive(), uniform(1.0), lambda done, total: told.append((done, total)))
    done = [count for count, _ in told]
    assert done == sorted(set(done)) and told[-1] == (len(trajectory.t), len(trajectory.t))


def test_rates_of_a_motor_curve() -> None:
    """q, qd, qdd of a spline through a polynomial of its degree are those of the polynomial."""
    polynomial = np.polynomial.Polynomial([0.3, -1.0, 0.5, 2.0, -0.7, 0.1])
    t = np.linspace(1.0, 3.0, 41)
    found = MotorCurve.through(t, polynomial(t)[:, None], 5).with_rates()(np.linspace(1.0, 3.0, 97))[:, :, 0]
    fine = np.linspace(1.0, 3.0, 97)
    for k, row in enumerate(found.T):
        np.testing.assert_allclose(row, polynomial.deriv(k)(fine), rtol=1e-8)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("amplitude", "most"), [(0.0, 30), (1e-3, 110)])
def test_evaluations_of_a_swing(amplitude: float, most: int) -> None:
    """The bound on swings is one on work, whether the fastest mode is excited or not."""
    calls = 0
    squared = np.array([2.0, 500.0]) ** 2 * (2 * np.pi) ** 2

    def swinging(_t: float, y: np.ndarray) -> np.ndarray:
        nonlocal calls
        calls += 1
        return np.concatenate([y[2:], -squared * y[:2]])

    first = np.array([1e-3, amplitude, 0.0, 0.0])
    _integrate(swinging, first, np.linspace(0.0, 1.0, 11), "m", lambda *_: None)
    assert calls < most * 500


def with_dry_friction(kind: Kind) -> Machine:
    rubbing = {"friction": Friction(cell(0), cell("F"))}
    law = {"spring": spring(2e4)} if kind is Kind.ELASTIC else {}
    motor = slide("motor", 0, Kind.MOTOR, 3.0, friction=Friction(cell(0), cell(9)))
    return machine_of("drive", motor, slide("load", 1, kind, 5.0, **rubbing, **law), parameters={"F": 1.5})


@pytest.mark.thorough
@pytest.mark.parametrize("kind", [Kind.ELASTIC, Kind.PASSIVE])
def test_dry_friction_beyond_the_motors_is_refused(kind: Kind) -> None:
    machine = with_dry_friction(kind)
    for follow in (lambda: move(machine), lambda: along(machine, uniform(25.0))):
        with pytest.raises(InputError, match=r"drive\.toml: friction: load has no motor, so dry friction holds it"):
            follow()
    none = replace(machine.parameters[0], value=cell(0))
    assert len(move(replace(machine, parameters=(none,))).t) == 501


@pytest.mark.parametrize("damped", [{"k": 2e16}, {"d": 1e9}])
def test_rates_beyond_the_bound_are_refused(damped: dict[str, float]) -> None:
    """Stiff springs, and dampers that are faster than the springs are."""
    with pytest.raises(InputError, match=r"motion: t: 25 s at .* Hz is too long to integrate: cut it to "):
        along(drive(**damped), uniform(25.0))
    with pytest.raises(InputError, match=r"--duration: 25 s at .* Hz is too long to integrate: cut it to "):
        move(drive(**damped), duration=25.0)


def test_motions_that_get_too_fast_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a finite time of escape nor endless small steps end in anything but one line."""
    escaping = lambda _t, y: 1 + y**2  # noqa: E731  (tan t)
    with pytest.raises(InputError, match=r"m: t: the motion becomes too fast to integrate at 1\.57"):
        _integrate(escaping, np.zeros(1), np.linspace(0.0, 3.0, 4), "m", lambda *_: None)
    monkeypatch.setattr(following, "MOST_STEPS", 20)
    with pytest.raises(InputError, match="too fast to integrate at 0"):
        _integrate(lambda t, _y: np.array([np.sign(np.sin(1e4 * t))]), np.zeros(1), np.array([0.0, 1.0]), "m",
                    lambda *_: None)  # fmt: skip
