"""How margins and poles of closed loops change with parameters, gains and parts of drives: exact, at their own s.

A margin is that of L(f; p) at a frequency that moves with p, too: at a crossing, g(f; p) = 0, by df/dp =
-(dg/dp)/(dg/df), at the least |1 + L| without effect (envelope). A pole s is where Z(s; p) x = 0 and y^T Z = 0:

    ds/dp = -(y^T dZ/dp x)/(y^T dZ/ds x)

dZ/ds and dL/df are means over a small circle (Cauchy), as all loops are analytic functions of s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, CurrentLoop
from symoro_elastic.analysis.control.loops import AxisLoops, Margins, mechanical_names, slopes_of_terms
from symoro_elastic.analysis.control.plant import Plant
from symoro_elastic.foundation.array_types import ComplexArray

TURNS = np.exp(2j * np.pi * np.arange(8) / 8)
RADIUS = 1e-5
"""Of the circle, by the size of its middle: nearer than any other pole, and wide enough for its values to differ."""
POLISHED = 6
"""Steps from a pole with approximated dead times to that with exact ones; these converge quadratically."""
NEAR = 0.05
"""Of a pole: further than this the two are not the same."""


@dataclass(frozen=True)
class MarginSlopes:
    """p d/dp of the margins of an open loop, by name of p: of ln modulus, of the phase in deg, of ln gain.

    Empty where there is no such margin. 1 % more of p changes the modulus by so many %, the phase by a hundredth of it.
    """

    modulus: Mapping[str, float]
    phase: Mapping[str, float]
    gain: Mapping[str, float]


def margin_slopes(loops: AxisLoops, key: str, found: Margins) -> MarginSlopes:
    """Return the slopes of the margins of the loop of a gain, Kp or Kv, by parameters, gains and parts of its drive."""
    loop = loops.velocity_loop if key == "Kp" else loops.position_loop

    def at(f: float, of: Callable[[complex, complex, complex], float]) -> dict[str, float]:
        if not np.isfinite(f):
            return {}
        L, by_f = complex(loop(np.array([f]))[0]), _slope(loop, complex(f))
        return {name: of(L, by_f, change) for name, change in _slopes_of_loop(loops, key, f).items()}

    def of_phase(L: complex, by_f: complex, change: complex) -> float:
        moved = -(change / L).real / (by_f / L).real
        return float(np.sign(np.angle(-L)) * np.degrees((change / L).imag + (by_f / L).imag * moved))

    def of_gain(L: complex, by_f: complex, change: complex) -> float:
        return -(change.real - by_f.real * change.imag / by_f.imag) / L.real

    return MarginSlopes(
        at(found.modulus_frequency, lambda L, _, change: (change / (1 + L)).real),
        at(found.phase_frequency, of_phase),
        at(found.gain_frequency, of_gain),
    )


def _slopes_of_loop(loops: AxisLoops, key: str, frequency: float) -> dict[str, complex]:
    """Return p dL/dp by name p, gains among them."""
    f, one = np.array([frequency]), loops.cascade
    s, _, G_v = loops.responses(f)
    own, terms = (one.Kp, loops.terms_of_Kp) if key == "Kp" else (one.Kv, loops.terms_of_Kv)
    L = own * complex(terms(f)[1][0])
    by_C = L if key == "Kp" else L / complex((1 + one.controller(s) * s * G_v)[0])
    found = {name: own * change for name, change in slopes_of_terms(loops, key, frequency).items()}
    return found | {"Kp": by_C, **({"Kv": L} if key == "Kv" else {}), **_by_Tn(one, s, by_C)}


def _by_Tn(one: Cascade, s: ComplexArray, by_C: complex) -> dict[str, complex]:
    """Tn dC/dTn, from C times the derivative by C."""
    return {"Tn": -by_C * complex((1 / (one.Tn * s) / one.integral(s))[0])} if np.isfinite(one.Tn) else {}


def pole_slopes(plant: Plant, cascades: Sequence[Cascade], near: complex) -> tuple[complex, dict[str, complex]]:
    """Return the pole next to one of `closed_loop`, with exact dead times, and its p ds/dp by name p, 1/s.

    Gains and parts of drives are named after their motor, as in "motor, Kp". Empty where no pole is as near.
    """
    s, polished = near, near
    for _ in range(POLISHED):
        s = polished
        y, x = _null_vectors(plant.stiffness_at(np.array([s]), cascades)[0])

        def along(at: ComplexArray, y: ComplexArray = y, x: ComplexArray = x) -> ComplexArray:
            found: ComplexArray = plant.stiffness_at(at, cascades) @ x @ y
            return found

        by_s = _slope(along, s)
        polished = s - complex(along(np.array([s]))[0]) / by_s
    if not abs(s - near) <= NEAR * abs(near):
        return near, {}
    return s, {name: -change / by_s for name, change in _slopes_of_Z(plant, cascades, s, y, x).items()}


def _slopes_of_Z(
    plant: Plant, cascades: Sequence[Cascade], s: complex, y: ComplexArray, x: ComplexArray
) -> dict[str, complex]:
    """Return p y^T dZ/dp x by name p."""
    slopes, values = plant.slopes, plant.linear.motion.parameters
    left, moved, at = plant.free @ y, plant.free @ x, np.array([s])
    by_parameter = (left @ (s * s * slopes.M + s * slopes.D + slopes.K) @ moved).tolist()
    mechanical = {*mechanical_names(plant)}
    found = {p: values[p] * by for p, by in zip(slopes.names, by_parameter, strict=True) if p in mechanical}
    for one in cascades:
        axis = plant.axes[one.motor]
        pushed, C = left @ axis.velocity, one.controller(at)[0]
        by_Kv, by_D = pushed * one.Kv * C * (axis.position @ moved), pushed * s * (axis.velocity @ moved)
        by_C = complex(by_Kv + by_D * C)
        own = {"Kv": complex(by_Kv), "Kp": by_C, **_by_Tn(one, at, by_C)}
        for part in one.path:
            if isinstance(part, CurrentLoop):
                by_Y = by_D * part.dragged(at)[0]
                own |= {name: complex(by_C * H[0] + by_Y * Y[0]) for name, (H, Y) in part.slopes(at).items()}
            else:
                own[part.name] = complex(by_C * part.slope(at)[0])
        found |= {f"{one.motor}, {name}": change for name, change in own.items()}
    return found


def _null_vectors(Z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return y and x of the least singular value: y^T Z and Z x are next to zero."""
    left, _, right = np.linalg.svd(Z)
    return left[:, -1].conj(), right[-1].conj()


def _slope(of: Callable[[ComplexArray], ComplexArray], middle: complex) -> complex:
    """Return the derivative of an analytic function: the mean of f(m + r e^it) e^-it over a circle, over r."""
    radius = RADIUS * abs(middle)
    return complex((of(middle + radius * TURNS) / TURNS).mean() / radius)
