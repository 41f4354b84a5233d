"""Simulates an FMU by FMPy and prints its outputs, one line for each communication point.

fmu_rows.py FMU STEP_S STOP_S OUTPUTS [INPUTS.csv] [NAME=START...]

OUTPUTS are names with commas between them. INPUTS.csv has a column `time` and one for each input; an input holds until the next
line. With `--validate` first, the FMU's description is checked and its problems are printed, and nothing else is.
"""

import sys

import numpy
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu


def inputs_of(path, described):
    with open(path) as file:
        names = file.readline().strip().split(",")
        rows = [tuple(float(cell) for cell in line.split(",")) for line in file]
    kinds = {variable.name: variable.type for variable in described.modelVariables}
    kinds = [(name, numpy.bool_ if kinds.get(name) == "Boolean" else numpy.float64) for name in names]
    return numpy.array(rows, dtype=kinds)


def main():
    if sys.argv[1] == "--validate":
        print("\n".join(validate_fmu(sys.argv[2])))
        return
    fmu, step, stop, outputs, *rest = sys.argv[1:]
    described = read_model_description(fmu)
    starts = dict(pair.split("=", 1) for pair in rest if "=" in pair)
    inputs = [inputs_of(path, described) for path in rest if "=" not in path]
    rows = simulate_fmu(
        fmu,
        stop_time=float(stop),
        step_size=float(step),
        output_interval=float(step),
        start_values=starts,
        input=inputs[0] if inputs else None,
        output=outputs.split(","),
        fmi_type="CoSimulation",
    )
    for row in rows:
        print(",".join(repr(float(value)) for value in row))


main()
