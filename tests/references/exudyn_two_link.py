"""Two flexible links under torques by Exudyn: ANCF cable elements, an absolute formulation. Needs `exudyn`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array

Torque = Callable[[float], float]
Link = tuple[float, float, float, float]
"""Length, m, EI, N m2, EA, N, and mass per length, kg/m."""


def path_of_tool(
    links: tuple[Link, Link], masses: tuple[float, float], torques: Sequence[Torque], end: float, steps: int
) -> tuple[Array, Array]:
    """Return times and positions (N, 2) of the tool, from a straight arm along x at rest.

    `masses` are points at the elbow and at the tool; torques act on the first link, and between both.
    """
    import exudyn as exu
    from exudyn.beams import GenerateStraightLineANCFCable2D
    from exudyn.itemInterface import (
        Cable2D,
        CoordinateConstraint,
        LoadCoordinate,
        MarkerNodeCoordinate,
        MassPoint2D,
        NodePoint2D,
        SensorNode,
    )

    system = exu.SystemContainer().AddSystem()
    nodes: list[Any] = []
    start = 0.0
    for length, EI, EA, mass in links:
        cable = Cable2D(physicsMassPerLength=mass, physicsBendingStiffness=EI, physicsAxialStiffness=EA)
        ends: dict[str, Any] = {"positionOfNode0": [start, 0, 0], "positionOfNode1": [start + length, 0, 0]}
        start += length
        nodes.append(
            GenerateStraightLineANCFCable2D(
                system, **ends, numberOfElements=6, cableTemplate=cable, massProportionalLoad=[0, 0, 0],
                fixedConstraintsNode0=[0, 0, 0, 0] if nodes else [1, 1, 0, 0],
            )[0]
        )  # fmt: skip

    def marker(node: int, coordinate: int) -> Any:
        return system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def tie(first: int, second: int) -> None:
        for k in range(2):
            system.AddObject(CoordinateConstraint(markerNumbers=[marker(first, k), marker(second, k)]))

    def turn(node: int, torque: Torque) -> None:
        """A torque on a node by its slope r' = (1 + a, b): it turns by ((1 + a) db - b da)/|r'|^2."""
        for k in range(2):

            def force(mbs: Any, t: float, _load: float, k: int = k) -> float:
                a, b = mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)[2:]
                return float(torque(t) * (-b, 1 + a)[k] / ((1 + a) ** 2 + b**2))

            system.AddLoad(LoadCoordinate(markerNumber=marker(node, 2 + k), load=1.0, loadUserFunction=force))

    (shoulder, *_, tip), (elbow, *_, tool) = nodes
    tie(tip, elbow)
    for node, mass, x in ((elbow, masses[0], links[0][0]), (tool, masses[1], start)):
        point = system.AddNode(NodePoint2D(referenceCoordinates=[x, 0]))
        system.AddObject(MassPoint2D(physicsMass=mass, nodeNumber=point))
        tie(node, point)
    turn(shoulder, torques[0])
    turn(tip, lambda t: -torques[1](t))
    turn(elbow, torques[1])
    sensor = system.AddSensor(
        SensorNode(nodeNumber=tool, storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
    )
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = steps, end
    settings.solutionSettings.writeSolutionToFile = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    system.SolveDynamic(settings)
    data = np.array(system.GetSensorStoredData(sensor))
    return data[:, 0], data[:, 1:3]
