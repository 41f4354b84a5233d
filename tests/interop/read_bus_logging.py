"""Decodes the frames of an MDF 4 file by a DBC with asammdf, as its users do: `read_bus_logging.py FILE.mf4 FILE.dbc`.

Prints one line of JSON: the unit of each signal, and how many values it has.
"""

import json
import sys

# Apart from the other packages: python-can imports it where it finds it.
sys.path.append(sys.prefix + "/apart")

from asammdf import MDF

path, dbc = sys.argv[1:]
with MDF(path) as logged:
    decoded = logged.extract_bus_logging({"CAN": [(dbc, 0)]})
    signals = {signal.name: {"values": len(signal), "unit": signal.unit} for signal in decoded.iter_channels()}
print(json.dumps(signals))
