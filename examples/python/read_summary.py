"""How a run ended, from its summary.json alone. Needs nothing but Python.

    python3 examples/python/read_summary.py runs/laps-observed-seed1
"""

import json
import sys
from pathlib import Path

summary = json.loads((Path(sys.argv[1]) / "summary.json").read_text(encoding="utf-8"))
print(summary["plan"], "seed", summary["seed"], summary["outcome"])
for measured in summary["measurements"]:
    print(measured["name"], measured["value"], measured["unit"], measured["verdict"])
