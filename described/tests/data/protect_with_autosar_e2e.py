"""Writes autosar_e2e.csv: messages that the package autosar-e2e (PyPI, MIT) protected, of random bytes.

    pip install autosar-e2e==1.0.0
    python protect_with_autosar_e2e.py
"""

import csv
import random
from pathlib import Path

from e2e import p01, p02, p04, p05

ROWS_PER_PROFILE = 40
MODES = {
    "1A": p01.E2E_P01_DATAID_BOTH,
    "1B": p01.E2E_P01_DATAID_ALT,
    "1C": p01.E2E_P01_DATAID_NIBBLE,
}


def protected(profile, draw):
    """A row: the profile, its data ids, where its CRC or its header begins, the bytes before and after."""
    data = bytearray(draw.randbytes(16 if profile == "4" else 8))
    at = 0
    if profile in MODES:
        data_ids = [draw.randrange(0x1000 if profile == "1C" else 0x10000)]
        at = draw.choice([0, 2, 6])
        data[at + 1] = data[at + 1] & 0xF0 | draw.randrange(15)
    elif profile == "2":
        data_ids = list(draw.randbytes(16))
    elif profile == "4":
        data_ids = [draw.randrange(1 << 32)]
        at = draw.choice([0, 4])
    else:
        data_ids = [draw.randrange(0x10000)]
        at = draw.choice([0, 1, 5])
    before = data.hex()
    if profile in MODES:
        p01.e2e_p01_protect(
            data, data_ids[0], data_id_mode=MODES[profile], offset=at, increment_counter=False
        )
    elif profile == "2":
        p02.e2e_p02_protect(data, bytes(data_ids), increment_counter=False)
    elif profile == "4":
        p04.e2e_p04_protect(data, data_ids[0], offset=at, increment_counter=False)
    else:
        p05.e2e_p05_protect(data, data_ids[0], offset=at, increment_counter=False)
    return [profile, " ".join(map(str, data_ids)), at, before, data.hex()]


draw = random.Random(849)
with (Path(__file__).parent / "autosar_e2e.csv").open("w", newline="") as file:
    rows = csv.writer(file, lineterminator="\n")
    rows.writerow(["profile", "data_ids", "at", "bytes", "protected"])
    for profile in [*MODES, "2", "4", "5"]:
        rows.writerows(protected(profile, draw) for _ in range(ROWS_PER_PROFILE))
