"""A cascade as a function of frequency, as slopes, and as a linear system: three forms of one thing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.analysis.control.cascade import (
    Biquad,
    Cascade,
    DeadTime,
    Element,
    FirstOrder,
    Hold,
    cascade_of,
    laplace,
    system_of,
)
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.drives import TUNED, Average, Drive, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint, Kind

ELEMENTS: tuple[Element, ...] = (
    *(DeadTime("dead time", 2e-4), Hold("period", 1.25e-4), FirstOrder("lag", 3e-4)),
    *(Biquad("notch", 120.0, 0.05, 0.5), Biquad("low-pass", 400.0, 0.0, 2**-0.5, low=True)),
)


@pytest.mark.parametrize("one", ELEMENTS, ids=lambda one: one.name)
def test_slopes_are_those_of_the_response(one: Element) -> None:
    """d P/d ln p of each number against a difference of fourth order, whose own error is some 1e-12."""
    s, step = laplace(np.array([1.0, 37.0, 119.0, 900.0])), 1e-4
    slopes = Cascade("m", 20.0, 3.0, np.inf, (one,)).slopes(lambda changed: changed.path_at(s))
    assert slopes.keys() == {"m, Kv", "m, Kp", *(f"m, {label}" for label in one.labels.values())}
    for key, label in one.labels.items():
        near, far = (
            replace(one, **{key: getattr(one, key) * np.exp(h)}).at(s)
            - replace(one, **{key: getattr(one, key) * np.exp(-h)}).at(s)
            for h in (step, 2 * step)
        )
        assert np.allclose(slopes[f"m, {label}"], (8 * near - far) / (12 * step), rtol=1e-9, atol=1e-11)


def test_slopes_by_parameters_are_complete() -> None:
    """A name in a gain, a filter, a time and a winding: one entry, beside those of the parts they make."""
    notch = Notch(Formula.parse("f"), Formula.parse("d/2"), Formula.parse("0.5*cos(d)"))
    times = {"dead_time": Formula.parse("T"), "period": Formula.parse("T")}
    gains = (Formula.parse("2/T/1000"), Formula.parse("J*sqrt(f)"), Formula.parse("atan2(d, 2)"))
    drive = Drive(*gains, filters=(notch, LowPass(Formula.parse("4*f"), 1)), lag=Formula.parse("1e-4"), **times)
    joint, values, s = (
        Joint("m", 0, Kind.MOTOR, 0, "q1"),
        {"f": 90.0, "d": 0.1, "T": 1e-4, "J": 0.4},
        laplace(np.array([3.0, 80.0, 700.0])),
    )
    cascade = cascade_of(joint, drive, values, "file")
    slopes = cascade.slopes(lambda one: one.feedback(s)[0])
    assert slopes.keys() - cascade.repeated_names == {"f", "d", "T", "J", "m, lag of the current loop"}
    assert {"m, dead time", "m, period", "m, Kp"} <= cascade.repeated_names < slopes.keys()
    for name, x in values.items():
        changed = [
            cascade_of(joint, drive, {**values, name: x * np.exp(h)}, "file").feedback(s)[0]
            for h in (-2e-4, -1e-4, 1e-4, 2e-4)
        ]
        expected = (8 * (changed[2] - changed[1]) - (changed[3] - changed[0])) / 12e-4
        assert np.allclose(slopes[name], expected, rtol=1e-9, atol=1e-10 * np.abs(expected).max()), name


@pytest.mark.parametrize("one", [x for x in ELEMENTS if isinstance(x, FirstOrder | Biquad)], ids=lambda one: one.name)
def test_systems_have_the_response(one: Element) -> None:
    found = system_of((one, *ELEMENTS[3:]))
    for s in (3 + 40j, 700j, 9000j):
        by_states = found.C @ np.linalg.solve(s * np.eye(len(found.A)) - found.A, found.B) + found.D
        assert np.isclose(by_states, np.prod([x.at(np.array([s]))[0] for x in (one, *ELEMENTS[3:])]), rtol=1e-12)


def test_dead_times_are_approximated_to_the_fifth_order() -> None:
    """That of Pade of order 2 differs from e^(-x) by x^5/720; a hold counts half its period."""
    found = system_of(ELEMENTS[:2])
    delay = 2e-4 + 1.25e-4 / 2
    for x in (0.05, 0.2):
        s = 1j * x / delay
        by_states = found.C @ np.linalg.solve(s * np.eye(2) - found.A, found.B) + found.D
        assert abs(by_states - np.exp(-1j * x)) == pytest.approx(x**5 / 720, rel=0.05)


def test_a_small_hold_is_one() -> None:
    tiny, small = Hold("period", 1e-4).at(laplace(np.array([1e-4, 1.59]))), Hold("period", 1e-4)
    assert np.allclose(tiny, 1, atol=1e-3)
    around = small.at(laplace(np.array([1e-6 / 2e-4 / np.pi * k for k in (0.999, 1.001)])))
    assert abs(around[0] - around[1]) < 1e-8


def test_numbers_of_a_file() -> None:
    f = Formula.parse
    drive = Drive(
        f("K"), TUNED, f("0.02"), f("2e-4"), period=f("1e-4"), filters=(Notch(f("9"), f("0"), f("1")), LowPass(f("50")))
    )
    found = cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), drive, {"K": 30.0}, "file")
    assert (found.Kv, found.Tn, found.tuned_gains) == (30.0, 0.02, ("Kp",)) and np.isnan(found.Kp)
    names = ["dead time", "period", "lag of the current loop", "notch at 9 Hz", "low-pass filter at 50 Hz"]
    assert [one.name for one in found.path] == names
    assert isinstance(found.path[0], DeadTime) and found.path[0].time == 1e-4, "a period where none is given"


def test_values_of_parameters_that_no_drive_has_are_refused() -> None:
    with pytest.raises(InputError, match=r"file: drives, m, Kv: -3 is not above zero"):
        cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), Drive(Formula.parse("K"), TUNED), {"K": -3.0}, "file")


def test_the_set_point_is_followed_at_once_by_its_velocity() -> None:
    """With kfv = 1 the torque of a set point is that of a motion: C (Kv + s)."""
    one, s = Cascade("m", 30.0, 5.0, 0.02, ELEMENTS), laplace(np.array([3.0]))
    assert np.allclose(one.forward(s), one.controller(s) * (30 + s))


@pytest.mark.parametrize(
    ("one", "poles"), [(LowPass(Formula.parse(40)), [1]), (LowPass(Formula.parse(40), 2), [1, 2**0.5, 1])]
)
def test_filters_of_the_set_point_are_in_what_is_followed(one: LowPass, poles: list[float]) -> None:
    """1/polynomial of s/w; behind by its first derivative at rest."""
    f, s = Formula.parse, laplace(np.array([3.0, 50.0]))
    filtered = cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), Drive(f(30), f(5), set_point=one), {}, "file")
    expected = 1 / np.polyval(poles if len(poles) > 1 else [1, 1], s / (2 * np.pi * 40))
    assert np.allclose(
        filtered.forward(s),
        expected * cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), Drive(f(30), f(5)), {}, "file").forward(s),
    )
    assert filtered.set_point_delay == pytest.approx((2**0.5 if one.order == 2 else 1) / (2 * np.pi * 40))


def test_a_moving_average_is_a_mean_of_whole_periods() -> None:
    f, s = Formula.parse, laplace(np.array([3.0, 50.0]))
    drive = Drive(f(30), f(5), period=f(1e-3), set_point=Average(f("4e-3")))
    found = cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), drive, {}, "file").set_point
    assert found is not None and found.time == pytest.approx(1.5e-3)
    assert np.allclose(found.at(s), (1 - np.exp(-4e-3 * s)) / (1 - np.exp(-1e-3 * s)) / 4)
    wrong = replace(drive, set_point=Average(f("2.6e-3")))
    with pytest.raises(InputError, match=r"m, set_point, average: 0.0026 s is no whole number .* give 0.003"):
        cascade_of(Joint("m", 0, Kind.MOTOR, 0, "q1"), wrong, {}, "file")
