"""Feed-forward in `check` and `benchmark`: its motion is put back into the equations of motion."""

from __future__ import annotations

from fractions import Fraction

import pytest

from symoro_elastic.analysis.trade_off.builds import QUICK
from symoro_elastic.analysis.trade_off.trade import Request, trade
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.dynamics import feed_forward as of_model
from symoro_elastic.numerics.verification.verify import verify
from tests.closed_chains.test_feed_forward import strut, with_spring
from tests.models.test_feed_forward import FLEX4, drive

FORWARD = Scene(models=("feed_forward",))


@pytest.mark.thorough
@pytest.mark.parametrize(
    "machine", [drive(0, 1), drive(1, 2), read_machine(FLEX4)[0]], ids=["a spring", "two springs", "flex4"]
)
def test_it_is_put_back_into_the_equations_of_motion(machine: Machine) -> None:
    found = verify(machine, FORWARD, states=(4, 8))
    (model,) = found.models
    assert found.ok and found.disagreement < 1e-30 and (model.moderate, model.extreme) == (4, 8)
    assert max(model.numpy.moderate, model.equations.moderate) < 1e-13


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("flap", ["5000", "5000*(1 + 0.1*sin(qm + d_flap))"])
def test_springs_on_dependent_joints_and_changing_stiffness(flap: str) -> None:
    """States at which no deflection balances the load are not judged."""
    found = verify(strut("3000 + 200*s", flap), FORWARD, states=(4, 8))
    (model,) = found.models
    assert found.ok and found.disagreement < 1e-30 and model.moderate == 4
    assert model.extreme + len(model.unjudged) == 8 and model.extreme > 4


@pytest.mark.thorough
def test_a_tree_whose_stiffness_changes() -> None:
    soft = with_spring(drive(0, 1), "spring1", "900 + 4e4*x1^2")
    found = verify(soft, Scene(models=("feed_forward", "direct_dynamics", "inverse_dynamics")), states=(4, 4))
    assert found.ok and all(model.moderate == 4 for model in found.models)


@pytest.mark.thorough
@pytest.mark.parametrize("wrong", ["_rate", "_motion"])
def test_a_wrong_feed_forward_is_found(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The reference is not an other run of the same program: it finds what equations and code have in common."""
    right = getattr(of_model, wrong)
    monkeypatch.setattr(of_model, wrong, lambda *given: right(*given) * Fraction(1 + (given[-1] > 0), 1))
    assert not verify(drive(0, 1), FORWARD, states=(2, 0)).ok


@pytest.mark.thorough
def test_its_trade() -> None:
    pytest.importorskip("flint")
    found = trade(drive(0, 1), FORWARD, Request(QUICK, states=4, rounds=1))
    doubles = [x for x in found.measurements["feed_forward"] if x.configuration.precision.name == "double"]
    assert doubles and all(x.errors.relative < 1e-14 for x in doubles)
