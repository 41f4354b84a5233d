#!/usr/bin/env python3
"""The page of envelopes from those that `hil campaign PLAN --envelope KIND --json` printed.

Usage: envelopes_table.py RUNS FILE...
"""

import json
import os
import sys


def figure(value):
    return f"{value:.3g}" if value < 1e4 else f"{value:.0f}"


def main():
    runs, files = sys.argv[1], sys.argv[2:]
    print(
        f"""# How much of each fault is tolerated

Written by `benchmarks/envelopes`: each fault by itself, from the
beginning of the plan to its end; one that lasts a time of its own, or an instant, begins at a time that is drawn for
each run; its other parameters are at typical values ([faults.md](faults.md)); {runs} runs at each severity, seeds 1 to {runs}.

* passes: every measurement of the plan is in its band, and no property broke.
* tolerated: the greatest severity at which, and at every smaller one that was run, at least 90 % of runs pass at 95 %
  confidence (lower end of the Wilson interval). "-": not even the least that was run (a ten thousandth of the range).
* half: the least severity that was run at which half of the runs or fewer pass. "-": there was none.

| plan | fault | strikes | unit | tolerated | half |
|---|---|---|---|---|---|"""
    )
    for file in files:
        plan = os.path.basename(file).split(".")[0]
        with open(file, encoding="utf-8") as text:
            (found,) = json.load(text)
        levels = found["levels"]
        half = next((l["severity"] for l in levels if 2 * l["passed"] <= l["runs"]), None)
        tolerated = "-" if found["tolerated"] is None else figure(found["tolerated"])
        if found["is_all"]:
            tolerated += " (all)"
        print(
            f"| {plan} | `{found['kind']}` | {found['target']} | {found['unit']} | {tolerated} | "
            f"{'-' if half is None else figure(half)} |"
        )


if __name__ == "__main__":
    main()
