"""The simulated shop floor is another program than the product, agrees with it, and wrote the files of examples/."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.responses import frequency_response
from symoro_elastic.formats import read_machine
from symoro_elastic.measured.vibration_tests.reading import read_tests
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.measured.vibration_tests import shop_floor
from tests.measured.vibration_tests.files import EXAMPLES
from tests.references.vibrating_tables import VibratingTables

HELD = ["motor_z", "motor_x"]
CASES = {
    "lathe": (shop_floor.LATHE_AT["hammer_far"], shop_floor.HAMMER, HELD, {}),
    "two_axis": (shop_floor.TWO_AXIS_AT["left"], shop_floor.SWEEP, [], {"motor_y": shop_floor.SERVO["motor_y"]}),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", CASES)
def test_the_other_program_agrees_with_the_product(name: str) -> None:
    at, pairs, held, pd = CASES[name]
    ins, outs = sorted({i for _, i in pairs}), sorted({o for o, _ in pairs})
    motion = motion_of(read_machine(EXAMPLES / f"{name}.toml")[0], {}, ins, outs)
    linear = with_motors(linearize(motion, equilibrium(motion, at), ins, outs), held, pd)
    f = np.geomspace(9, 290, 25)
    ours = frequency_response(linear, f).values
    theirs = VibratingTables(shop_floor.tables_of(name)).response(at, held, pairs, f, pd)
    for k, (output, into) in enumerate(pairs):
        same = ours[:, outs.index(output), ins.index(into)]
        assert np.abs(same - theirs[:, k]).max() < 1e-9 * np.abs(same).max()


@pytest.mark.thorough
def test_the_files_are_those_of_the_shop_floor() -> None:
    """Numbers have six digits; the last one may differ where another library rounds."""
    written = shop_floor.files()
    kept = {f"{path.parent.name}/{path.name}" for path in EXAMPLES.glob("*_tests/*.csv")}
    assert kept == {*written} and sum(map(len, written.values())) < 300_000
    for path, text in written.items():
        (head, *lines), (known, *there) = text.splitlines(), (EXAMPLES / path).read_text().splitlines()
        assert head == known
        numbers, expected = (np.array([line.split(",") for line in x], dtype=float) for x in (lines, there))
        assert np.allclose(numbers, expected, rtol=2e-5, atol=1e-12), path


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "tests", "validated"), [("lathe", 4, 2), ("two_axis", 6, 2)])
def test_the_lists_are_read(name: str, tests: int, validated: int) -> None:
    machine, _ = read_machine(EXAMPLES / f"{name}.toml")
    found = read_tests(EXAMPLES / f"{name}_tests" / "tests.toml", machine)
    assert len(found.tests) == tests and sum(test.validate for test in found.tests) == validated and found.notes == ()
    test = found.tests[-3]
    pairs = [(one.output, one.input) for one in test.responses]
    G = shop_floor.machine(name).response(test.at, test.hold, pairs, test.responses[0].f, test.pd)
    for one, g in zip(test.responses, G.T, strict=True):
        sd = np.abs(one.H) * np.sqrt((1 - one.coherence) / (2 * one.coherence * test.averages))
        assert np.median(np.abs(one.H - g) / (np.sqrt(2) * sd)) == pytest.approx(np.sqrt(np.log(2)), rel=0.3)
