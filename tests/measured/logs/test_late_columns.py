"""Columns of a log that lag the others by whole samples are named, moved back, and change no estimate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("scipy")

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.measured.logs.identify import LogSettings, identify
from symoro_elastic.measured.logs.late_columns import Late, moved_back
from symoro_elastic.measured.logs.result import Identification
from tests.benchmarks import logs
from tests.benchmarks.sensors import Sensing, three_axis

ARM = three_axis()


def lagging(record: Measurements, quantity: str, place: int, samples: int) -> Measurements:
    """A record one of whose columns is late, as of a buffered channel."""
    blocks = {name: x.copy() for name in ("q", "qd", "tau") if (x := getattr(record, name)) is not None}
    blocks[quantity][samples:, place] = blocks[quantity][:-samples, place]
    return replace(record, t=record.t[samples:], **{name: x[samples:] for name, x in blocks.items()})


def found(record: Measurements, **options: str) -> Identification:
    return identify(ARM.machine, record, LogSettings(**options), Y=ARM.regressor)  # type: ignore[arg-type]


def said(one: Identification) -> list[str]:
    return [note for note in one.notes if "buffered channel" in note]


def errors(one: Identification) -> Array:
    return np.array([(e.value - e.unknown.nominal) / e.std for e in one.estimates if np.isfinite(e.unknown.nominal)])


@pytest.mark.thorough
@pytest.mark.parametrize(("quantity", "place", "samples"), [("q", 0, 1), ("tau", 1, 3), ("q", 2, 10)])
def test_a_late_column_is_named_and_moved_back(quantity: str, place: int, samples: int) -> None:
    """What is found is that of the same record in time, but for the samples that are lost."""
    record = ARM.record(Sensing(), 3)
    late, right = found(lagging(record, quantity, place, samples)), found(record)
    (line,), name = said(late), ARM.machine.independent_joints[place].name
    assert line.startswith(
        f"{quantity}_{name} is {samples} sample{'s' if samples > 1 else ''} late relative to the other"
    )
    assert late.delay == 0.0 and np.abs(errors(late)).max() < 4
    for one, other in zip(late.estimates, right.estimates, strict=True):
        assert abs(one.value - other.value) < 2 * other.std


def two_axis(seed: int, late: tuple[float, float], torques: float = 0.0) -> Identification:
    """Return what is identified from a log of two axes whose positions are late by samples, torques by seconds."""
    draw = logs.Draw(seed, torques)
    q = np.stack([draw.motion.at(draw.t - x / logs.RATE)[0][:, k] for k, x in enumerate(late)], axis=1)
    record = replace(draw.record(), q=np.round(q / logs.STEP) * logs.STEP)
    return logs.Case(lambda _: record).identified(seed)


def scores(result: Identification) -> Array:
    return np.array([z for z, _ in logs.deviations(result, logs.truth_of(logs.CASES["plain"])).values()])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("late", "torques", "seed"),
    [
        *(pytest.param((5.0, 0.0), 0.0, seed, marks=[pytest.mark.thorough] * (seed > 1)) for seed in range(1, 6)),
        ((0.0, 5.0), 0.0, 1),
        pytest.param((12.0, 0.0), 0.006, 0, marks=pytest.mark.thorough),
        pytest.param((5.0, 3.0), 0.0, 1, marks=pytest.mark.thorough),
    ],
)
def test_a_late_column_of_two_joints_is_no_delay_of_all_torques(
    late: tuple[float, float], torques: float, seed: int
) -> None:
    """Both explain most of the residuals; before, values were off by up to 80 % and called identified."""
    result = two_axis(seed, late, torques)
    assert len(said(result)) == 1 and "shifted back" in said(result)[0]
    assert np.abs(scores(result)).max() < 4


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("late", "torques"), [((2.5, 0.0), 0.0), pytest.param((0.0, 0.4), 0.006, marks=pytest.mark.thorough)]
)
def test_a_column_that_is_late_by_a_fraction_of_a_sample_widens_standard_deviations(
    late: tuple[float, float], torques: float
) -> None:
    result = two_axis(1, late, torques)
    (line,) = said(result)
    assert line.endswith("not shifted: standard deviations include this")
    assert np.abs(scores(result)).max() < 4


@pytest.mark.thorough
def test_positions_that_are_all_late_are_no_late_column() -> None:
    result = two_axis(0, (5.0, 5.0))
    assert not said(result) and [line for line in result.notes if line.startswith("positions are 19.9")]
    assert result.delay == pytest.approx(-0.02, abs=3e-4) and np.abs(scores(result)).max() < 4


@pytest.mark.thorough
def test_a_late_velocity_is_named_without_a_model() -> None:
    record = ARM.record(Sensing(20), 4)
    period = record.period
    with_rates = replace(record, qd=np.gradient(record.q, period, axis=0))
    (line,) = said(found(lagging(with_rates, "qd", 1, 4)))
    assert line.startswith("qd_lift is 4 samples late")
    assert said(found(with_rates)) == []


@pytest.mark.thorough
@pytest.mark.parametrize("sensing", [Sensing(), Sensing(late=3, offset=True), Sensing(12), Sensing(spikes=0.03)])
def test_right_columns_are_not_accused(sensing: Sensing) -> None:
    """A delay of all torques, coarse encoders and spikes are of no single column."""
    assert said(found(ARM.record(sensing, 5))) == []


@pytest.mark.thorough
def test_nothing_is_moved_where_no_delay_is_sought() -> None:
    assert said(found(lagging(ARM.record(Sensing(), 3), "q", 0, 3), delay="never")) == []


def test_columns_are_moved_by_samples() -> None:
    t = np.arange(8.0)
    record = Measurements(t, np.stack([t, t], axis=1), t[:, None])
    late = moved_back(record, [Late(("q",), 1, 2.1), Late(("tau",), 0, -1.0)])
    assert late.q[:, 0].tolist() == [1, 2, 3, 4, 5] and late.q[:, 1].tolist() == [3, 4, 5, 6, 7]
    assert late.tau[:, 0].tolist() == [0, 1, 2, 3, 4] and late.t.tolist() == [1, 2, 3, 4, 5]
