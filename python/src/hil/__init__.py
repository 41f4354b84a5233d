"""hil from Python: runs of plans, emulated devices, and lines of rigs by name.

The programs ``hil`` and ``k2a-controller`` come with it, and so do a plugin of pytest and an interface of python-can.
docs/python.md has an overview.
"""

from hil.lines import Line, NoLine, line, running
from hil.programs import program
from hil.rig import Rig, RigError
from hil.runs import Measurement, Property, Run, run

__all__ = [
    "Line",
    "Measurement",
    "NoLine",
    "Property",
    "Rig",
    "RigError",
    "Run",
    "line",
    "program",
    "run",
    "running",
]
