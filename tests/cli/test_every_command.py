"""Every command on odd machines and on every example: an exit code of the table, one line for an error, strict JSON."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from symoro_elastic import cli
from tests.command_line import EXAMPLES, Ended, ended

pytestmark = [pytest.mark.filterwarnings("error::RuntimeWarning"), pytest.mark.sampled(5)]

BODIES = """
[bodies]
a = { mass = 2, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.2] }
b = { mass = 1, center_of_mass = [0.2, 0, 0], inertia = [0.1, 0.2, 0.3] }
"""
JOINTS = """
gravity = [0, -9.81, 0]
joints = [
  { name = "a", kind = "KIND", sigma = 0, theta = "q1" },
  { name = "b", kind = "KIND", sigma = 0, theta = "q2", d = 0.5 },
]
"""
FIXED = """
joints = [
  { name = "a", kind = "fixed" },
  { name = "b", kind = "fixed", d = 0.5 },
]
"""
FLOATING = '[base]\nfloating = "quaternion"\nbody = { mass = 5, center_of_mass = [0, 0, 0], inertia = [1, 2, 3] }\n'
RIGID = JOINTS.replace("KIND", "motor")


AXIS = JOINTS.replace("KIND", "motor", 1).replace("KIND", "elastic") + BODIES
SPRING = "[springs]\nb = { stiffness = 8e3, damping = 5 }\n"
CASCADE = "Kv = 10, Kp = 30, Tn = 0.1"
WINDING = "[motors]\na = { resistance = 0.5, inductance = 1e-3, torque_constant = 1 }\n"
BRISTLES = "coulomb = 1, static = 1.5, stribeck = 0.01, bristle = 1e4, bristle_damping = 10, viscous = 0.4"


def driven(rest: str, machine: str = AXIS + SPRING) -> str:
    """A motor, its drive and a spring."""
    return f"{machine}[drives]\na = {{ {CASCADE}, {rest} }}\n"


def long_chain(joints: int) -> str:
    rows = [f'  {{ name = "j{k}", kind = "motor", sigma = 0, theta = "q{k}", d = 0.1 }},' for k in range(1, joints + 1)]
    bodies = [f"j{k} = {{ mass = 1, center_of_mass = [0.1, 0, 0] }}" for k in range(1, joints + 1)]
    return "\n".join(["joints = [", *rows, "]", "[bodies]", *bodies])


ODD = {
    "no_joint": "joints = []\n",
    "all_fixed": FIXED,
    "fixed_bodies": FIXED + BODIES,
    "all_passive": JOINTS.replace("KIND", "passive") + BODIES,
    "all_elastic": JOINTS.replace("KIND", "elastic") + BODIES + "[springs]\na.stiffness = 9\nb.stiffness = 8\n",
    "rigid": RIGID + BODIES,
    "no_mass": RIGID,
    "one_mass": RIGID + BODIES.split("b =", maxsplit=1)[0],
    "no_values": RIGID + BODIES.replace("mass = 2", 'mass = "M1"') + "[parameters]\nM1 = nan\n",
    "floating_only": FIXED + FLOATING,
    "floating": RIGID + FLOATING + BODIES,
    "long_chain": long_chain(40),
    "driven": driven("current = { lag = 2e-4 }, dead_time = 1e-4"),
    "limited": driven(
        "limits = { torque = 60 }, set_point = { lowpass = 60 }, filters = [{ lowpass = 400, order = 2 }]"
    ),
    "sampled": driven("period = 1e-3, limits = { torque = 60 }, set_point = { average = 4e-3 }"),
    "wound": driven("current = { kp = 3, ti = 2e-3 }", AXIS + SPRING + WINDING),
    "driven_floating": driven("current = { lag = 2e-4 }", AXIS + SPRING + FLOATING),
    "driven_in_space": driven("current = { lag = 2e-4 }", AXIS.replace("9.81", "0") + SPRING + FLOATING),
    "loose": driven("current = { lag = 2e-4 }", AXIS + SPRING.replace("damping", "backlash = 2e-3, damping")),
    "bristles": driven("current = { lag = 2e-4 }", f"{AXIS}{SPRING}[friction]\na = {{ {BRISTLES} }}\n"),
    "loaded": f"{AXIS}{SPRING}[friction]\na = {{ coulomb = 1, load = 0.1, creep = 1e-3 }}\n",
}
LIMITS = ("--position", "1", "--velocity", "1", "--acceleration", "5", "--evaluations", "1", "--periods", "1")
CALLS: dict[str, tuple[tuple[str, ...], ...]] = {
    "show": ((),),
    "view": (("--out", "page.html"),),
    "live": (),
    "convert": (("other.par",), ("other.toml", "--base", "--force")),
    **{"models": (), "new": (), "flexible": (), "formats": (), "schema": ()},
    "evaluate": (("--model", "inverse_dynamics"), ("--model", "inertia_matrix", "--at", "a=1")),
    "ik": (("--position", "0.1,0.2,0.3", "--starts", "2"),),
    "stiffness": ((), ("--along", "a=0:1:2")),
    "equations": (("--model", "inertia_matrix"), ("--model", "inverse_dynamics", "--format", "html")),
    "singularities": ((), ("--component", "a.x")),
    "generate": ((), ("--base", "--force"), ("--form", "auto", "--force")),
    "report": (("--out", "pages", "--force"),),
    "check": (("--model", "inverse_dynamics"), ("--model", "inertia_matrix", "--proven", "--precision", "mixed")),
    "benchmark": (("--effort", "quick", "--model", "bias_forces", "--states", "1", "--rounds", "1"),),
    "linearize": ((), ("--hold", "all"), ("--as-given", "--at", "a=1")),
    "modes": ((), ("--hold", "all"), ("--along", "a=0:1:2", "--hold", "all"), ("--pd", "a=1e308:1e308")),
    "response": (
        ("--band", "1:9:3"),
        ("--hold", "all", "--band", "1:9:3"),
        ("--hold", "all", "--input", "b.fx", "--output", "b.x", "--band", "1:9:3"),
    ),
    "compare": (("--duration", "0.01"),),
    "control": ((),),
    "tune": (("--along", "a=0:1:2"),),
    "lobes": (("--direction", "b.x", "--cutting", "1e9", "--speeds", "1000:2000:3"),),
    "simulate": (
        ("--scene", "motion.toml", "--step", "0.01"),
        ("--scene", "motion.toml", "--adaptive"),
        ("--scene", "motion.toml", "--step", "0.01", "--method", "rodas4"),
    ),
    "reduce": (("--scene", "motion.toml"),),
    "ladder": (("--scene", "motion.toml"),),
    "sweep": (
        ("--over", "a=0:1:2", "--hold", "all"),
        ("--over", "a.mass=normal:2:0.1", "--samples", "2", "--of", "response", "--output", "b.x"),
    ),
    "feed-forward": (("--duration", "0.1", "--sample-rate", "50"),),
    "excite": ((*LIMITS, "--sample-rate", "20", "--out", "e.csv", "--force"),),
    "identify": (
        ("data.csv",),
        ("data.csv", "--validate", "data.csv", "--save", "found.toml", "--after", "0.1", "--resample", "50", "--force"),
        ("data.csv", "--load-friction", "all", "--link-side", "all", "--temperatures"),
        ("data.csv", "--possible", "--trust", "0.3", "--save", "found.toml", "--force"),
    ),
    "update": (("tests.toml",), ("tests.toml", "--seek", "a.mass", "--next", "--save", "found.toml", "--force")),
}
"""Options with which every command is called on every odd machine; several times where they change the way, and not
where it takes no machine, or goes on until it is ended."""
MOTION = """
[motion]
duration = 0.04
moves = [{ motor = "a", by = 0.1, in = 0.02 }]
[wanted]
tolerance = { "a.q" = 1e-3, "b.x" = 1e-3 }
"""
FEW = {"long_chain": ("show", "convert", "linearize")}
"""Commands that are called on a machine, where that is not every one."""
TRADED = ("no_joint", "fixed_bodies", "all_passive", "floating_only")
"""Machines that `benchmark` is called on, which compiles many times."""
REPORTED = ("no_joint", "all_passive", "no_values", "floating", "driven_in_space", "loaded")
"""Machines that `report` is called on, which does the work of many commands."""
UPDATED = ("no_joint", "all_fixed", "all_passive", "no_mass", "no_values", "floating", "driven", "bristles", "loaded")
"""Machines that `update` is called on, which looks for the springs of any tests for seconds."""
FEW_MACHINES = {"benchmark": TRADED, "report": REPORTED, "update": UPDATED}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_every_command_is_called() -> None:
    assert CALLS.keys() == cli.cli.commands.keys()


def odd_calls() -> Iterator[tuple[str, str]]:
    for machine in ODD:
        commands = FEW.get(machine, tuple(CALLS))
        yield from ((machine, command) for command in commands if machine in FEW_MACHINES.get(command, ODD))


@pytest.mark.sampled(200)
@pytest.mark.parametrize(("machine", "command"), list(odd_calls()))
def test_odd_machines_end_no_command_with_a_traceback(machine: str, command: str, tmp_path: Path) -> None:
    (tmp_path / "odd.toml").write_text(ODD[machine])
    rows = [f"{k / 100},{k % 7},{k % 5},{k % 3},{k % 2}" for k in range(200)]
    (tmp_path / "data.csv").write_text("\n".join(["t,q_a,q_b,tau_a,tau_b", *rows]))
    drives = "drives = true\n" if "[drives]" in ODD[machine] else ""
    (tmp_path / "motion.toml").write_text(MOTION.replace("[wanted]", f"{drives}[wanted]"))
    (tmp_path / "tests.toml").write_text('[[tests]]\nfile = "hammer.csv"\n')
    rows = [f"{k},{k % 7},{k % 5}" for k in range(1, 20)]
    (tmp_path / "hammer.csv").write_text("\n".join(["f [Hz],re b.ax/b.fx,im b.ax/b.fx", *rows]))
    for options in CALLS[command][: 1 if machine == "long_chain" else None]:
        refuse_leaks(ended(command, "odd.toml", *options))


PREFIXES = ("error: ", "warning: ", "note: ", "wrote ")


def refuse_leaks(found: Ended) -> None:
    """Exit code 0 or 1, or 2 with one line that says why."""
    errors = [line for line in found.err.splitlines() if line.startswith("error: ")]
    others = [line for line in found.err.splitlines() if not line.startswith(PREFIXES)]
    assert found.code in (0, 1, 2) and others == [] and len(errors) == (found.code == 2), found
    assert "Traceback" not in found.out + found.err


# JSON

READABLE = (".toml", ".par", ".urdf", *([".xml"] if find_spec("mujoco") else []))
MACHINES = sorted(path.name for path in EXAMPLES.iterdir() if path.suffix in READABLE)
ALIKE = (
    "all_keys.par",
    "backlash.toml",
    "ball_screw_rigid.toml",
    "four_bar.par",
    "puma560.par",
    "puma560_measured.toml",
    "rx90.par",
)
"""Like `all_keys.toml`, `ball_screw.toml`, `sr400.par` and `two_axis.toml`: only shown."""
JSON: dict[str, tuple[str, ...]] = {
    "show": (),
    "generate": ("--model", "inertia_matrix", "--target", "c"),
    "linearize": (),
    "evaluate": (),
    "stiffness": (),
    "modes": ("--hold", "all"),
    "response": ("--band", "1:9:3"),
    "compare": ("--duration", "0.01"),
    "feed-forward": ("--duration", "0.01", "--sample-rate", "500"),
    "control": ("--damping", "0.02"),
    "tune": ("--damping", "0.02"),
    "excite": (*LIMITS, "--sample-rate", "20", "--out", "e.csv"),
    "identify": ("data.csv",),
    "update": ("tests.toml",),
}
SLOW: dict[str, tuple[str, ...]] = {
    "check": ("--model", "inertia_matrix"),
    "ik": ("--position", "0.4,0.3,0"),
    "singularities": ("--component", "tip.x", "--component", "tip.y"),
    "lobes": ("--direction", "tip.x", "--cutting", "1e9", "--damping", "0.02"),
    "benchmark": ("--effort", "quick", "--model", "inertia_matrix", "--states", "1", "--rounds", "1"),
    "simulate": ("--scene", str(EXAMPLES / "scenes" / "planar_2r_move.toml"), "--step", "0.01"),
    "reduce": ("--scene", str(EXAMPLES / "scenes" / "planar_2r_move.toml"), "--for", "feed-forward"),
    "ladder": ("--scene", str(EXAMPLES / "scenes" / "planar_2r_move.toml")),
    "sweep": ("--over", "m2=1,2"),
}
"""Commands that compile, or need what is in one machine: called on one example only."""


def with_json() -> Iterator[tuple[str, str, tuple[str, ...]]]:
    for command, options in JSON.items():
        yield from ((command, machine, options) for machine in MACHINES if command == "show" or machine not in ALIKE)
    yield from ((command, "planar_2r.toml", options) for command, options in SLOW.items())


def strict(text: str) -> Any:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def test_every_command_with_json_is_called() -> None:
    takes = {name for name, command in cli.cli.commands.items() if any("--json" in p.opts for p in command.params)}
    assert takes == {*JSON, *SLOW, "models", "flexible"}


@pytest.mark.sampled(200)
@pytest.mark.parametrize(
    ("command", "machine", "options"), list(with_json()), ids=lambda x: x if isinstance(x, str) else ""
)
def test_json_is_one_strict_object_and_nothing_else(command: str, machine: str, options: tuple[str, ...]) -> None:
    if command in SLOW and not (shutil.which("gcc") or shutil.which("clang")):
        pytest.skip("needs a C compiler")
    found = ended(command, EXAMPLES / machine, *options, "--json")
    refuse_leaks(found)
    if found.code == 2 and not found.out:
        assert command not in SLOW
    else:
        assert isinstance(strict(found.out), dict) and found.out.count("\n") == 1


def test_the_list_of_models_is_one_strict_object() -> None:
    found = ended("models", "--json")
    assert found.code == 0 and isinstance(strict(found.out), dict) and found.err == ""
