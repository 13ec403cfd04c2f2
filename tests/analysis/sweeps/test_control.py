"""Sweeps over what drives make of a machine, and shares of points within ranges with their intervals."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps.sweep import ALL, interval_of
from symoro_elastic.foundation.errors import InputError

pytest.importorskip("scipy.stats")

AXIS: dict[str, Any] = {
    "name": "axis",
    "gravity": [0, 0, 0],
    "joints": [
        {"name": "motor", "kind": "motor", "sigma": 1, "r": "x"},
        {"name": "table", "antecedent": "motor", "kind": "elastic", "sigma": 1, "r": "y"},
    ],
    "parameters": {"TD": {"value": 4e-4, "unit": "s"}, "KP": 4000.0},
    "bodies": {"motor": {"mass": 20}, "table": {"mass": 60}},
    "springs": {"table": {"stiffness": 2e7, "damping": 2e3}},
    "drives": {"motor": {"Kp": "KP", "Kv": 20, "Tn": 0.05, "current": {"lag": 2e-4}, "dead_time": "TD"}},
}
TUNED = {**AXIS, "drives": {"motor": {**AXIS["drives"]["motor"], "Kp": "tuned", "Kv": "tuned", "Tn": "tuned"}}}
SPREAD = {"TD": "2e-4:1.2e-3", "table.stiffness": "lognormal:2e7:0.3", "table.damping": "500:4000"}


@pytest.mark.thorough
def test_a_point_is_what_control_says_of_that_machine() -> None:
    over = {"TD": [3e-4, 8e-4], "table.stiffness": [1e7, 3e7]}
    found = se.sweep(AXIS, over=over, of="control", outputs=["table.z"])
    for k, (dead, stiffness) in enumerate(found.points):
        there = se.control(AXIS, values={"TD": dead, "table.stiffness": stiffness}, compliances=["table.z"])
        (place,) = there.places
        (axis,) = place.axes
        wanted = {
            "motor: velocity_modulus": axis.velocity.modulus,
            "motor: position_phase": axis.position.phase,
            "motor: velocity_gain": axis.velocity.gain,
            "motor: bandwidth": axis.bandwidth,
            "motor: behind": axis.velocity_error,
            "motor: largest_Kp": axis.limits[0].largest.gain if axis.limits[0].largest else 0,
            "motor: largest_Kv": axis.limits[1].largest.gain if axis.limits[1].largest else 0,
            "table.z: peak": place.compliances[0].peak,
            "growth": place.growth,
        }
        assert {name: found.figures[name][k] for name in wanted} == pytest.approx(wanted, rel=1e-9, abs=1e-12)
    assert found.units["motor: bandwidth"] == "Hz" and found.units["motor: velocity_phase"] == "deg"


ELECTRIC: dict[str, Any] = {
    **AXIS,
    "parameters": {"TD": 4e-4, "KP": 4000.0, "KT": 80.0},
    "motors": {"motor": {"resistance": 0.8, "inductance": 3e-3, "torque_constant": "KT", "back_emf": 70}},
    "drives": {
        "motor": {
            **AXIS["drives"]["motor"],
            "current": {"kp": 9, "ti": 4e-3, "compensation": 0.5},
            "filters": [{"notch": 150, "depth": 0.1, "width": 0.6}, {"lowpass": 800}],
            "set_point": {"lowpass": 60},
            "limits": {"torque": 9000, "windup": 0.1, "voltage": 400},
            "feed_forward": {"velocity": 0.9, "acceleration": 60},
        }
    },
}
PLACES = {
    "Kv": ("Kv",),
    "Tn": ("Tn",),
    "current.kp": ("current", "kp"),
    "current.ti": ("current", "ti"),
    "current.compensation": ("current", "compensation"),
    "filter_1.frequency": ("filters", 0, "notch"),
    "filter_1.width": ("filters", 0, "width"),
    "filter_2.frequency": ("filters", 1, "lowpass"),
    "set_point.frequency": ("set_point", "lowpass"),
    "velocity_forward": ("feed_forward", "velocity"),
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*PLACES, "resistance", "inductance", "back_emf"])
def test_each_number_of_a_drive_is_swept_as_its_file_would_have_it(name: str) -> None:
    """By its place in the drive, or in the winding; as a sweep, and as a value."""
    written = copy.deepcopy(ELECTRIC)
    *path, last = ("drives", "motor", *PLACES[name]) if name in PLACES else ("motors", "motor", name)
    owner = written
    for key in path:
        owner = owner[key]
    owner[last] *= 1.1
    key = f"motor.{name}"
    found = se.sweep(ELECTRIC, over={key: [owner[last]]}, of="control")
    there = se.sweep(written, over={"TD": [4e-4]}, of="control")
    before = se.sweep(ELECTRIC, over={"TD": [4e-4]}, of="control")
    assert found.figures.keys() == there.figures.keys()
    for figure, x in there.figures.items():
        np.testing.assert_allclose(found.figures[figure], x, rtol=1e-12)
    assert any(x != before.figures[figure] for figure, x in found.figures.items())
    (axis,), (other,) = (
        one.places[0].axes for one in (se.control(ELECTRIC, values={key: owner[last]}), se.control(written))
    )
    assert axis.position.modulus == pytest.approx(other.position.modulus, rel=1e-12)


@pytest.mark.thorough
def test_what_a_drive_has_not_as_a_number_is_refused_by_name() -> None:
    for name, what in (
        ("motor.Kp", "it is KP: name KP in its place"),
        ("motor.dead_time", "it is TD: name TD in its place"),
        ("motor.lag", "it is 0, so the drive has no such part"),
        ("motor.period", "the drive has no such part"),
        ("motor.torque_forward", "it is False, no number"),
        ("motor.measured", "it is motor, no number"),
        ("motor.Kx", "no parameter, number of the table"),
    ):
        with pytest.raises(InputError) as error:
            se.sweep(ELECTRIC, over={name: [1.0, 2.0]}, of="control")
        assert what in str(error.value), name
    for name in ("motor.Kv", "KP", "KT", "motor.resistance"):
        with pytest.raises(InputError, match=f"{name} belongs to drives, on which modes does not depend"):
            se.sweep(ELECTRIC, over={name: [1.0, 2.0]}, of="modes")
    wrong = se.sweep(ELECTRIC, over={"motor.Kv": [-1.0, 20.0]}, of="control")
    assert "drives, motor, Kv: -1 is not above zero" in wrong.reasons[0]
    with pytest.raises(InputError, match="drives, motor, Tn: 0 is not above zero"):
        se.control(ELECTRIC, values={"motor.Tn": 0.0})


@pytest.mark.thorough
def test_slopes_of_a_largest_gain_are_those_that_control_names() -> None:
    """Dead time and stiffness, by per cent; in a sweep by central differences of 0.2 %."""
    given = se.control(AXIS).places[0].axes[0].limits[0].influences
    for key, name, value in (("TD", "dead time", 4e-4), ("table.stiffness", "table.stiffness", 2e7)):
        near = [x * value for x in (0.999, 1, 1.001)]
        found = se.sweep(AXIS, over={key: near}, of="control", results=["motor: largest_Kp"])
        gains = found.figures["motor: largest_Kp"]
        assert np.log(gains[2] / gains[0]) / np.log(near[2] / near[0]) == pytest.approx(given[name], rel=1e-4, abs=1e-6)


@pytest.mark.thorough
def test_gains_to_tune_are_found_once_for_the_machine_as_given() -> None:
    found = se.sweep(TUNED, over={"TD": [2e-4, 4e-4, 8e-4]}, of="control")
    modulus = found.figures["motor: position_modulus"]
    assert modulus[1] == pytest.approx(0.7, rel=1e-4) and modulus[0] > 0.71 and modulus[2] < 0.69


def test_margins_of_unstable_loops_are_nothing() -> None:
    found = se.sweep(AXIS, over={"KP": [4e3, 4e5]}, of="control", require={"*_modulus": (0.2, np.inf)})
    assert found.figures["growth"][0] < 0 < found.figures["growth"][1]
    names = [name for name in found.figures if "_modulus" in name or "_phase" in name]
    assert len(names) == 4
    assert all(found.figures[name][0] > 0 and found.figures[name][1] == 0 for name in names)
    assert [(one.name, one.within, one.interval) for one in found.shares][-1] == (ALL, 1, None)


def test_points_without_result_are_not_within() -> None:
    found = se.sweep(AXIS, over={"table.stiffness": [-1.0, 2e7]}, of="control", require={"growth": (-np.inf, 0)})
    (one,) = found.shares
    assert (one.within, one.points) == (1, 2)
    assert any("1 of 2" in str(part) or "50.0%" in str(part) for part in found.parts())


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"require": {"motor: modulus": (0, 1)}}, "no result"),
        ({"require": {"growth": (1, 0)}}, "is not (low, high)"),
        ({"require": {"growth": 3.0}}, "is not (low, high)"),
        ({"hold": ["motor"]}, "leave out all but at"),
        ({"inputs": ["motor.tau"]}, "belongs to of response"),
        ({"outputs": ["table.vz"]}, "is no position"),
    ],
)
def test_what_does_not_fit_is_refused(options: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError) as error:
        se.sweep(AXIS, over={"TD": [1e-4, 2e-4]}, of="control", **options)
    assert what in str(error.value)


def test_a_machine_without_drives_is_refused() -> None:
    with pytest.raises(InputError, match="no motor has one"):
        se.sweep({name: x for name, x in AXIS.items() if name != "drives"}, over={"KP": [1.0]}, of="control")


@pytest.mark.sampled(2)
@pytest.mark.parametrize("sampling", ["random", "latin"])
def test_intervals_hold_the_share_of_all_draws(sampling: str) -> None:
    """Of 300 samples of 40 unseen draws each, at three shares that are known: at least as many as are promised."""
    from symoro_elastic.analysis.sweeps.design import design
    from symoro_elastic.analysis.sweeps.ranges import Uniform
    from symoro_elastic.analysis.sweeps.sweep import shares

    axes = {name: Uniform(0, 1) for name in ("a", "b")}
    for share in (0.5, 0.9, 0.99):
        # P(a b <= x) = x - x ln x
        bound = next(float(x) for x in np.linspace(0, 1, 20_001)[1:] if x - x * np.log(x) >= share)
        held = 0
        for seed in range(300):
            drawn = design(axes, 40, sampling, seed)
            figures = {"product": drawn.points[:, 0] * drawn.points[:, 1]}
            (one,) = shares(drawn, figures, {"product": (-np.inf, bound)})
            assert one.interval and one.interval[0] <= one.share <= one.interval[1]
            held += one.interval[0] <= share <= one.interval[1]
        assert held >= 0.95 * 300 - 2 * np.sqrt(300 * 0.95 * 0.05)


def test_an_interval_is_the_published_one() -> None:
    """Clopper and Pearson: no failure of 59 draws is the rule of 95 % at 95 % on one side, 1 - 0.025^(1/n) on two."""
    assert interval_of(59, 59) == pytest.approx((0.025 ** (1 / 59), 1.0))
    assert interval_of(0, 10) == pytest.approx((0.0, 1 - 0.025**0.1))


@pytest.mark.thorough
def test_the_share_of_unseen_draws_is_within_the_interval() -> None:
    """Phase margins of the axis over stiffness, damping and dead time: 60 draws, and 120 others."""
    required = {"motor: position_modulus": (0.68, np.inf), "motor: velocity_modulus": (0.35, np.inf)}
    few, many = (
        se.sweep(TUNED, over=SPREAD, of="control", samples=n, sampling="random", seed=seed, require=required).shares
        for n, seed in ((60, 1), (120, 2))
    )
    for seen, unseen in zip(few, many, strict=True):
        assert seen.interval and unseen.interval
        assert 0 < unseen.share < 1
        assert seen.interval[0] <= unseen.interval[1] and unseen.interval[0] <= seen.interval[1]
