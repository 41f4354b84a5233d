"""Robustness of formulas over traces by RTAMT: JSON from stdin, JSON to stdout.

In: `traces`, each with the samples of its signals by name, and `formulas`, each with its `text` in RTAMT's language
and the number of its `trace`. Out: for each formula its robustness at every sample,
infinity as text.
"""

import json
import math
import sys

import rtamt


def robustness(text, trace):
    monitor = rtamt.StlDiscreteTimeSpecification()
    for name in trace:
        monitor.declare_var(name, "float")
    monitor.declare_var("out", "float")
    monitor.spec = f"out = {text}"
    monitor.parse()
    # It writes into what it is given.
    samples = {name: list(values) for name, values in trace.items()}
    length = len(next(iter(samples.values())))
    return [value for _, value in monitor.evaluate({"time": list(range(length)), **samples})]


def said(value):
    return value if math.isfinite(value) else "inf" if value > 0 else "-inf"


def main():
    asked = json.load(sys.stdin)
    answers = [robustness(f["text"], asked["traces"][f["trace"]]) for f in asked["formulas"]]
    json.dump([[said(value) for value in answer] for answer in answers], sys.stdout)


if __name__ == "__main__":
    main()
