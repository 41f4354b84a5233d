"""Loads the referees, and does nothing else."""

import asammdf  # noqa: F401
import can  # noqa: F401
import pcapng  # noqa: F401
