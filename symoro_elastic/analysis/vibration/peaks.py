"""Results of frequency responses: the peak and its frequency, the bandwidth, the magnitude at chosen frequencies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.analysis.vibration.responses import (
    Response,
    frequency_grid,
    frequency_response,
    quotient_unit,
    refuse_missing_signals,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import input_unit, output_unit

EDGE = 1 / np.sqrt(2)
"""Of the magnitude at 0 Hz, at the end of the bandwidth: -3 dB."""
EXACT = 1e-10
"""Relative error of a frequency that is refined."""


def response_figures(linear: Linearization, frequencies: Sequence[float] = ()) -> dict[str, float]:
    """Return metrics of the response of the outputs to each input: "tool.x / motor_x.tau: peak" ...

    `peak` is the largest maximum of the magnitude, that at 0 Hz included where it is finite (infinite on an undamped
    resonance, NaN where there is none), and `peak_frequency` its place, Hz, NaN where nothing moves. `bandwidth`, Hz,
    is where the magnitude first falls to 0.707 of that at 0 Hz: NaN where that is infinite or 0, infinite where it
    never does. `at f Hz` are magnitudes at `frequencies`. Raises `InputError` without input or output.
    """
    refuse_missing_signals(linear)
    poles, _ = damped_poles(linear)
    swinging = np.concatenate([np.abs(poles[poles.imag > 0]), poles.imag[poles.imag > 0]]) / (2 * np.pi)
    grid = np.unique(np.concatenate([frequency_grid(linear), swinging]))
    response = frequency_response(linear, np.array([0.0, *grid]))
    chosen = frequency_response(linear, np.array(frequencies, dtype=float)) if frequencies else None
    figures: dict[str, float] = {}
    for i, output in enumerate(linear.outputs):
        for j, source in enumerate(linear.inputs):
            pair = _Magnitude(linear, response, i, j)
            name = f"{output} / {source}"
            peak, place = pair.peak()
            figures |= {f"{name}: peak": peak, f"{name}: peak_frequency": place, f"{name}: bandwidth": pair.bandwidth()}
            for k, f in enumerate(frequencies):
                assert chosen is not None
                figures[f"{name}: at {f:g} Hz"] = float(np.abs(chosen.values[k, i, j]))
    return figures


def unit_of_figure(machine: Machine, figure: str) -> str:
    """Return the unit of a result by its name; empty for a pure number."""
    pair, _, kind = figure.rpartition(": ")
    output, _, source = pair.rpartition(" / ")
    if kind in ("peak_frequency", "bandwidth"):
        return "Hz"
    return quotient_unit(output_unit(machine, output), input_unit(machine, source))


class _Magnitude:
    """The magnitude of a response over frequencies."""

    def __init__(self, linear: Linearization, response: Response, i: int, j: int) -> None:
        self.linear, self.i, self.j = linear, i, j
        self.frequencies = response.frequencies
        self.values: Array = np.abs(response.values[:, i, j])

    def at(self, frequency: float) -> float:
        """Return the magnitude at a frequency, Hz."""
        s, linear = 2j * np.pi * frequency, self.linear
        moved = linear.displacements(np.array([s]), linear.F[:, [self.j]])[0, :, 0]
        row = linear.Cq[self.i] + s * linear.Cv[self.i] + s * s * linear.Ca[self.i]
        return float(abs(row @ moved))

    def peak(self) -> tuple[float, float]:
        """Return the largest magnitude and its frequency, Hz; NaN without a response."""
        if not self.values.any():
            return 0.0, np.nan
        infinite = np.flatnonzero(np.isnan(self.values[1:])) + 1
        if len(infinite):
            return np.inf, float(self.frequencies[infinite[0]])
        inside = self.values[1:-1]
        before = np.where(np.isnan(self.values[:-2]), np.inf, self.values[:-2])
        tops = np.flatnonzero((inside >= before) & (inside >= self.values[2:])) + 1
        tops = np.array([*tops, *([0] if self.values[0] >= self.values[1] else [])], dtype=int)
        if not len(tops):
            return np.nan, np.nan
        k = int(tops[np.argmax(self.values[tops])])
        return self._refine(k) if k else (float(self.values[0]), 0.0)

    def _refine(self, k: int) -> tuple[float, float]:
        """Return the maximum between the neighbours of a frequency, and its frequency."""
        low, high = self.frequencies[k - 1], self.frequencies[k + 1]
        search = for_vibrations("scipy.optimize").minimize_scalar
        best = search(lambda f: -self.at(f), bounds=(low, high), method="bounded", options={"xatol": EXACT * high})
        if -best.fun < self.values[k]:
            return float(self.values[k]), float(self.frequencies[k])
        return float(-best.fun), float(best.x)

    def bandwidth(self) -> float:
        """Return the first frequency, Hz, at which the magnitude falls to 0.707 of that at 0 Hz."""
        level = EDGE * self.values[0]
        if not level > 0:
            return np.nan
        below = np.flatnonzero(self.values < level)
        if not len(below):
            return np.inf
        low, high = self.frequencies[below[0] - 1], self.frequencies[below[0]]
        solve = for_vibrations("scipy.optimize").brentq
        return float(solve(lambda f: self.at(f) - level, low, high, xtol=EXACT * high))
