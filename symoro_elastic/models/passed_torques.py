"""Torques that pass through the transmissions of joints, of motors and springs less friction and rotors.

Friction that rises with load needs them: lambda = Gamma_m - Gamma_f(lambda) - Ia qdd(lambda), which generated models
are given. As its share of lambda is below 0.9 and rotors take but a part of a torque, lambda is found by substitution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import with_friction_states
from symoro_elastic.models.implicit_steps import FAMILY
from symoro_elastic.models.model import Model, Result, Results, TracedModel
from symoro_elastic.models.state import position_blocks
from symoro_elastic.models.tracing import Trace, prune, schedule
from symoro_elastic.quantities import quantity
from symoro_elastic.symbolic.program import Input

PASSED_TORQUES, PASSED = "passed_torques", "load_passed"


def passed_torques(machine: Machine, folded: Sequence[str] = ()) -> TracedModel:
    """Return the model of lambda (l,), by the torques of motors, accelerations, and the lambda in friction."""
    bound = Bound(machine, folded)
    results = _results(bound)
    model = Model(
        PASSED_TORQUES,
        "torques through transmissions",
        "[12]",
        (*position_blocks(machine), "qd", "qdd", "tau"),
        tuple(results),
        lambda other, _: _results(other),
        FAMILY,
        own=(replace(quantity("load"), name=PASSED),),
    )
    model = with_friction_states(model, bound, results)
    entries = bound.arguments()
    inputs = tuple(Input(name, entries[name]) for name in model.arguments)
    return schedule(prune(Trace(model, inputs, results, bound.graph, bound.names, True, ())))


def _results(bound: Bound) -> Results:
    qdd = bound.given_accelerations()
    links = bound.mechanism.links
    passed = (bound.exerted_torque(j) - links[j - 1].rotor_inertia * qdd[j] for j in bound.machine.loaded)
    return {PASSED: Result(bound.machine.loaded, tuple(passed))}
