"""Components of LinuxCNC in tests: compiled against a stub of HAL, by halcompile where it is there, else as its C.

`HALCOMPILE` names the program, installed or in an unpacked package with `include/linuxcnc` and `lib/python3` beside it.
"""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]
HALCOMPILE = os.environ.get("HALCOMPILE") or shutil.which("halcompile")
needs_halcompile = pytest.mark.skipif(HALCOMPILE is None, reason="needs halcompile (package linuxcnc-uspace-dev)")
STUB = r"""
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef void (*function)(void *, long);
static struct { char name[64]; void *at; } pins[200];
static int count;
static function own;
static void *instance;
int hal_init(const char *name) { (void)name; return 1; }
int hal_ready(int id) { (void)id; return 0; }
int hal_exit(int id) { (void)id; return 0; }
void *hal_malloc(long size) { return calloc(1, size); }
static int made(void **at, const char *format, va_list list)
{
    vsnprintf(pins[count].name, sizeof pins[count].name, format, list);
    *at = pins[count++].at = calloc(1, 8);
    return 0;
}
int hal_pin_float_newf(int way, void **at, int id, const char *format, ...)
{
    va_list list;
    (void)way; (void)id;
    va_start(list, format);
    return made(at, format, list);
}
int hal_pin_s32_newf(int way, void **at, int id, const char *format, ...)
{
    va_list list;
    (void)way; (void)id;
    va_start(list, format);
    return made(at, format, list);
}
int hal_pin_bit_newf(int way, void **at, int id, const char *format, ...)
{
    va_list list;
    (void)way; (void)id;
    va_start(list, format);
    return made(at, format, list);
}
int hal_export_funct(const char *name, function f, void *inst, int fp, int reentrant, int id)
{
    (void)name; (void)reentrant; (void)id;
    own = f;
    instance = inst;
    return fp ? 0 : -1;
}
int rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    return vsnprintf(to, size, format, list);
}
void rtapi_print_msg(int level, const char *format, ...) { (void)level; (void)format; }
void rtapi_print(const char *format, ...) { (void)format; }
void reset(void) { count = 0; }
void run(void) { own(instance, 1000000); }
void *pin(const char *name)
{
    for (int k = 0; k < count; k++) {
        if (strcmp(pins[k].name, name) == 0) {
            return pins[k].at;
        }
    }
    return 0;
}
"""
KINEMATICS = """
typedef struct { double x, y, z; } PmCartesian;
typedef struct { PmCartesian tran; double a, b, c, u, v, w; } EmcPose;
typedef enum { KINEMATICS_BOTH = 4 } KINEMATICS_TYPE;
typedef unsigned long KINEMATICS_FORWARD_FLAGS, KINEMATICS_INVERSE_FLAGS;
#define KINS_NOT_SWITCHABLE
#define EXPORT_SYMBOL(x) extern int exported_##x
"""
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wframe-larger-than=2560")


@dataclass
class Component:
    """A loaded component: its pins by name, its function, kinematics where it has them."""

    library: ctypes.CDLL
    hal: ctypes.CDLL
    name: str
    _pins: dict[str, Any] = field(default_factory=dict)

    def _pin(self, name: str, type_: Any) -> Any:
        if name not in self._pins:
            at = self.hal.pin(f"{self.name.replace('_', '-')}.{name}".encode())
            assert at, name
            self._pins[name] = ctypes.cast(at, ctypes.POINTER(type_))
        return self._pins[name]

    def torques(self, states: Mapping[str, Array], motors: int) -> Array:
        """Return tau (N, motors) for arrays (N, entries) on pins q, qd, qdd."""
        pins = [(self._pin(f"{x}{k}", ctypes.c_double), a[:, k]) for x, a in states.items() for k in range(a.shape[1])]
        tau = [self._pin(f"tau{k}", ctypes.c_double) for k in range(motors)]
        found = np.empty((len(next(iter(states.values()))), motors))
        for number, row in enumerate(found):
            for at, column in pins:
                at[0] = column[number]
            self.hal.run()
            row[:] = [at[0] for at in tau]
        return found

    def controlled(self, enable: bool, given: Mapping[str, Array], motors: int) -> Array:
        """Return u (motors,) for arrays (motors,) on pins, after one call."""
        self._pin("enable", ctypes.c_uint8)[0] = enable
        for name, values in given.items():
            for k, x in enumerate(values):
                self._pin(f"{name}{k}", ctypes.c_double)[0] = x
        self.hal.run()
        return np.array([self._pin(f"u{k}", ctypes.c_double)[0] for k in range(motors)])

    def branch(self, number: int) -> None:
        """Set the pin that chooses a solution."""
        self._pin("branch", ctypes.c_int32)[0] = number

    def forward(self, joint: Array) -> Array:
        """Return x y z a b c."""
        pose = np.full(9, np.nan)
        assert self.library.kinematicsForward(_at(joint), _at(pose), None, None) == 0
        return pose[:6]

    def inverse(self, pose: Array, joint: Array) -> bool:
        """Return whether the pose is reached; `joint` becomes the joints then."""
        return bool(
            self.library.kinematicsInverse(_at(np.concatenate([pose, np.zeros(3)])), _at(joint), None, None) == 0
        )


def _at(array: Array) -> Any:
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)


def _loaded(library: Path, name: str) -> Component:
    """Load a component, whose pins take the place of those of the last one."""
    hal = _hal()
    hal.reset()
    made = ctypes.CDLL(str(library))
    assert made.rtapi_app_main() == 0
    return Component(made, hal, name)


@cache
def _hal() -> ctypes.CDLL:
    """Load the stub of HAL, once: components find its functions in the process."""
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "stub.c"), Path(folder, "stub.so")
        source.write_text(STUB)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
        hal = ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    hal.pin.restype = ctypes.c_void_p
    return hal


def by_halcompile(text: str, name: str, folder: Path) -> Component:
    """Return a component that halcompile has compiled without a remark; it is called in this process."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.comp").write_text(text)
    assert HALCOMPILE
    beside = Path(HALCOMPILE).resolve().parents[1]
    more = {"C_INCLUDE_PATH": f"{beside}/include/linuxcnc", "PYTHONPATH": f"{beside}/lib/python3/dist-packages"}
    command = [HALCOMPILE, "--compile", f"{name}.comp"]
    run = subprocess.run(command, cwd=folder, env=os.environ | more, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "warning" not in run.stderr, run.stderr
    return _loaded(folder / f"{name}.so", name)


def by_own(text: str, name: str, folder: Path) -> Component:
    """Return a component whose C is compiled strictly, with pins as halcompile makes them."""
    folder.mkdir(parents=True, exist_ok=True)
    declared, _, code = text.partition("\n;;\n")
    pins = re.findall(r"^pin (in|out) (float|s32|bit) ([\w-]+)#?(?:\[(\d+)\])?(?: = (-?\d+))?", declared, re.MULTILINE)
    types = {"float": "double", "s32": "int", "bit": "unsigned char"}
    made = {of: kind for kind, of in types.items()}
    lines = ["#include <string.h>", "#include <stdio.h>", "struct __comp_state {"]
    names = [(way, types[kind], re.sub(r"[-._]*#+", "", pin).strip("-").replace("-", "_"), size, value, pin.rstrip("#"))
             for way, kind, pin, size, value in pins]  # fmt: skip
    lines += [f"    {kind} *{pin}[{size or 1}];" for _, kind, pin, size, _, _ in names]
    lines += ["};", "static struct __comp_state own;", "struct __comp_state *__comp_first_inst = &own;"]
    lines += [*HAL_OF_STUB, "int rtapi_app_main(void) {"]
    for _, kind, pin, size, value, hal in names:
        label = f'"{name.replace("_", "-")}.{hal}{"%d" if size else ""}"'
        lines.append(f"    for (int j = 0; j < {size or 1}; j++) {{")
        lines.append(f"        hal_pin_{made[kind]}_newf(0, (void **)&own.{pin}[j], 1, {label}, j);")
        lines.append(f"        *own.{pin}[j] = {value or 0};\n    }}")
    lines += ["    own_function();", "    return 0;", "}"]
    for way, _, pin, size, _, _ in names:
        head, entry = (f"{pin}(i)", "[i]") if size else (pin, "[0]")
        lines.append(f"#define {head} ({'0+' if way == 'in' else ''}*__comp_inst->{pin}{entry})")
    lines += ["#define FUNCTION(name) static void name(struct __comp_state *__comp_inst, long period)"]
    has_function = "FUNCTION(" in code
    ending = ['static void own_function(void) { hal_export_funct("f", (void (*)(void *, long))_, &own, 1, 0, 1); }']
    ending = ending if has_function else ["static void own_function(void) { }"]
    (folder / "kinematics.h").write_text(KINEMATICS)
    (folder / f"{name}.c").write_text("\n".join([*lines, code, *ending]) + "\n")
    library = folder / f"{name}.so"
    command = ["cc", *STRICT, "-Os", "-ffp-contract=off", f"-I{folder}", "-shared", "-fPIC", "-o", str(library)]
    run = subprocess.run([*command, str(folder / f"{name}.c"), "-lm"], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-3000:]
    return _loaded(library, name)


HAL_OF_STUB = (
    "int hal_pin_float_newf(int, void **, int, const char *, ...);",
    "int hal_pin_s32_newf(int, void **, int, const char *, ...);",
    "int hal_pin_bit_newf(int, void **, int, const char *, ...);",
    "int hal_export_funct(const char *, void (*)(void *, long), void *, int, int, int);",
    "static void own_function(void);",
)
