"""Ring-downs: the poles that made them, standard deviations that hold on unseen noise, and refusals."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.vibration_tests.measured import MeasuredModes
from symoro_elastic.measured.vibration_tests.ring_downs import modes_of_ring_down
from tests.benchmarks.ring_downs import EVERYWHERE, TRUE, ring_down
from tests.measured.vibration_tests.files import LIST, listed, write_csv

T = np.arange(800) / 500


def test_without_noise_the_poles_are_exact() -> None:
    """Frequencies, damping ratios and shapes, two modes close to each other."""
    signals, shapes = ring_down(T, 0.0, 0)
    found, notes = modes_of_ring_down(T, signals, EVERYWHERE, "x")
    assert notes == [] and len(found.f) == len(TRUE)
    assert np.allclose(found.f, TRUE[:, 0], rtol=1e-9) and np.allclose(found.zeta, TRUE[:, 1], rtol=1e-7)
    assert np.allclose(found.shapes[:, 1] / found.shapes[:, 0], shapes[1] / shapes[0], rtol=1e-6)


def test_a_file_is_read_as_modes(tmp_path: Path) -> None:
    signals, _ = ring_down(T, 0.01, 1)
    columns = {"t [ms]": 1e3 * T, "-tool.ax [g]": -signals["a"] / 9.80665, "motor_x.q": signals["b"]}
    write_csv(tmp_path / "m.csv", columns)
    tests = listed(tmp_path, LIST + "band = [10, 50]\n")
    modes = tests.tests[0].modes
    assert modes.outputs == ("tool.ax", "motor_x.q") and modes.shapes.shape == (3, 2)
    whole, _ = modes_of_ring_down(T, signals, EVERYWHERE, "x")
    assert np.allclose(modes.f, whole.f[:3], rtol=1e-7) and np.allclose(modes.zeta, whole.zeta[:3], rtol=1e-5)


def test_a_sample_that_stands_out_is_no_mode() -> None:
    """The first one of the first signal, which a pole above half of the sampling rate explains."""
    signals, _ = ring_down(T, 0.01, 2)
    signals["a"][0] += 10
    modes, (note,) = modes_of_ring_down(T, signals, EVERYWHERE, "x")
    assert note.endswith("Hz is above half of the sampling rate, as samples that stand out are: it is left out")
    assert np.allclose(modes.f, TRUE[:, 0], rtol=0.01)


def test_modes_that_do_not_decay_are_left_out_and_said() -> None:
    signals, _ = ring_down(T, 0.01, 2)
    hum = {name: x + 0.2 * np.sin(2 * np.pi * 50 * T) for name, x in signals.items()}
    found, (note,) = modes_of_ring_down(T, hum, EVERYWHERE, "x")
    assert len(found.f) == len(TRUE)
    assert note.endswith("Hz does not decay in the record, as what is driven does not: it is left out")


@pytest.mark.parametrize("share", [0.4, 0.6])
def test_a_ring_down_beyond_the_range_of_its_sensor_is_used_from_where_it_is_within(share: float) -> None:
    """Clipped at this share below the largest value."""
    signals, _ = ring_down(T, 0.003, 4)
    cut = {
        name: np.clip(x, -(1 - share) * np.abs(x).max(), (1 - share) * np.abs(x).max()) for name, x in signals.items()
    }
    found, (note, *_) = modes_of_ring_down(T, cut, EVERYWHERE, "x")
    assert re.fullmatch(r"a(, b)?: largest values are repeated, .*: the first \d+ of 800 samples are left out", note)
    nearest = [int(np.abs(TRUE[:, 0] - f).argmin()) for f in found.f]
    assert (np.abs(found.f - TRUE[nearest, 0]) < 4.5 * found.std_f).all()
    assert (np.abs(found.zeta - TRUE[nearest, 1]) < 4.5 * found.std_zeta).all()


def refused(t: np.ndarray, band: tuple[float, float] = EVERYWHERE, **signals: np.ndarray) -> str:
    with pytest.raises(InputError) as error:
        found: tuple[MeasuredModes, list[str]] = modes_of_ring_down(t, signals, band, "m.csv")
        raise AssertionError(found)
    return str(error.value)


def test_what_is_no_ring_down_is_refused() -> None:
    rng = np.random.default_rng(0)
    signals, _ = ring_down(T, 0.01, 3)
    noise, gap, bad = rng.normal(size=len(T)), T + 0.01 * (T > 0.5), signals["a"] + np.where(T[7] == T, np.nan, 0)
    assert "t: no vibration is above the noise" in refused(T, a=noise)
    assert "50 Hz does not decay in the record" in refused(T, a=np.sin(2 * np.pi * 50 * T) + 0.01 * noise)
    assert "40 samples: 50 to 50000 are needed" in refused(T[:40], a=signals["a"][:40])
    assert "periods in the record" in refused(T, a=np.exp(-0.5 * T) * np.cos(2 * np.pi * 0.9 * T) + 0.001 * noise)
    assert "t: does not increase evenly" in refused(gap, a=signals["a"])
    assert "a: sample 8 is not a number" in refused(T, a=bad)
    assert "a: is constant" in refused(T, a=0 * T)
    assert "there is no signal but t" in refused(T)
    assert "no mode is within the band, 200 to 300 Hz" in refused(T, (200, 300), **signals)
