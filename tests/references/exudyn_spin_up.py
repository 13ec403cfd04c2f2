"""The spin-up of a beam by Exudyn: ANCF cable elements, an absolute formulation without modes. Needs `exudyn`."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array


def lag_of_tip(
    angle: Callable[[float], float], length: float, EI: float, EA: float, mass: float, end: float, elements: int = 6
) -> tuple[Array, Array]:
    """Return times and how far the tip is ahead of the turning root's axis, m, by 50 steps a second."""
    import exudyn as exu
    from exudyn.beams import GenerateStraightLineANCFCable2D
    from exudyn.itemInterface import Cable2D, CoordinateConstraint, MarkerNodeCoordinate, NodePointGround, SensorNode

    system = exu.SystemContainer().AddSystem()
    cable = Cable2D(physicsMassPerLength=mass, physicsBendingStiffness=EI, physicsAxialStiffness=EA)
    ends: dict[str, Any] = {"positionOfNode0": [0, 0, 0], "positionOfNode1": [length, 0, 0]}
    made = GenerateStraightLineANCFCable2D(
        system, **ends, numberOfElements=elements, cableTemplate=cable,
        massProportionalLoad=[0, 0, 0], fixedConstraintsNode0=[1, 1, 0, 0],
    )  # fmt: skip
    nodes = made[0]
    ground = system.AddMarker(MarkerNodeCoordinate(nodeNumber=system.AddNode(NodePointGround()), coordinate=0))
    for coordinate, slope in ((2, lambda t: cos(angle(t)) - 1), (3, lambda t: sin(angle(t)))):
        marker = system.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        offset = {"offsetUserFunction": lambda _mbs, t, _item, _offset, slope=slope: slope(t)}
        system.AddObject(CoordinateConstraint(markerNumbers=[ground, marker], **offset))
    tip = SensorNode(nodeNumber=nodes[-1], storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
    sensor = system.AddSensor(tip)
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = int(50 * end), end
    settings.solutionSettings.writeSolutionToFile = False
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.8
    settings.timeIntegration.newton.useModifiedNewton = True
    system.SolveDynamic(settings)
    t, x, y = np.array(system.GetSensorStoredData(sensor))[:, :3].T
    turned = np.array([angle(at) for at in t])
    return t, -np.sin(turned) * x + np.cos(turned) * y
