"""Direct dynamic model of a machine with its drives: accelerations, rates of all states, and torques of the motors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import RECURSION
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Model, Result, Results, TracedModel
from symoro_elastic.models.bound.tracing import Trace, prune, schedule
from symoro_elastic.models.drives.drive_states import SET_POINTS, chains_of, inputs_of, state_symbols
from symoro_elastic.models.dynamics.floating_base import on_its_base
from symoro_elastic.models.programs.catalogue import MODELS, in_form, trace_of
from symoro_elastic.quantities import quantity

NAME = "closed_dynamics"


def closed_dynamics(machine: Machine, folded: Sequence[str] = ()) -> TracedModel:
    """Return the direct dynamic model under the drives as a program."""
    return schedule(prune(closed_trace(Bound(machine, folded))))


def closed_trace(bound: Bound, form: str = RECURSION) -> Trace:
    """Return the direct dynamic model under the drives as a trace, by set points r, rd, rdd and additional torques tau.

    A motor without a drive has the torque tau. z are states of friction, then of drives. `form` is that of the direct
    dynamic model.
    """
    machine, chains = bound.machine, chains_of(bound)
    symbols = state_symbols(chains, "z")
    entries = bound.arguments()
    rates: list[Scalar] = []
    for j, chain in chains.items():
        states = [bound.graph.symbol(name) for name in symbols[j]]
        derivatives, bound.torques[j] = chain.answer(states, inputs_of(bound, j))
        rates += derivatives
    results = _results(bound, rates, form)
    z = (*entries["z"], *(name for names in symbols.values() for name in names))
    arguments = tuple(name for name in _MODEL.arguments if z or name != "z")
    results_present = tuple(name for name in _MODEL.results if name in results)
    model = replace(_MODEL, arguments=arguments, results=results_present, on_base=MODELS["direct_dynamics"].on_base)
    return trace_of(on_its_base(model, machine), bound, results, own_entries={"z": z})


def _results(bound: Bound, rates: Sequence[Scalar], form: str) -> Results:
    by_name = in_form("direct_dynamics", form).run(bound, bound.machine.independent)
    entries = (*(by_name.pop("zd").entries if "zd" in by_name else ()), *rates)
    zd = {"zd": Result(None, entries, (len(entries),))} if entries else {}
    tau = Result(bound.motors, tuple(bound.torques[j] for j in bound.motors))
    return {"qdd": by_name.pop("qdd"), **zd, "tau_m": tau, **by_name}


_MODEL = Model(
    NAME,
    "direct dynamic model under the drives",
    "[12]-[36]",
    ("q", "qd", "z", *SET_POINTS, "tau"),
    ("qdd", "zd", "tau_m"),
    own=(
        replace(quantity("z"), meaning="states of friction, then of drives", unit=None, shape="states"),
        replace(quantity("zd"), unit=None, shape="states"),
        replace(quantity("tau"), meaning="torques or forces added to those that the drives demand"),
    ),
)
