"""The device of the driver of NVIDIA, called by ctypes: memory, kernels, times."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import byref, c_char_p, c_float, c_int, c_size_t, c_uint, c_uint64, c_void_p
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array

DRIVERS = ("libcuda.so.1", "nvcuda.dll")
MAJOR, MINOR = 75, 76
"""Numbers of the attributes that are the compute capability of a device."""
POINTER = c_uint64
"""An address on a device."""
SIGNATURES: dict[str, tuple[Any, ...]] = {
    "cuInit": (c_uint,),
    "cuDeviceGetCount": (c_void_p,),
    "cuDeviceGet": (c_void_p, c_int),
    "cuDeviceGetName": (c_char_p, c_int, c_int),
    "cuDeviceGetAttribute": (c_void_p, c_int, c_int),
    "cuDevicePrimaryCtxRetain": (c_void_p, c_int),
    "cuCtxSetCurrent": (c_void_p,),
    "cuCtxSynchronize": (),
    "cuModuleLoadData": (c_void_p, c_char_p),
    "cuModuleGetFunction": (c_void_p, c_void_p, c_char_p),
    "cuMemAlloc_v2": (c_void_p, c_size_t),
    "cuMemFree_v2": (POINTER,),
    "cuMemcpyHtoD_v2": (POINTER, c_void_p, c_size_t),
    "cuMemcpyDtoH_v2": (c_void_p, POINTER, c_size_t),
    "cuLaunchKernel": (c_void_p, *[c_uint] * 7, c_void_p, c_void_p, c_void_p),
    "cuEventCreate": (c_void_p, c_uint),
    "cuEventRecord": (c_void_p, c_void_p),
    "cuEventSynchronize": (c_void_p,),
    "cuEventElapsedTime": (c_void_p, c_void_p, c_void_p),
    "cuEventDestroy_v2": (c_void_p,),
}
Launch = Callable[[], None]


class DriverError(Exception):
    """The driver refused; the message names the function and the reason."""


@dataclass(frozen=True)
class OnDevice:
    """An array in the memory of the device, like one of numpy."""

    address: POINTER
    shape: tuple[int, ...]
    dtype: Any

    @property
    def bytes(self) -> int:
        return int(np.prod(self.shape)) * np.dtype(self.dtype).itemsize


class Device:
    """The first device; raises `DriverError` where there is none."""

    def __init__(self) -> None:
        self.driver = _driver()
        count, device, context = c_int(), c_int(), c_void_p()
        self._do("cuInit", 0)
        self._do("cuDeviceGetCount", byref(count))
        if not count.value:
            raise DriverError("no device")
        self._do("cuDeviceGet", byref(device), 0)
        name = ctypes.create_string_buffer(256)
        self._do("cuDeviceGetName", name, len(name), device)
        self.name = name.value.decode()
        self.major, self.minor = (self._attribute(which, device) for which in (MAJOR, MINOR))
        self._do("cuDevicePrimaryCtxRetain", byref(context), device)
        self._do("cuCtxSetCurrent", context)

    def architecture(self, known: Sequence[int]) -> int:
        """The newest of the architectures whose code the device runs: those of its generation, none newer."""
        own = 10 * self.major + self.minor
        return max(one for one in known if one // 10 == self.major and one <= own)

    def loaded(self, cubin: bytes) -> c_void_p:
        """Machine code on the device."""
        module = c_void_p()
        self._do("cuModuleLoadData", byref(module), cubin)
        return module

    def empty(self, shape: Sequence[int], dtype: Any) -> OnDevice:
        """An array of which nothing is set."""
        address, found = POINTER(), OnDevice(POINTER(), tuple(shape), dtype)
        self._do("cuMemAlloc_v2", byref(address), max(1, found.bytes))
        return OnDevice(address, found.shape, dtype)

    def sent(self, array: Array) -> OnDevice:
        """A copy of an array."""
        found = self.empty(array.shape, array.dtype)
        self.send(array, found)
        return found

    def send(self, array: Array, to: OnDevice) -> None:
        """Copy an array to the device."""
        whole = np.ascontiguousarray(array, to.dtype)
        self._do("cuMemcpyHtoD_v2", to.address, whole.ctypes.data, whole.nbytes)

    def fetched(self, array: OnDevice) -> Array:
        """A copy of an array of the device."""
        found = np.empty(array.shape, array.dtype)
        self._do("cuMemcpyDtoH_v2", found.ctypes.data, array.address, found.nbytes)
        return found

    def free(self, *arrays: OnDevice) -> None:
        """Give memory back."""
        for array in arrays:
            self._do("cuMemFree_v2", array.address)

    def launcher(self, module: c_void_p, kernel: str, blocks: int, threads: int, *arguments: Any) -> Launch:
        """A call of a kernel with arrays of the device and numbers of ctypes."""
        function = c_void_p()
        self._do("cuModuleGetFunction", byref(function), module, kernel.encode())
        values = [one.address if isinstance(one, OnDevice) else one for one in arguments]
        places = (c_void_p * len(values))(*(ctypes.addressof(value) for value in values))
        grid = (blocks, 1, 1, threads, 1, 1, 0)
        launch = partial(self._do, "cuLaunchKernel", function, *grid, None, places, None)
        launch.values = values  # type: ignore[attr-defined]  # kept: `places` points at them
        return launch

    def seconds(self, launch: Launch, times: int) -> float:
        """The time of a call among `times` in a row."""
        start, end, ms = c_void_p(), c_void_p(), c_float()
        for event in (start, end):
            self._do("cuEventCreate", byref(event), 0)
        self._do("cuEventRecord", start, None)
        for _ in range(times):
            launch()
        self._do("cuEventRecord", end, None)
        self._do("cuEventSynchronize", end)
        self._do("cuEventElapsedTime", byref(ms), start, end)
        for event in (start, end):
            self._do("cuEventDestroy_v2", event)
        return 1e-3 * ms.value / times

    def wait(self) -> None:
        """Wait until all is done that was launched."""
        self._do("cuCtxSynchronize")

    def _attribute(self, which: int, device: c_int) -> int:
        value = c_int()
        self._do("cuDeviceGetAttribute", byref(value), which, device)
        return value.value

    def _do(self, function: str, *arguments: Any) -> None:
        result = getattr(self.driver, function)(*arguments)
        if result:
            text = c_char_p()
            self.driver.cuGetErrorString(result, byref(text))
            raise DriverError(f"{function}: {(text.value or b'unknown').decode()}")


def _driver() -> ctypes.CDLL:
    for name in DRIVERS:
        try:
            driver = ctypes.CDLL(name)
        except OSError:
            continue
        for function, types in SIGNATURES.items():
            getattr(driver, function).argtypes = list(types)
        return driver
    raise DriverError(f"no driver of NVIDIA ({DRIVERS[0]})")
