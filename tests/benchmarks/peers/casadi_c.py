"""CasADi: C generated from Pinocchio's algorithms on its expressions, common subexpressions eliminated.

Derivatives are CasADi's own: Jacobians of those expressions by automatic differentiation. The inverse model is written
as a recursion in three-vectors, too, which needs fewer operations than Pinocchio's in six.
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
from typing import Any

import numpy as np

from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import BUILD, Array, Contestant, compiled, entry, timed
from tests.benchmarks.ours import FAST, NATIVE, places
from tests.benchmarks.peers.pinocchio_cpp import headers, sources
from tests.references.pinocchio_model import model_of

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


def contestant(code: Generated, x: Array, compiler: str, what: str = "CasADi") -> Contestant:
    """Compiled like the code it is compared with."""
    results = sum(code.results)
    text = timed(PREAMBLE, code.call, sum(code.inputs), results)
    library = compiled([compiler, *FAST, *NATIVE], {"generated.c": code.text, "contest.c": text}, ["-lm"])
    y = np.empty((len(x), results))
    return Contestant(f"{what}, {compiler}", entry(ctypes.CDLL(str(library))), x, y, lambda y: y, len(x))


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


def recursion(machine: Machine) -> Generated:
    """The inverse model of a machine whose joints all are motors: Newton-Euler recursions in three-vectors."""
    import casadi as ca

    model, _, numbers = model_of(machine)
    rows = [numbers.joints[j] for j in numbers.moving]
    q, qd, qdd = (ca.SX.sym(name, len(rows)) for name in ("q", "qd", "qdd"))
    zero, z = ca.SX.zeros(3), ca.SX([0, 0, 1])
    w, wd, a = [zero], [zero], [ca.SX(-model.gravity.linear)]
    forces, moments, turns, places = [zero], [zero], [zero], [zero]
    for k, row in enumerate(rows):
        i, place = model.parents[k + 1], model.jointPlacements[k + 1]
        P, p = ca.SX(np.round(place.rotation, 15)), ca.SX(np.round(place.translation, 15))
        turn, slide = (1, 0) if row.sigma == 0 else (0, 1)
        R, p = P @ _about_z(turn * q[k]), p + slide * (P @ z * q[k])
        before = R.T @ w[i]
        w.append(before + turn * z * qd[k])
        wd.append(R.T @ wd[i] + turn * (z * qdd[k] + ca.cross(before, z) * qd[k]))
        at = R.T @ (a[i] + ca.cross(wd[i], p) + ca.cross(w[i], ca.cross(w[i], p)))
        a.append(at + slide * (z * qdd[k] + 2 * ca.cross(before, z) * qd[k]))
        force, moment = _of_body(model.inertias[k + 1], w[-1], wd[-1], a[-1])
        forces.append(force)
        moments.append(moment)
        turns.append(R)
        places.append(p)
    tau = [zero] * len(rows)
    for k, row in reversed([*enumerate(rows)]):
        i, along = model.parents[k + 1], moments[k + 1][2] if row.sigma == 0 else forces[k + 1][2]
        tau[k] = along + row.rotor_inertia * qdd[k] + row.stiffness * (q[k] - row.neutral) + row.damping * qd[k]
        carried = turns[k + 1] @ forces[k + 1]
        forces[i] = forces[i] + carried
        moments[i] = moments[i] + turns[k + 1] @ moments[k + 1] + ca.cross(places[k + 1], carried)
    code = ca.CodeGenerator(f"{machine.name}_recursion.c")
    code.add(ca.Function("model", [q, qd, qdd], [ca.vertcat(*tau)], {"cse": True}))
    return Generated(code.dump())


def _about_z(angle: Any) -> Any:
    """Return the rotation about z."""
    import casadi as ca

    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def _of_body(inertia: Any, w: Any, wd: Any, a: Any) -> tuple[Any, Any]:
    """Return the force and the moment at the frame of a body, from the motion of the frame."""
    import casadi as ca

    m, S = float(inertia.mass), ca.SX(np.array(inertia.lever))
    across = np.cross(np.eye(3), inertia.lever)
    J = ca.SX(np.array(inertia.inertia - inertia.mass * across @ across))
    force = m * (a + ca.cross(wd, S) + ca.cross(w, ca.cross(w, S)))
    return force, J @ wd + ca.cross(w, J @ w) + m * ca.cross(S, a)
