"""Loads the referees, and does nothing else."""

import sys

import can  # noqa: F401
import pcapng  # noqa: F401

# Apart from the other packages: python-can imports it where it finds it.
sys.path.append(sys.prefix + "/apart")

import asammdf  # noqa: F401
