"""Loads the referees, and does nothing else."""

import can  # noqa: F401
import pcapng  # noqa: F401
