"""The mechanism of `peers_model` for Exudyn, in the form it is fastest at.

One generic object holds the matrices; what the road does to the wheels, and the struts' laws, are
symbolic functions, which Exudyn evaluates in C++ without Python.
"""

from __future__ import annotations

from typing import Any

import exudyn
import numpy as np
from exudyn.itemInterface import (
    LoadCoordinate,
    MarkerNodeCoordinate,
    NodeGenericODE2,
    ObjectGenericODE2,
    SensorNode,
)
from exudyn.utilities import CreateSymbolicUserFunction
from numpy.typing import NDArray

from benchmarks.peers_model import HEIGHT_M, LENGTH_M, Mechanism, arrivals_s

Array = NDArray[np.float64]
EXPLICIT = exudyn.DynamicSolverType.RK44
IMPLICIT = exudyn.DynamicSolverType.GeneralizedAlpha


class Car:
    """The mechanism on its way over the bump at one speed."""

    def __init__(self, mechanism: Mechanism, speed_m_s: float, every_s: float) -> None:
        self._every_s = every_s
        self._container = exudyn.SystemContainer()
        self._mbs = mbs = self._container.AddSystem()
        n = len(mechanism.mass)
        zeros = [0.0] * n
        node = mbs.AddNode(
            NodeGenericODE2(
                referenceCoordinates=zeros,
                initialCoordinates=zeros,
                initialCoordinates_t=zeros,
                numberOfODE2Coordinates=n,
            )
        )
        k, c = mechanism.matrices()
        car = mbs.AddObject(
            ObjectGenericODE2(
                nodeNumbers=[node],
                massMatrix=np.diag(mechanism.mass),
                stiffnessMatrix=k,
                dampingMatrix=c,
            )
        )
        self._kept = []  # expressions must live as long as the system
        for i in (0, 2):
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=3 + i))
            load = mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=0.0))
            push = _road_force(mechanism, i, speed_m_s)
            self._kept.append(CreateSymbolicUserFunction(mbs, push, "loadUserFunction", load))
            mbs.SetLoadParameter(load, "loadUserFunction", self._kept[-1])
        if mechanism.laws:
            self._kept.append(_symbolic(mbs, _law_force(mechanism), car, n))
            mbs.SetObjectParameter(car, "forceUserFunction", self._kept[-1])
        self._sensor = mbs.AddSensor(
            SensorNode(
                nodeNumber=node,
                outputVariableType=exudyn.OutputVariableType.Coordinates_t,
                storeInternal=True,
            )
        )
        mbs.Assemble()

    def run(self, seconds: float, step_s: float, solver: Any) -> Array:
        """Velocities (T, n) every `every_s`."""
        settings = exudyn.SimulationSettings()
        settings.timeIntegration.numberOfSteps = round(seconds / step_s)
        settings.timeIntegration.endTime = seconds
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.newton.useModifiedNewton = True
        settings.solution.file.write = False
        settings.solution.sensors.writePeriod = self._every_s
        settings.show.statistics = False
        self._mbs.SolveDynamic(settings, solverType=solver)
        return np.asarray(self._mbs.GetSensorStoredData(self._sensor))[:, 1:]


def _symbolic(mbs: Any, force: Any, car: Any, n: int) -> Any:
    """The force as Exudyn's own `CreateSymbolicUserFunction` records it, which takes vectors of
    three or six numbers, but none of any length."""
    esym = exudyn.symbolic
    esym.SetRecording(True)
    arguments = [
        *(mbs, esym.Real("t", 0.0), esym.Real("itemNumber", 0)),
        *(esym.Vector(name, [0.0] * n) for name in ("q", "q_t")),
    ]
    found = esym.Vector(force(*arguments))
    esym.SetRecording(False)
    recorded = {
        "functionName": "force",
        "argList": arguments,
        "argTypeList": ["MainSystem", "Real", "Index", "StdVector", "StdVector"],
        "returnValue": found,
        "returnType": "StdVector",
    }
    function = esym.UserFunction()
    function.SetUserFunctionFromDict(mbs, recorded, "forceUserFunction", car, "None")
    return function


def _road_force(mechanism: Mechanism, wheel: int, speed_m_s: float) -> Any:
    """What the bump does to a wheel, N, as a function of time."""
    esym = exudyn.symbolic
    turn, arrival = np.pi * speed_m_s / LENGTH_M, arrivals_s(speed_m_s)[wheel]
    stiffness, damping = mechanism.tyre[wheel] * HEIGHT_M

    def loadUserFunction(mbs: Any, t: Any, load: Any) -> Any:
        since, none = t - arrival, esym.Real(0.0)
        push = stiffness * esym.sin(turn * since) + damping * turn * esym.cos(turn * since)
        over = esym.IfThenElse(since < LENGTH_M / speed_m_s, push, none)
        return esym.IfThenElse(since > 0.0, over, none)

    return loadUserFunction


def _law_force(mechanism: Mechanism) -> Any:
    """What the struts' laws do, as a function of the state."""
    esym, n = exudyn.symbolic, len(mechanism.mass)
    rows = [[(j, float(row[j])) for j in np.flatnonzero(row)] for row in mechanism.struts]

    def strut_force(x: Any, v: Any, p: dict[str, float]) -> Any:
        beyond = esym.max(esym.abs(v) - p["knee"], esym.Real(0.0))
        return (
            p["cubic"] * x * x * x
            + p["stop"] * esym.min(x + p["clearance"], esym.Real(0.0))
            + p["one_sided"] * esym.abs(v)
            - p["lost"] * beyond * esym.sign(v)
            + p["slip"] * esym.tanh(v / p["creep"])
        )

    def force(mbs: Any, t: Any, itemNumber: Any, q: Any, q_t: Any) -> list[Any]:
        total: list[Any] = [esym.Real(0.0) for _ in range(n)]
        for row, numbers in zip(rows, mechanism.strut_numbers, strict=True):
            x = sum((factor * q[j] for j, factor in row), esym.Real(0.0))
            v = sum((factor * q_t[j] for j, factor in row), esym.Real(0.0))
            pull = strut_force(x, v, numbers)
            for j, factor in row:
                total[j] = total[j] - factor * pull
        return total

    return force
