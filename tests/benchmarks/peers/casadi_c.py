"""CasADi: C generated from Pinocchio's algorithms on its expressions, common subexpressions eliminated.

Derivatives are CasADi's own: Jacobians of those expressions by automatic differentiation.
"""

from __future__ import annotations

import ctypes
import importlib.util
import math
import re
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.benchmarks.contest import BUILD, Array, Contestant, compiled, entry, timed
from tests.benchmarks.ours import FAST, NATIVE, places
from tests.benchmarks.peers.pinocchio_cpp import headers, sources

PREAMBLE = """
int model(const double **, double **, long long *, double *, int);
static long long iw[4096];
static double w[65536];
"""
FUNCTION = re.compile(r"/\* model:\((.*?)\)->\((.*?)\) \*/\n(.*?)\n}\n", re.DOTALL)
SIGNS: Sequence[str] = (r"=\s*\(a\d+\s*[-+*/]\s*a\d+\)", r"=\s*\([-+.\deE]+\s*[-+*/]\s*a\d+\)", r"casadi_sq\(")


@dataclass(frozen=True)
class Generated:
    """C text of the function `model`, its sizes as its comment tells them."""

    text: str

    @property
    def call(self) -> str:
        """C that computes `result` from the entries of `row`; the work array is one of CasADi's."""
        given, found = ", ".join(places("row", self.inputs)), ", ".join(places("result", self.results))
        return f"const double *in[] = {{{given}}}; double *out[] = {{{found}}}; model(in, out, iw, w, 0);"

    @property
    def inputs(self) -> list[int]:
        return _sizes(self._parts[0])

    @property
    def results(self) -> list[int]:
        return _sizes(self._parts[1])

    @property
    def operations(self) -> int:
        """Products, divisions, sums and differences."""
        return sum(len(re.findall(sign, self._parts[2])) for sign in SIGNS)

    @property
    def _parts(self) -> Sequence[str]:
        """Arguments, results, body."""
        found = FUNCTION.search(self.text)
        assert found, "no function of that name"
        return found.groups()


def _sizes(declared: str) -> list[int]:
    return [math.prod(int(n) for n in size.split("x")) for size in re.findall(r"\[([\dx]+)\]", declared)]


def contestant(code: Generated, x: Array, compiler: str) -> Contestant:
    """Compiled like the code it is compared with."""
    results = sum(code.results)
    text = timed(PREAMBLE, code.call, sum(code.inputs), results)
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


def generated(model_file: Path, model: str) -> Generated:
    """A model of a machine, by the name it has here."""
    name = f"casadi_{model_file.stem}_{model}"
    subprocess.run([str(generator()), str(model_file), model, name], cwd=BUILD, capture_output=True, check=True)
    return Generated((BUILD / f"{name}.c").read_text(encoding="utf-8"))
