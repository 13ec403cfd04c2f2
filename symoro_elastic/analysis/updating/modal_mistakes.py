"""Which mistake of a list of modes explains what the model cannot: each is undone, and the tests are fitted again.

How far tests are from the model is the cost of a fit: of frequencies, damping ratios, shapes and the prior. A mistake
is named if tests without it leave no more than noise, and the list as it is leaves far more, from the values that were
found, too. Beside responses, which tell the values, nothing is fitted. One of the whole list is refused; one of a mode,
which hardly counts in the fit, is said.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np

from symoro_elastic.analysis.updating.listed_tests import Corrected, ListedTests
from symoro_elastic.analysis.updating.measured import MeasuredModes, VibrationTest, roughly
from symoro_elastic.analysis.updating.misfit import UNPAIRED, Fit, Misfit, differences
from symoro_elastic.analysis.updating.predictions import Predictions, Swinging
from symoro_elastic.analysis.updating.unknowns import Sought
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine

FALL, LEFT, ALIKE = 10.0, 0.4, 5.0
"""By how much the cost falls at least without a mistake, what it leaves at most, and costs that do not differ."""
MOST_FITTED, MOST_SAID = 4, 3
"""Mistakes of a kind that are fitted; how many are said together."""
FACTORS_F = {
    "frequencies are in rad/s, not in Hz": 1 / (2 * math.pi),
    "frequencies are in turns a minute, not in Hz": 1 / 60,
    "frequencies are in kHz, or times in ms, and are called Hz and s": 1e3,
    "frequencies are in Hz, and are called kHz": 1e-3,
}
FACTORS_ZETA = {
    "damping ratios are in percent: write damping_ratio [%]": 1e-2,
    "damping ratios are in 1, not in percent": 1e2,
    "damping ratios are logarithmic decrements, which are 2 pi times as large": 1 / (2 * math.pi),
    "damping ratios are loss factors, which are twice as large": 0.5,
}
OF_MODE = "mode "
SoughtOf = Callable[[Sequence[VibrationTest]], Sought]


@dataclass(frozen=True)
class _Tried:
    """Tests without a mistake, and their cost at a fit of theirs."""

    one: Corrected
    cost: float


class _Fits:
    """Fits of tests with modes: near starts, or at values that responses told."""

    def __init__(self, sought: Sought, tests: Sequence[VibrationTest], at: Array | None) -> None:
        """Values `at` are kept."""
        self.sought, self.tests, self.at = sought, tuple(tests), at
        self.wide = Predictions(sought, [_with_all_outputs(test, sought.machine) for test in tests])
        self._swinging: dict[bytes, list[Swinging]] = {}

    def of(self, tests: Sequence[VibrationTest], sought: Sought | None = None) -> Misfit:
        """Return the misfit of other tests; where other motors are held unknowns may be others."""
        return Misfit(Predictions(sought, tests) if sought else self.wide.of(tests), (), math.inf)

    def cost(self, misfit: Misfit, x: Array) -> float:
        """Return how far tests are from the model at x."""
        given, swinging = misfit.predictions.tests, None
        if all(a.at is b.at and a.hold is b.hold and a.pd is b.pd for a, b in zip(given, self.tests, strict=True)):
            key = x.tobytes()
            if key not in self._swinging:
                self._swinging[key] = self.wide.swinging(x)
            swinging = self._swinging[key]
        return misfit.modal_cost(x, swinging)

    def rough_cost(self, misfit: Misfit, x: Array) -> float:
        """Return the cost of modes that are known roughly."""
        predictions = misfit.predictions
        return self.cost(replace(misfit, predictions=predictions.of(list(map(roughly, predictions.tests)))), x)

    def near(self, misfit: Misfit, x: Array) -> tuple[float, Array]:
        """Return the cost of a minimum near x, and where it is."""
        if self.at is None:
            x = misfit.with_all_pairs.minimum(x, differences)
        return self.cost(misfit, x), x


def wrong_modes(
    sought: Sought, machine: Machine, sought_of: SoughtOf, tests: Sequence[VibrationTest], fit: Fit
) -> list[str]:
    """Return lines on modes that do not go with the model; raises `InputError` for a mistake of a whole list.

    `sought_of` gives the unknowns of tests, which other motors that are held change.
    """
    modal = [test for test in tests if test.modes is not None]
    if not modal:
        return []
    fits = _Fits(sought, modal, fit.x if fit.lines else None)
    own = fits.of(modal)
    least, x = min((fits.near(own, x) for x in (own.start, fit.x)), key=_cost)
    if own.is_modal_noise(least):
        return []
    listed, starts = ListedTests(machine, modal), (own.start, x)
    kinds: list[tuple[Iterable[Corrected], SoughtOf | None]] = [
        (_written(listed), None), (_of_modes(listed), None), (listed.positions(), None),
        *([(listed.held(), sought_of)] if fits.at is None else []),
    ]  # fmt: skip
    for each, unknowns in kinds:
        if found := list(_explaining(fits, own, each, unknowns, starts, least)):
            return _named(found, least)
    return []


def _explaining(
    fits: _Fits,
    own: Misfit,
    others: Iterable[Corrected],
    sought_of: SoughtOf | None,
    starts: Sequence[Array],
    least: float,
) -> Iterator[_Tried]:
    """Yield the nearest tests without a mistake that leave no more than noise, where the tests as they are leave more.

    These leave more from the values that were found without the mistake, too.
    """
    near, as_it_is = [], [fits.rough_cost(own, x) for x in starts]
    for one in others:
        try:
            misfit = fits.of(one.tests, sought_of(one.tests) if sought_of else None)
            begun = [_values(misfit, own, x) for x in starts]
            each = [fits.rough_cost(misfit, x) - before for x, before in zip(begun, as_it_is, strict=True)]
            near.append((min(each), one, misfit, begun))
        except (InputError, np.linalg.LinAlgError):
            continue
    for _, one, misfit, begun in sorted(near, key=_cost)[:MOST_FITTED]:
        cost, x = min((fits.near(misfit, x) for x in begun), key=_cost)
        if not misfit.is_modal_noise(cost):
            continue
        before = min(least, fits.near(own, _values(own, misfit, x))[0])
        before -= UNPAIRED * max(misfit.unknowns - own.unknowns, 0)  # each may explain a number that is of nothing
        if cost < min(LEFT * before, before - FALL):
            yield _Tried(one, cost)


def _named(found: Sequence[_Tried], before: float) -> list[str]:
    """Return the line on the mistake of a mode that leaves least; raises `InputError` for that of a whole list."""
    order = sorted(found, key=lambda one: one.cost)
    alike = [one for one in order if one.cost <= order[0].cost + ALIKE]
    said = ", or ".join(dict.fromkeys(one.one.what for one in alike[:MOST_SAID]))
    files = ", ".join(dict.fromkeys(one.one.files for one in alike[:MOST_SAID]))
    if not said.startswith(OF_MODE):
        raise InputError(files, "modes", f"{said}: only so does the model explain them; correct the list")
    return [f"{files}: modes: {said}: without it the model explains the others"]


def _cost(one: tuple[Any, ...]) -> float:
    return float(one[0])


def _values(misfit: Misfit, own: Misfit, x: Array) -> Array:
    """Return the unknowns of a misfit where they are those of another one at x, else at their start."""
    known = dict(zip(own.predictions.sought.labels, x.tolist(), strict=True))
    labels, start = misfit.predictions.sought.labels, misfit.start.tolist()
    return np.array([known.get(label, value) for label, value in zip(labels, start, strict=True)])


def _written(listed: ListedTests) -> Iterator[Corrected]:
    """Yield tests whose modes are written in another unit, with another sign, order or name of shapes' outputs."""
    for what, factor in FACTORS_F.items():
        yield from listed.each(what, partial(_changed, of=partial(_times, f=factor)))
    for what, factor in FACTORS_ZETA.items():
        yield from listed.each(what, partial(_changed, of=partial(_times, zeta=factor)))
    names = list(dict.fromkeys(name for test in listed.tests if test.modes for name in test.modes.outputs))
    for name in names:
        yield from listed.each(f"{name} has the opposite sign", partial(_changed, of=partial(_called, {}, name)))
        for other in listed.other_outputs(name):
            yield from listed.each(f"{name} is {other}", partial(_changed, of=partial(_called, {name: other}, "")))
    for a, b in combinations(names, 2):
        what = f"{a} and {b} are exchanged"
        yield from listed.each(what, partial(_changed, of=partial(_called, {a: b, b: a}, "")))


def _of_modes(listed: ListedTests) -> Iterator[Corrected]:
    """Yield tests without one of their modes, and with another sign of one amplitude of a mode."""
    for t, test in enumerate(listed.tests):
        f = test.modes.f if test.modes else np.zeros(0)
        for k in range(len(f) if len(f) > 1 else 0):
            what = f"{OF_MODE}{k + 1}, {f[k]:.4g} Hz, is none of the model's, is there twice, or its numbers are wrong"
            yield listed.with_test(what, t, _changed(test, partial(_without, k=k)))
            for column, name in enumerate(test.modes.outputs if test.modes else ()):
                what = f"{OF_MODE}{k + 1}, {f[k]:.4g} Hz, has the opposite sign of {name}"
                yield listed.with_test(what, t, _changed(test, partial(_mirrored, k=k, column=column)))


def _changed(test: VibrationTest, of: Callable[[MeasuredModes], MeasuredModes | None]) -> VibrationTest:
    """Return a test with other modes; the same where there are none."""
    modes = None if test.modes is None else of(test.modes)
    return test if modes is None else replace(test, modes=modes)


def _times(modes: MeasuredModes, f: float = 1.0, zeta: float = 1.0) -> MeasuredModes | None:
    """Return modes with frequencies and damping ratios times factors; None for ratios that are none, or not there."""
    if zeta != 1 and (modes.zeta is None or not np.nanmax(zeta * modes.zeta) < 1):
        return None
    std_f, ratio, std = (
        None if x is None else c * x for x, c in ((modes.std_f, f), (modes.zeta, zeta), (modes.std_zeta, zeta))
    )
    return replace(modes, f=f * modes.f, std_f=std_f, zeta=ratio, std_zeta=std)


def _called(names: dict[str, str], mirrored: str, modes: MeasuredModes) -> MeasuredModes | None:
    """Return modes with other names of outputs, one of which has the opposite sign; None where nothing changes."""
    outputs = tuple(names.get(name, name) for name in modes.outputs)
    if modes.shapes is None or len(set(outputs)) < len(outputs):
        return None
    signs = np.array([-1.0 if name == mirrored else 1.0 for name in modes.outputs])
    if outputs == modes.outputs and (signs > 0).all():
        return None
    return replace(modes, outputs=outputs, shapes=modes.shapes * signs)


def _without(modes: MeasuredModes, k: int) -> MeasuredModes:
    """Return all modes but one."""
    kept = np.arange(len(modes.f)) != k
    zeta, std_f, std_zeta = (None if x is None else x[kept] for x in (modes.zeta, modes.std_f, modes.std_zeta))
    shapes = None if modes.shapes is None else modes.shapes[kept]
    return replace(modes, f=modes.f[kept], zeta=zeta, std_f=std_f, std_zeta=std_zeta, shapes=shapes)


def _mirrored(modes: MeasuredModes, k: int, column: int) -> MeasuredModes | None:
    """Return modes with the opposite sign of one amplitude of one of them."""
    if modes.shapes is None:
        return None
    shapes = modes.shapes.copy()
    shapes[k, column] *= -1
    return replace(modes, shapes=shapes)


def _with_all_outputs(test: VibrationTest, machine: Machine) -> VibrationTest:
    """Return a test whose modes have amplitudes at all outputs that it may have measured; what these are is unknown."""
    if test.modes is None or not test.modes.outputs:
        return test
    others = [other for name in test.modes.outputs for other in ListedTests(machine, [test]).other_outputs(name)]
    return replace(test, modes=replace(test.modes, outputs=tuple(dict.fromkeys((*test.modes.outputs, *others)))))
