"""Figures of sweeps: those of the analyses at each point, what quantities do to them, and points without result."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps.design import design
from symoro_elastic.analysis.sweeps.ranges import axis
from symoro_elastic.analysis.sweeps.sweep import local_slopes
from symoro_elastic.foundation.errors import InputError
from tests.analysis.ladder.scenes import two_axis
from tests.analysis.sweeps.machines import DAMPING, MASS, SLIDE, STIFFNESS, hertz, squared, value


def test_frequencies_are_those_of_the_closed_form() -> None:
    found = se.sweep(SLIDE, over={"m": [1, 2, 4], "load.stiffness": "1e4:1e6:3,log"}, hold=["all"])
    expected = [hertz(m, k) for m in (1, 2, 4) for k in (1e4, 1e5, 1e6)]
    assert found.figures["frequency_1"] == pytest.approx(expected, rel=1e-14)
    ratios = [DAMPING / (2 * math.sqrt(m * k)) for m in (1, 2, 4) for k in (1e4, 1e5, 1e6)]
    assert found.figures["damping_ratio_1"] == pytest.approx(ratios, rel=1e-12)
    assert found.units["frequency_1"] == "Hz" and found.units["m"] == "kg" and found.units["load.stiffness"] == "N/m"


def test_every_point_is_what_modes_gives_there() -> None:
    """To the last bit, though the machine is traced once: of cells, parameters and positions, as in .par files too."""
    over = {"ram.k": [1e6, 3e7], "L12": [0.3], "q.motor_y": [0.1, 0.2]}
    found = se.sweep(two_axis(), over=over, hold=["all"])
    for row, f in zip(found.points.tolist(), found.figures["frequency_3"], strict=True):
        values = {"ram.stiffness": row[0], "L12": row[1]}
        here = se.modes(two_axis(), values=values, at={"motor_y": row[2]}, hold=["all"])
        assert here.frequencies[2] == f


def test_names_of_one_quantity() -> None:
    """TOML's and .par's name of a cell, a joint, its variable, and its position with a prefix."""
    of_toml, of_par = (
        se.sweep(SLIDE, over={name: [1e4, 1e5]}, hold=["all"]).figures["frequency_1"]
        for name in ("load.stiffness", "load.k")
    )
    assert (of_toml == of_par).all()
    for name in ("drive", "q.drive", "x"):
        found = se.sweep(SLIDE, over={name: [0.0, 0.5]}, of=lambda machine, at: {"seen": at["drive"]})
        assert found.figures["seen"].tolist() == [0.0, 0.5]


def test_a_response_has_the_peak_of_the_closed_form() -> None:
    found = se.sweep(
        SLIDE, over={"load.damping": [20.0, 40.0]}, of="response", hold=["all"],
        inputs=["load.fx", "load.fz"], outputs=["load.z"], frequencies=[5.0],
    )  # fmt: skip
    omega = math.sqrt(STIFFNESS / MASS)
    for k, d in enumerate((20.0, 40.0)):
        zeta = d / (2 * math.sqrt(STIFFNESS * MASS))
        peak = 1 / (STIFFNESS * 2 * zeta * math.sqrt(1 - zeta**2))
        at_five = 1 / abs(STIFFNESS - MASS * (10 * math.pi) ** 2 + 10j * math.pi * d)
        a = 1 - 2 * zeta**2
        edge = omega * math.sqrt(a + math.sqrt(a * a + 1)) / (2 * math.pi)
        name = "load.z / load.fz"
        assert found.figures[f"{name}: peak"][k] == pytest.approx(peak, rel=1e-12)
        assert found.figures[f"{name}: peak_frequency"][k] == pytest.approx(hertz() * math.sqrt(a), rel=1e-6)
        assert found.figures[f"{name}: bandwidth"][k] == pytest.approx(edge, rel=1e-9)
        assert found.figures[f"{name}: at 5 Hz"][k] == pytest.approx(at_five, rel=1e-12)
    assert found.units["load.z / load.fz: peak"] == "m / N"
    assert found.figures["load.z / load.fx: peak"].tolist() == [0.0, 0.0]
    assert np.isnan(found.figures["load.z / load.fx: peak_frequency"]).all()


def test_points_that_fail_have_a_reason_and_the_sweep_goes_on() -> None:
    found = se.sweep(SLIDE, over={"m": [0.25, 0.5, 2.0]}, of=lambda machine: {"inverse": 1 / (value(machine) - 0.5)})
    assert found.reasons[1] == "ZeroDivisionError: float division by zero" and found.failures == 1
    assert np.isnan(found.figures["inverse"][1]) and found.figures["inverse"][2] == 1 / 1.5
    negative = se.sweep(SLIDE, over={"load.k": [-1.0, 1e4]}, hold=["all"])
    assert negative.reasons == ("load.k is negative: -1", "")
    assert "1 of 2 points have no result" in str(negative.parts())


@pytest.mark.parametrize("of", ["modes", squared])
@pytest.mark.parametrize(
    ("mass", "inertia", "said"),
    [
        ("m", [0, 0, 0], "m is negative: -1"),
        ("2*m", [0, 0, 0], "load.mass: is negative: -2 by m = -1"),
        (1, ["m", "m", "m"], "m is negative: -1"),
    ],
)
def test_a_negative_mass_by_a_parameter_has_a_reason(of: Any, mass: Any, inertia: list[Any], said: str) -> None:
    """A mass that moves others along is never alone in the inertia matrix: this one is seen where it stands."""
    bodies = {"drive": {"mass": 10.0}, "load": {"mass": mass, "inertia": inertia}}
    machine = {**SLIDE, "bodies": bodies, "parameters": {"m": 2.0}}
    found = se.sweep(machine, over={"m": [-1.0, 1.0]}, of=of)
    assert found.reasons == (said, "")


def test_a_negative_value_is_refused_by_all_that_take_values() -> None:
    for call in (se.modes, se.feed_forward):
        with pytest.raises(InputError, match=r"load.mass: is negative: -1 by m = -1"):
            call(SLIDE, values={"m": -1.0})
    with pytest.raises(InputError, match=r"load.stiffness: is negative: -5 by load.stiffness = -5"):
        se.modes(SLIDE, values={"load.stiffness": -5.0})


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda machine: [1.0], "the function returns list"),
        (lambda machine: {"a": "b"}, "is not a number by name"),
        (lambda machine: {}, "no result has a value"),
        (lambda machine: {"m": 1.0}, "'m' is a column already"),
    ],
)
def test_functions_return_numbers_by_name(function: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        se.sweep(SLIDE, over={"m": [1.0]}, of=function)  # type: ignore[arg-type]


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"over": {"load.stifness": [1]}}, "did you mean 'load.stiffness'?"),
        ({"over": {"load.gamma": [1]}}, "are part of the structure of a machine"),
        ({"over": {"load.k": [1], "load.stiffness": [2]}}, "are the same quantity"),
        ({"over": {"drive": [1], "q.drive": [2]}}, "are the same quantity"),
        ({"over": {"load": [0.0]}}, "load is not held"),
        ({"over": {"m": [1]}, "of": "speed"}, "unknown 'speed'"),
        ({"over": {"m": [1]}, "of": "ladder", "hold": ["all"]}, "belongs to modes and response"),
        ({"over": {"m": [1]}, "outputs": ["load.z"]}, "outputs: belongs to"),
        ({"over": {"m": [1]}, "of": "simulation"}, "motion"),
        ({"over": {"m": [1]}, "hold": ["nope"]}, "no moving joint 'nope'"),
        ({"over": {"drive": [1]}, "of": squared}, "give it a second one"),
        ({"over": {"m": [1]}, "results": ["frequncy_1"]}, "did you mean 'frequency_1'?"),
        ({"over": {"m": [1]}, "workers": -2}, "workers: -2"),
        ({"over": {"m": [1]}, "workers": 2, "scheduler": "tcp://a:1"}, "leave out workers or scheduler"),
        ({"over": "m"}, "over: 'm' gives no values by name"),
        ({"over": {3: [1, 2]}}, "gives no values by name"),
        ({"over": {"m": [1]}, "of": "response", "damping": math.nan}, "damping: nan is not a damping ratio"),
        ({"over": {"m": [1]}, "of": "response", "frequencies": [math.nan]}, "frequencies: nan is not a frequency"),
        (
            {"over": {"m": [1]}, "of": "response", "frequencies": [-3]},
            "frequencies: -3 is not a frequency: give numbers",
        ),
        ({"over": {"m": [1]}, "of": "response", "frequencies": [3, 3.0]}, "frequencies: 3 Hz is given twice"),
        ({"over": {"m": [1]}, "at": {"nope": 1.0}}, "at: no moving joint 'nope'"),
        ({"over": {"m": [1]}, "at": {"drive": math.inf}}, "at: drive=inf is out of range"),
        ({"over": {"m": [1]}, "values": {"m": 3.0}}, "values: m is swept: remove one of the two"),
        ({"over": {"load.k": [1]}, "values": {"load.stiffness": 3.0}}, "values: load.stiffness is swept"),
        ({"over": {"q.drive": [1]}, "at": {"x": 3.0}}, "at: x is swept: remove one of the two"),
        ({"over": {"load.k": [-1.0]}}, "the point without a result; the first: load.k is negative: -1"),
    ],
)
def test_what_cannot_be_swept_is_refused(arguments: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as error:
        se.sweep(SLIDE, **arguments)  # type: ignore[arg-type]
    assert said in str(error.value) and "\n" not in str(error.value)


def test_slopes_of_a_grid_and_ranks_of_a_sample() -> None:
    """f = sqrt(k/m)/2 pi: half a per cent by a per cent of k, minus half by one of m, on any grid.

    A position that is 0 somewhere has no per cent, nor has a quantity of one value.
    """
    over: dict[str, Any] = {"m": "1:9:3", "load.k": "1e4:1e6:4,log", "drive": [0.0, 1.0], "load.damping": [40.0]}
    grid = se.sweep(SLIDE, over=over, hold=["all"], results=["frequency_1"]).influence
    assert grid.slopes is not None
    assert grid.slopes[0, :2] == pytest.approx([-0.5, 0.5], abs=1e-12)
    assert np.isnan(grid.slopes[0, 2:]).all()
    assert np.sign(grid.values[0, :3]).tolist() == [-1.0, 1.0, 0.0]
    over = {"m": "normal:2:0.001", "load.k": "lognormal:8e4:0.1", "drive": "0:1"}
    sample = se.sweep(SLIDE, over=over, samples=60, hold=["all"], results=["frequency_1"]).influence
    assert sample.slopes is None and sample.values[0, 1] > 0.99
    assert sample.strongest()[0] == 1 and abs(sample.values[0, [0, 2]]).max() < 0.4


def test_slopes_where_a_figure_has_no_logarithm() -> None:
    """A cube that changes its sign: 3 where it and its neighbours have one sign; a position below zero counts too."""
    points = design({"x": axis("x", [4.0, 1.0, 2.0, 8.0, 16.0])})
    x = points.points[:, 0]
    figures = [x**3, -(x**3), np.where(x > 4, -(x**3), x**3), np.where(x == 16, np.nan, x**3), np.where(x > 2, 0, x**3)]
    nan = math.nan
    expected = [[3] * 5, [3] * 5, [nan, 3, 3, nan, 3], [3, 3, 3, nan, nan], [nan, 3, nan, nan, nan]]
    for figure, slopes in zip(figures, expected, strict=True):
        assert local_slopes(points, figure, 0) == pytest.approx(slopes, abs=1e-12, nan_ok=True)
    below = design({"x": axis("x", [-1.0, -2.0, -4.0])})
    assert local_slopes(below, below.points[:, 0] ** 2, 0) == pytest.approx([2.0] * 3, abs=1e-12)


@pytest.mark.thorough
def test_forms_of_a_result(tmp_path: Path) -> None:
    pd, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    found = se.sweep(
        SLIDE, over={"m": [0.5, 2.0], "load.k": "1e4:1e5:3"}, of=lambda machine: {"a/b": 1 / (value(machine) - 0.5)}
    )
    frame = found.to_frame()
    assert list(frame.columns) == ["m", "load.k", "a/b", "reason"] and len(frame) == 6
    read = pd.read_csv(found.write(tmp_path / "a.csv"), keep_default_na=False, na_values=["nan"])
    assert list(read.columns) == ["m [kg]", "load.k [N/m]", "a/b", "reason"]
    assert np.array_equal(read["a/b"], found.figures["a/b"], equal_nan=True)
    with xarray.open_dataset(found.write(tmp_path / "a.nc")) as data:
        assert data["aoverb"].dims == ("m", "load.k") and data["m"].attrs["units"] == "kg"
        assert np.array_equal(data["aoverb"], found.on_grid("a/b"), equal_nan=True)
        assert data["reason"].values[0, 0].decode().startswith("ZeroDivisionError")
    with np.load(found.write(tmp_path / "a.npz")) as arrays:
        assert np.array_equal(arrays["a/b"], found.figures["a/b"], equal_nan=True)
    assert found.as_json()["figures"]["a/b"][0] is None


@pytest.mark.thorough
def test_simulations_start_where_they_are_swept() -> None:
    """The final position moves along with the start, and is that of `simulate`."""
    machine = {
        **SLIDE,
        "motion": {"duration": 0.05, "moves": [{"motor": "drive", "by": 0.02, "in": 0.05}]},
        "wanted": {"tolerance": {"load.z": 1e-3}},
    }
    found = se.sweep(machine, over={"drive": [0.0, 0.5]}, of="simulation", method="w3", step=1e-3)
    final = found.figures["load.z: final"]
    assert final[1] - final[0] == pytest.approx(0.5, abs=1e-12) and found.units["load.z: final"] == "m"
    (one,) = se.simulate(se.read(machine), method="w3", step=1e-3)
    assert final[0] == float(one.outputs[-1, 0]) and 0 < abs(final[0] - 0.02) < 1e-3
