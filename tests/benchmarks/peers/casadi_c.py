"""CasADi: C generated from Pinocchio's algorithms on its expressions, common subexpressions eliminated."""

from __future__ import annotations

import ctypes
import importlib.util
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.benchmarks.contest import BUILD, Array, Contestant, compiled, entry, timed
from tests.benchmarks.ours import FAST, NATIVE
from tests.benchmarks.peers.pinocchio_cpp import headers, sources

FUNCTIONS = {"inverse_dynamics": "inverse", "direct_dynamics": "direct", "inertia_matrix": "inertia_matrix"}
ARGUMENTS = {"inverse_dynamics": 3, "direct_dynamics": 3, "inertia_matrix": 1}


@dataclass(frozen=True)
class Generated:
    """C text with the functions of `FUNCTIONS`, and their operations as CasADi counts its instructions."""

    text: str
    operations: dict[str, int]

    def call(self, model: str, joints: int) -> str:
        """C that computes `result` from the entries of `row`; the work array is one of CasADi's."""
        parts = ", ".join(f"row + {k * joints}" for k in range(ARGUMENTS[model]))
        return f"const double *in[] = {{{parts}}}; double *out[] = {{result}}; {FUNCTIONS[model]}(in, out, iw, w, 0);"


PREAMBLE = """
int inverse(const double **, double **, long long *, double *, int);
int direct(const double **, double **, long long *, double *, int);
int inertia_matrix(const double **, double **, long long *, double *, int);
static long long iw[4096];
static double w[65536];
"""


def contestant(code: Generated, model: str, x: Array, joints: int, results: int, compiler: str) -> Contestant:
    """One of `FUNCTIONS`, compiled like the code it is compared with."""
    text = timed(PREAMBLE, code.call(model, joints), x.shape[1], results)
    library = compiled([compiler, *FAST, *NATIVE], {"generated.c": code.text, "contest.c": text}, ["-lm"])
    y = np.empty((len(x), results))
    return Contestant(f"CasADi, {compiler}", entry(ctypes.CDLL(str(library))), x, y, lambda y: y, len(x))


def generator() -> Path:
    """The program that writes C; about two minutes to compile, once."""
    found = importlib.util.find_spec("casadi")
    assert found and found.submodule_search_locations
    folder = Path(next(iter(found.submodule_search_locations)))
    command = ["g++", "-O0", *headers(), f"-isystem{folder / 'include'}"]
    after = [f"-L{folder}", "-lcasadi", f"-Wl,-rpath,{folder}"]
    return compiled(command, sources("pinocchio_casadi.cpp"), after, product="generator")


def generated(model_file: Path) -> Generated:
    """The models of a machine."""
    name = f"casadi_{model_file.stem}"
    done = subprocess.run(
        [str(generator()), str(model_file), name], cwd=BUILD, capture_output=True, text=True, check=True
    )
    text = (BUILD / f"{name}.c").read_text(encoding="utf-8")
    return Generated(text, {line.split()[0]: operations(text, line.split()[0]) for line in done.stdout.splitlines()})


def operations(text: str, function: str) -> int:
    """Products, divisions, sums and differences of one function of CasADi's C."""
    found = re.search(rf"/\* {function}:.*?\n(.*?)\n}}\n", text, re.DOTALL)
    assert found, f"no function {function}"
    return sum(len(re.findall(sign, found[1])) for sign in SIGNS)


SIGNS: Sequence[str] = (r"=\s*\(a\d+\s*[-+*/]\s*a\d+\)", r"=\s*\([-+.\deE]+\s*[-+*/]\s*a\d+\)", r"casadi_sq\(")
