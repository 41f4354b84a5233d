"""What a run measured, from its tables.

    hil run laps-observed
    hil export runs/laps-observed-seed1 --tables tables
    pip install pandas pyarrow          # pandas alone for --format csv
    python3 examples/python/read_run.py tables
"""

import sys
from pathlib import Path

import pandas as pd


def table(folder: Path, name: str) -> pd.DataFrame:
    if (folder / f"{name}.parquet").exists():
        return pd.read_parquet(folder / f"{name}.parquet")
    # Only an empty cell is missing: a note may well be the word "None".
    return pd.read_csv(folder / f"{name}.csv", keep_default_na=False, na_values=[""])


folder = Path(sys.argv[1])
observed = table(folder, "observations")

laps = observed[observed["quantity"] == "lap.gyro_error"]
if not laps.empty:
    direction = laps["direction"].map({1.0: "ccw", -1.0: "cw"})
    print("median error of the gyro over a lap, deg:")
    print(laps.groupby(direction)["value"].agg(["median", "count"]).to_string())

biases = observed[observed["quantity"] == "bias.mean"].dropna(subset=["temperature_celsius"])
if not biases.empty:
    print("bias of the gyro, deg/s, by its temperature, degC:")
    by_temperature = biases.groupby(biases["temperature_celsius"].round())["value"]
    print(by_temperature.agg(["median", "count"]).to_string())

print("judged:")
for judged in table(folder, "measurements").itertuples():
    band = f"{judged.lower} to {judged.upper} {judged.unit}"
    paper = f"; paper: {judged.paper}" if isinstance(judged.paper, str) else ""
    print(f"  {judged.name}: {judged.value:.4g}, band {band}, {judged.verdict}{paper}")
