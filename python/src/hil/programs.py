"""The program ``hil``, and what it prints."""

import os
import shutil
import signal
import subprocess
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


def started(command: list[str], **rest) -> subprocess.Popen:
    """Starts a command that Ctrl-C does not reach.

    A terminal sends it to the command as well, which would end before this process has closed what it uses of it. Whoever starts
    the command ends it.
    """
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        return subprocess.Popen(command, **rest)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
