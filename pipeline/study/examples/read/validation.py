"""A validation drawn from its records with pandas and matplotlib: Parquet, JSON and CSV, nothing of this project needed.

    python validation.py ../../../.. SPECIMEN TRIAL              records of `study run`
    python validation.py ../../../../target/quick SPECIMEN TRIAL  the same of the quick profile

Leaves validation.png and, for programs that read no Parquet, validation.csv and validation.json, here. Needs: pandas, pyarrow, matplotlib.
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import pandas as pd

if len(sys.argv) != 4:
    sys.exit(__doc__)
project, specimen, trial = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
record = project / "data" / "processed" / "validate" / specimen / trial / "record"
if not record.is_dir():
    sys.exit(f"{record} is not there\n  why: no validation of it was made\n  do:  study run validate, or name another trial")

motion = pd.read_parquet(record / "validation.parquet")  # a column's name ends in its unit: _s, _m, _pa
about = json.loads((record / "validation.json").read_text(encoding="utf-8"))
raw = project / "data" / "raw" / specimen / "trials" / trial / "pressure.csv"
log = pd.read_csv(raw, comment="#")  # on the log's own clock
first = raw.read_text(encoding="utf-8").splitlines()[0]
remark = f" ({first[1:].strip()})" if first.startswith("#") else ""  # a log of the virtual bench says so

motion.to_csv("validation.csv", index=False)
Path("validation.json").write_text(json.dumps(about), encoding="utf-8")

figure, (top, middle, bottom) = plt.subplots(3, 1, figsize=(7, 7), constrained_layout=True)
measured, deviation = 1e3 * motion["measured_y_m"], 1e3 * motion["deviation_y_m"]
top.fill_between(motion["time_s"], measured - deviation, measured + deviation, color="0.8", label="± deviation of repeats")
top.plot(motion["time_s"], measured, "k", label=f"measured, mean of {about['repeats']}")
top.plot(motion["time_s"], 1e3 * motion["simulated_y_m"], "C1--", label="simulated")
top.set(ylabel="sideways (mm)", xlabel="time on the film's clock (s)")
top.set_title(f"{specimen}/{trial}{remark}, marker {about['marker']}: {1e3 * about['rmse_m']:.2f} mm of {1e3 * about['length_m']:.0f} mm")
top.legend(loc="upper left", fontsize="small")

for column in [name for name in motion if name.endswith("_pa")]:
    middle.plot(motion["time_s"], motion[column] / 100, label=column.removesuffix("_pa"))
middle.set(ylabel="mean of repeats (mbar)", xlabel="time on the film's clock (s)")
middle.legend(loc="upper left", fontsize="small")

for side in ("left", "right"):
    bottom.plot(log["time_s"], log[f"{side}_mbar"], label=f"{side}, as logged")
bottom.set(ylabel="one log (mbar)", xlabel="time on the log's clock (s)")
bottom.legend(loc="upper left", fontsize="small")
figure.savefig("validation.png", dpi=120)

errors = pd.DataFrame(about["scored"] + about["baselines"]).set_index("name")["rmse"]
print((1e3 * errors).round(3).rename("error (mm)").to_string())
