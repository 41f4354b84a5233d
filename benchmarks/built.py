"""Programs that the scripts beside this file build and run."""

import json
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def said(*command):
    """What a command in the root of the repository prints."""
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def benchmark(name, *command, folder=ROOT):
    """Builds the benchmark with that name by this command of cargo, and returns its path."""
    command = [*command, "--bench", name, "--message-format", "json-render-diagnostics"]
    ran = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=True)
    messages = [json.loads(line) for line in ran.stdout.splitlines() if line.startswith("{")]
    [path] = {m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == name}
    return path
