"""Frequency responses of a linearization: motor to encoder, motor to tool, force at the tool to tool.

G(s) = (Cq + s Cv + s^2 Ca) (s^2 M + s D + K)^-1 F,    s = 2 pi i f
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization, LinearSlopes, linear_slopes, response_slopes
from symoro_elastic.analysis.vibration.modes import damped_poles, modes
from symoro_elastic.analysis.vibration.zeros import PolesAndZeros
from symoro_elastic.foundation.array_types import Array, BoolArray, ComplexArray
from symoro_elastic.foundation.errors import InputError, refuse_numbers
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.motion.signals import input_unit, output_unit
from symoro_elastic.quantities.units import MICRO, in_micro

ON_RESONANCE = 1e-9
"""Relative distance to an undamped pole within which a response is a number without meaning."""
POINTS, MOST_POINTS = 2000, 200_000
LOWEST, HIGHEST = 1e-9, 1e12
"""Hz."""
BLOCK = 256


@dataclass(frozen=True)
class PointStiffness:
    """A point under a force along one direction: `static` compliance, `peak` of its response at `frequency`, Hz.

    SI units of `output` over `source`; NaN where motors are free, so that nothing holds the point. The peak is infinite
    where nothing damps it: `frequency` is that of the mode that moves the point most. `held_by` and `shaken_by` are
    shares of strain energy by spring, the largest first.
    """

    output: str
    source: str
    unit: str
    static: float
    held_by: dict[str, float]
    peak: float
    frequency: float
    shaken_by: dict[str, float]

    @property
    def stiffness(self) -> float:
        """Inverse of the static compliance."""
        return 1 / self.static if self.static else np.inf

    @property
    def stiffness_unit(self) -> str:
        """N/um, or N m/urad: 1e6 N/m and 1e6 N m/rad."""
        return "N/um" if self.unit.startswith("m ") else "N m/urad"

    @property
    def sentence(self) -> str:
        """Both compliances, with the springs that limit them."""
        sentence = f"{self.output} under {self.source}"
        if np.isfinite(self.static):
            sentence += f": {self.stiffness / MICRO:.4g} {self.stiffness_unit} at rest{_first(self.held_by)}"
        if not self.frequency > 0:
            return sentence if np.isfinite(self.static) else f"{sentence}: nothing holds it"
        if np.isinf(self.peak):
            return f"{sentence}; undamped resonance at {self.frequency:.4g} Hz{_first(self.shaken_by)}"
        factor, unit = in_micro(self.unit)
        peak = f"{factor * self.peak:.4g} {unit}{_first(self.shaken_by)}"
        return f"{sentence}; largest at {self.frequency:.4g} Hz, {peak}"


def _first(shares: dict[str, float]) -> str:
    return "".join(f", limited by {name} ({share:.0%} of the strain energy)" for name, share in [*shares.items()][:1])


@dataclass(frozen=True)
class ResponseSensitivity:
    """dG/dp (parameters, frequencies, outputs, inputs), SI units by the unit of the parameter; NaN where G is."""

    parameters: tuple[str, ...]
    values: Array
    slopes: ComplexArray
    responses: ComplexArray

    @property
    def relative(self) -> ComplexArray:
        """p/G dG/dp: its real part is per cent of |G| by per cent of p, its imaginary part radians; 0 where G is."""
        G = np.where(self.responses == 0, np.inf, self.responses)
        return np.asarray(self.values[:, None, None, None] * self.slopes / G)


@dataclass(frozen=True, repr=False)
class Response(Result):
    """G (frequencies, outputs, inputs), complex, SI units, over frequencies in Hz; NaN where it is infinite.

    `notes` are lines about frequencies that were skipped; units are those of inputs and outputs, by name.
    `transfers` are poles and zeros from every input to every output, `stiffnesses` those of frames along forces on
    them, where they were asked for. `linear` is what responds, with a ratio `damping` in every mode.
    """

    frequencies: Array
    values: ComplexArray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    notes: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    transfers: tuple[PolesAndZeros, ...] = ()
    machine: str = ""
    stiffnesses: tuple[PointStiffness, ...] = ()
    linear: Linearization | None = None
    damping: float = 0.0

    @cached_property
    def sensitivity(self) -> ResponseSensitivity:
        """Derivatives by all parameters, exact, along the equilibrium as it changes with them."""
        if self.linear is None:
            raise InputError(self.machine or "response", "sensitivity", "this response is not that of a machine")
        slopes = with_modal_damping_slopes(linear_slopes(self.linear), self.damping)
        changes = np.full((len(slopes.names), *self.values.shape), np.nan, dtype=complex)
        finite = np.isfinite(self.values).all(axis=(1, 2))
        changes[:, finite] = response_slopes(slopes, self.frequencies[finite])[1]
        parameters = self.linear.motion.parameters
        values = np.array([parameters[name] for name in slopes.names])
        return ResponseSensitivity(slopes.names, values, changes, self.values)

    def unit(self, output: str, source: str) -> str:
        """Return the unit of a response, such as m/N; SI if unknown."""
        if not {output, source} <= self.units.keys():
            return "SI"
        return quotient_unit(self.units[output], self.units[source])

    @property
    def headline(self) -> str:
        """Inputs, outputs and frequencies."""
        band = f"{len(self.frequencies)} frequencies from {self.frequencies[0]:.4g} to {self.frequencies[-1]:.4g} Hz"
        return f"Response of {', '.join(self.outputs)} to {', '.join(self.inputs)}: {band}"

    @property
    def all_notes(self) -> list[str]:
        """Notes about frequencies, and about transfer functions that are zero."""
        idle = [f"no response: {x.input} has no effect on {x.output}" for x in self.transfers if x.is_zero]
        return [*self.notes, *idle]


def quotient_unit(above: str, below: str) -> str:
    """Return the unit of a quotient, such as m / (N m)."""
    return f"{above} / {f'({below})' if ' ' in below else below}"


def frequency_grid(
    linear: Linearization, low: float | None = None, high: float | None = None, points: int = POINTS
) -> Array:
    """Return frequencies in Hz, evenly spaced on a logarithmic scale.

    By default from a tenth of the lowest oscillating pole to twice the highest. Raises `InputError`.
    """
    poles, _ = damped_poles(linear)
    shaking = np.abs(poles[poles.imag > 0]) / (2 * np.pi)
    low = (float(shaking.min()) / 10 if len(shaking) else 1.0) if low is None else low
    high = (2 * float(shaking.max()) if len(shaking) else 1000.0) if high is None else high
    refuse_band(low, high, points, linear.motion.source)
    return np.asarray(np.geomspace(low, high, points))


def refuse_band(low: float, high: float, points: int, source: str) -> None:
    """Raise `InputError` for frequencies, Hz, that are unordered or out of range, and for too many points."""
    if not (LOWEST <= low < high <= HIGHEST and 1 < points <= MOST_POINTS):
        what = f"from {low:g} to {high:g} Hz in {points} points: give {LOWEST:g} <= LOW < HIGH <= {HIGHEST:g}"
        raise InputError(source, "--band", f"{what} and 2 to {MOST_POINTS} points")


def refuse_missing_signals(linear: Linearization) -> None:
    """Raise `InputError` for a response without input or output."""
    for option, names, such in (("--input", linear.inputs, "fx"), ("--output", linear.outputs, "x")):
        if not names:
            frame = linear.motion.machine.joints[-1].name
            what = f"no motor is free: name an input, such as {frame}.{such}"
            raise InputError(linear.motion.source, option, what)


def frequency_response(linear: Linearization, frequencies: Array) -> Response:
    """Return G at frequencies in Hz; those on an undamped resonance are NaN, with a note.

    Raises `InputError` for frequencies that are negative or no numbers.
    """
    frequencies = np.asarray(frequencies, dtype=float)
    if frequencies.ndim != 1 or not len(frequencies) or not (np.isfinite(frequencies) & (frequencies >= 0)).all():
        raise InputError(linear.motion.source, "--frequency", "give numbers of Hz from 0")
    inputs, outputs = len(linear.inputs), len(linear.outputs)
    what = f"{len(frequencies)} frequencies of {inputs} inputs and {outputs} outputs"
    way_out = "give fewer, or choose by --input and --output"
    refuse_numbers(2 * len(frequencies) * inputs * outputs, what, linear.motion.source, "--band", way_out)
    infinite, notes = _resonances(linear, frequencies)
    values = np.full((len(frequencies), outputs, inputs), np.nan, dtype=complex)
    finite = np.flatnonzero(~infinite)
    for first in range(0, len(finite), BLOCK):
        block = finite[first : first + BLOCK]
        s = np.asarray(2j * np.pi * frequencies[block], dtype=complex)
        s_ = s[:, None, None]
        values[block] = (linear.Cq + s_ * linear.Cv + s_ * s_ * linear.Ca) @ linear.displacements(s, linear.F)
    machine = linear.motion.given
    units = {name: input_unit(machine, name) for name in linear.inputs}
    units |= {name: output_unit(machine, name) for name in linear.outputs}
    return Response(
        frequencies,
        values,
        linear.inputs,
        linear.outputs,
        (*linear.notes, *notes),
        units,
        machine=linear.motion.machine.name,
        linear=linear,
    )


def _resonances(linear: Linearization, frequencies: Array) -> tuple[BoolArray, list[str]]:
    """Return a mask of the frequencies that are undamped poles, and notes about them."""
    poles, _ = damped_poles(linear)
    undamped = np.abs(poles.imag[np.abs(poles.real) <= ON_RESONANCE * np.abs(poles)]) / (2 * np.pi)
    exact = [*undamped, *(modes(linear).frequencies if linear.is_symmetric and not linear.D.any() else ())]
    infinite, notes = np.zeros(len(frequencies), dtype=bool), []
    for k, f in enumerate(frequencies):
        if any(abs(f - pole) <= ON_RESONANCE * max(f, pole) for pole in exact):
            infinite[k] = True
            why = "rigid-body motion" if f == 0 else "undamped resonance"
            notes.append(f"{f:.9g} Hz is skipped: {why}, the response is infinite; add damping (--damping) or move it")
    return infinite, notes


def with_modal_damping(linear: Linearization, ratio: float) -> Linearization:
    """Return D + M Phi diag(2 ratio omega) Phi^T M, a damping ratio in every mode. Raises `InputError`."""
    if not 0 <= ratio < np.inf:
        raise InputError(linear.motion.source, "--damping", f"{ratio:g} is not a damping ratio: 0.01 is one per cent")
    if not ratio:
        return linear
    modal = modes(linear)
    shapes = linear.M @ modal.shapes
    added = (shapes * (2 * ratio * np.sqrt(np.maximum(modal.eigenvalues, 0.0)))) @ shapes.T
    return replace(linear, D=linear.D + (added + added.T) / 2)


def with_modal_damping_slopes(slopes: LinearSlopes, ratio: float) -> LinearSlopes:
    """Return slopes with those of a damping ratio in every mode: D = 2 ratio M R with R = f(M^-1 K).

    f(x) is the root of x, zero of a negative one. In modal coordinates R is diag(w), w_i = f(l_i), and dR_ij =
    phi_i^T (dK - l_j dM) phi_j (w_i - w_j)/(l_i - l_j), with 1/(w_i + w_j) for the quotient of two positive l, and zero
    where both modes are rigid or unstable (Daleckii and Krein).
    """
    if not ratio:
        return slopes
    linear = slopes.linear
    modal = modes(linear)
    Phi, squares = modal.shapes, modal.eigenvalues
    w, below = np.sqrt(np.maximum(squares, 0.0)), np.maximum(-squares, 0.0)
    changed = Phi.T @ slopes.K @ Phi - (Phi.T @ slopes.M @ Phi) * squares
    larger, below = np.maximum.outer(w, w), np.add.outer(below, below)
    sums = np.add.outer(w, w) + np.divide(below, larger, out=np.zeros_like(larger), where=larger > 0)
    dR = np.divide(changed, sums, out=np.zeros_like(changed), where=larger > 0)
    shapes = linear.M @ Phi
    return replace(slopes, D=slopes.D + 2 * ratio * (slopes.M @ (Phi * w) @ shapes.T + shapes @ dR @ shapes.T))
