"""Joints and machines may have names that languages use: generated code avoids the clash, or has them in texts only."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.targets import KEYWORDS, RESERVED, TARGETS
from symoro_elastic.machine.names import FORMULA, MACROS_OF_COMPILERS, why_no_joint, why_no_machine
from symoro_elastic.models.packaging import reserved_words
from tests.command_line import EXAMPLES

ARM = (EXAMPLES / "planar_2r.toml").read_text()


def renamed(folder: Path, machine: str, first: str, second: str) -> Path:
    text = ARM.replace('"shoulder"', f'"{first}"').replace('"elbow"', f'"{second}"')
    text = text.replace("\nshoulder ", f"\n{first} ").replace("\nelbow ", f"\n{second} ")
    path = folder / "named.toml"
    path.write_text(text.replace('name = "planar_2r"', f'name = "{machine}"'))
    return path


def test_joints_may_be_called_as_words_of_languages() -> None:
    words = reserved_words()
    plain = [name for name in (*KEYWORDS, *RESERVED) if re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name, re.ASCII)]
    refused = {name for name in plain if why_no_joint(name, words)}
    assert len(plain) > 200 and refused <= {*FORMULA, "all", "p", "c"}
    for name in ("all", "q", "tau", "pi", "a b", "direct_dynamics"):
        assert why_no_joint(name, words)


def test_machines_may_be_called_as_macros_of_compilers() -> None:
    words = reserved_words()
    assert all(why_no_machine(name, words) is None for name in MACROS_OF_COMPILERS)
    assert all(why_no_machine(name, words) for name in ("math", "numpy", "class", "double", "exp", "qdd"))


@pytest.mark.thorough
@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("machine", "joints"), [("far", ("near", "double")), ("main", ("class", "exp")), ("huge", ("end", "list"))]
)
def test_code_for_such_names_compiles_and_has_the_same_numbers(
    machine: str, joints: tuple[str, str], tmp_path: Path
) -> None:
    path = renamed(tmp_path, machine, *joints)
    assert [joint.name for joint in se.read(path).motor_joints] == [*joints]
    targets = [*TARGETS]
    se.generate(path, "direct_dynamics", "inverse_dynamics", "jacobian", targets=targets, out=tmp_path, steps=["w3"])
    folder, macros = tmp_path / machine, [f"-D{word}=" for word in ("far", "near", "huge")]
    for compiler, name, language in (("gcc", f"{machine}.c", "c"), ("g++", f"{machine}.hpp", "c++")):
        if shutil.which(compiler):
            command = [compiler, *macros, "-Wall", "-Werror", "-fsyntax-only", "-x", language, name]
            command += ["-Wno-pragma-once-outside-header"] if language == "c++" else []
            ran = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert ran.returncode == 0, ran.stderr
    state = np.array([0.3, -0.2]), np.array([0.1, 0.4]), np.array([1.0, 2.0])
    found, expected = (
        se.load(x, "direct_dynamics").direct_dynamics(*state) for x in (path, EXAMPLES / "planar_2r.toml")
    )
    np.testing.assert_array_equal(found, expected)
