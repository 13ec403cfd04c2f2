"""Processors of controllers by name, and how C is compiled for them."""

from __future__ import annotations

from dataclasses import dataclass

ARM = "arm-none-eabi-gcc"


@dataclass(frozen=True)
class Processor:
    """The compiler of a processor with its options, and the widest precision of its floating-point unit."""

    compiler: str
    flags: str
    precision: str


CONTROLLERS = {
    "cortex-m4": Processor(ARM, "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard", "single"),
    "cortex-m7": Processor(ARM, "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard", "double"),
    "cortex-m33": Processor(ARM, "-mcpu=cortex-m33 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard", "single"),
    "cortex-r5": Processor(ARM, "-mcpu=cortex-r5 -mthumb -mfpu=vfpv3-d16 -mfloat-abi=hard", "double"),
}
"""Processors of controllers by name."""
