"""FMUs in the hands of FMPy: variables by name, derivatives, steps, states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

MODEL_EXCHANGE, CO_SIMULATION = "ModelExchange", "CoSimulation"
CLASSES = {
    (2, MODEL_EXCHANGE): FMU2Model,
    (2, CO_SIMULATION): FMU2Slave,
    (3, MODEL_EXCHANGE): FMU3Model,
    (3, CO_SIMULATION): FMU3Slave,
}


class Running:
    """An instance of an FMU, in initialization mode until `begin`."""

    def __init__(self, path: Path, folder: str, kind: str, tolerance: float | None) -> None:
        self.description = read_model_description(str(path))
        self.version = int(self.description.fmiVersion[0])
        self.variables = {one.name: one for one in self.description.modelVariables}
        self.references = {name: one.valueReference for name, one in self.variables.items()}
        made = CLASSES[self.version, kind]
        identifier = self.description.modelExchange.modelIdentifier
        self.fmu: Any = made(
            guid=self.description.guid,
            unzipDirectory=extract(str(path), folder),
            modelIdentifier=identifier,
            instanceName="tested",
        )
        self.fmu.instantiate()
        if self.version == 2:
            self.fmu.setupExperiment(tolerance=tolerance, startTime=0.0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=0.0)

    def begin(self) -> None:
        self.fmu.exitInitializationMode()

    def named(self, causality: str) -> list[str]:
        return [name for name, one in self.variables.items() if one.causality == causality]

    @property
    def states(self) -> list[str]:
        return [one.variable.derivative.name for one in self.description.derivatives]

    @property
    def rates(self) -> list[str]:
        return [one.variable.name for one in self.description.derivatives]

    def nominals(self) -> np.ndarray:
        return np.array([float(self.variables[name].nominal) for name in self.states])

    def get(self, names: Sequence[str]) -> np.ndarray:
        read = self.fmu.getReal if self.version == 2 else self.fmu.getFloat64
        return np.array(read([self.references[name] for name in names]))

    def set(self, values: Mapping[str, float]) -> None:
        write = self.fmu.setReal if self.version == 2 else self.fmu.setFloat64
        write([self.references[name] for name in values], list(values.values()))

    def along(self, unknowns: Sequence[str], seeds: Mapping[str, float]) -> np.ndarray:
        known = [self.references[name] for name in seeds]
        unknown = [self.references[name] for name in unknowns]
        return np.array(self.fmu.getDirectionalDerivative(unknown, known, list(seeds.values())))

    def step(self, time: float, size: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def state(self) -> Any:
        return self.fmu.getFMUstate() if self.version == 2 else self.fmu.getFMUState()

    def go_back(self, state: Any) -> None:
        (self.fmu.setFMUstate if self.version == 2 else self.fmu.setFMUState)(state)

    def as_bytes(self, state: Any) -> bytes:
        return bytes((self.fmu.serializeFMUstate if self.version == 2 else self.fmu.serializeFMUState)(state))

    def of_bytes(self, text: bytes) -> Any:
        return (self.fmu.deSerializeFMUstate if self.version == 2 else self.fmu.deserializeFMUState)(text)


@contextmanager
def running(path: Path, kind: str = MODEL_EXCHANGE, tolerance: float | None = None) -> Iterator[Running]:
    with TemporaryDirectory() as folder:
        one = Running(path, folder, kind, tolerance)
        yield one
        one.fmu.freeInstance()
