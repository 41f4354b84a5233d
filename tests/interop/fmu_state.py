"""Goes back to an earlier state of an FMU, by FMPy: `fmu_state.py FMU OUTPUT` prints the output after each of three steps, and again
after the same steps from the state before them, and then after a reset.
"""

import sys

from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

path, output = sys.argv[1:]
described = read_model_description(path)
is_three = described.fmiVersion.startswith("3")
arguments = {
    "guid": described.guid or getattr(described, "instantiationToken", None),
    "unzipDirectory": extract(path),
    "modelIdentifier": described.coSimulation.modelIdentifier,
    "instanceName": "one",
}
fmu = (FMU3Slave if is_three else FMU2Slave)(**arguments)
reference = {one.name: one.valueReference for one in described.modelVariables}[output]
get = fmu.getFloat64 if is_three else fmu.getReal


def begin():
    if not is_three:
        fmu.setupExperiment(startTime=0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


def run(start, steps):
    for step in range(steps):
        fmu.doStep(currentCommunicationPoint=start + step * 0.1, communicationStepSize=0.1)
        print(repr(get([reference])[0]))


fmu.instantiate()
begin()
run(0, 3)
state = fmu.getFMUState() if is_three else fmu.getFMUstate()
run(0.3, 3)
(fmu.setFMUState if is_three else fmu.setFMUstate)(state)
run(0.3, 3)
(fmu.freeFMUState if is_three else fmu.freeFMUstate)(state)
fmu.reset()
begin()
run(0, 3)
fmu.terminate()
fmu.freeInstance()
