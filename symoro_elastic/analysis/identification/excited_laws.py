"""Laws of friction and cogging along exciting motions: their columns, and the torques that they take by the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.identification.estimation import Unknown
from symoro_elastic.analysis.identification.fourier_motion import beside, rise
from symoro_elastic.analysis.identification.friction_laws import COSINE, SINE, FrictionLaws, refuse_laws
from symoro_elastic.analysis.identification.possible import Linear
from symoro_elastic.analysis.identification.regression import Regressor
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.independence import IndependentColumns

Motion = tuple[Array, Array, Array]


@dataclass(frozen=True)
class ExcitedLaws:
    """Laws beyond FV qd + FS sign(qd) of a machine with the regressor Y, about its parameters in the file.

    `values` are those of named parameters.
    """

    machine: Machine
    Y: Regressor
    laws: FrictionLaws
    values: Mapping[str, float]

    def __post_init__(self) -> None:
        """Refuse loads that parameters without value do not tell, and joints that follow others."""
        refuse_laws(self.machine, self.laws)
        unknown = [column.label for column in self.Y.columns if not np.isfinite(column.value)]
        if self.laws.load and unknown:
            what = f"the torques that it rises with need {', '.join(unknown)}: give values by --value"
            raise self.machine.error("--load-friction", what)

    @property
    def labels(self) -> tuple[str, ...]:
        """What the columns are of."""
        return tuple(x.label for x in self._unknowns)

    def columns(self, motion: Motion) -> Array:
        """Return their columns along a motion, (samples, n, k)."""
        return self.laws.columns(self.Y, self._linear, motion)

    def torques(self, motion: Motion) -> Array:
        """Return the torques of friction beyond FV and FS by the file, (samples, n); cogging is in `amplitudes`.

        Between samples of a period they are largest: those by load as their rise, Stribeck's at the slowest rate near.
        """
        q, qd, _ = motion
        if not (self.laws.load or self.laws.stribeck):
            return np.zeros_like(q)
        count = len(self.laws.load) + len(self.laws.stribeck)
        found, load = self.columns(motion)[:, :, :count] * self._numbers[:count], len(self.laws.load)
        found[:, :, :load] += np.sign(found[:, :, :load]) * rise(np.abs(found[:, :, :load]))
        rates, half = self.Y.rates(list(self.laws.stribeck), q, qd), np.array(list(self.laws.stribeck.values()))
        near, more = beside(rates), rise(rates)
        slowest = np.maximum(np.abs(near).min(axis=0) - more, 0.0) * (near.min(axis=0) * near.max(axis=0) > 0)
        found[:, :, load:] *= ((1 + (rates / half) ** 2) / (1 + (slowest / half) ** 2))[:, None]
        torques: Array = found.sum(axis=2)
        return torques

    @cached_property
    def amplitudes(self) -> Array:
        """The amplitudes of cogging by the file, (n,): its peaks may be between samples."""
        found = np.zeros(len(self.machine.independent))
        for j in self.laws.cogging:
            amplitude = self.machine.joint(j).reflected_cogging.amplitude
            found[self.machine.independent.index(j)] = abs(self._value(amplitude))
        return found

    @cached_property
    def _unknowns(self) -> Sequence[Unknown]:
        return self.laws.unknowns(self.machine, self._linear)

    @cached_property
    def _linear(self) -> Linear:
        columns = self.Y.columns
        nothing = IndependentColumns((), (), (), np.zeros((0, 0)))
        return Linear(columns, (), nothing, {c: column.value for c, column in enumerate(columns)})

    @cached_property
    def _numbers(self) -> Array:
        """The numbers of the columns by the file, zero where it has none."""
        laws = {j: self.machine.joint(j).friction for j in (*self.laws.load, *self.laws.stribeck)}
        rising = [self._value(laws[j].load) for j in self.laws.load]
        static = [self._value(laws[j].static) for j in self.laws.stribeck]
        more = [x - self._value(laws[j].coulomb) if x else 0.0 for j, x in zip(self.laws.stribeck, static, strict=True)]
        return np.array([*rising, *more, *(0.0 for _ in self.laws.cogging for _ in (COSINE, SINE))])

    def _value(self, formula: Formula) -> float:
        return float(formula.value({**parameter_values(self.machine), **self.values}))
