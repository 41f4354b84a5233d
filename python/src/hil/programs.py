"""The program ``hil``, and what it prints."""

import os
import shutil
import sysconfig
from pathlib import Path


def program() -> str:
    """The path of ``hil``: what the variable ``HIL`` says, else the one of this package, else the one on ``PATH``."""
    named = os.environ.get("HIL")
    beside = Path(sysconfig.get_path("scripts"), "hil")
    found = shutil.which(named or beside) or (None if named else shutil.which("hil"))
    if found is None:
        where = f"HIL={named}" if named else f"{beside} and PATH"
        raise FileNotFoundError(f"no program hil: {where}")
    return found
