"""Measured curves of your own: one CSV file for each motion, and a table of the operations.

    python own_curves.py      # writes the folder curves; here of simulated travel, in mm and s

In the configuration:  endurance: {curves: curves}
"""

from pathlib import Path

import numpy as np

from breaker.model.curves import travel

OPERATIONS = 12
times = np.arange(-5.0, 60.0, 0.1)  # ms
new = np.array([2.0, 0.045, 0.040, 0.30, 0.12, 0.75, 10.0])
worn = new * [1.0, 1.0, 1.0, 1.2, 1.0, 0.95, 1.0]  # more damping, less force
theta = np.linspace(new, worn, OPERATIONS)
rng = np.random.default_rng(1)
folder, table = Path("curves"), ["file,motion,operation"]
folder.mkdir(exist_ok=True)
for motion in ("closing", "opening"):
    curves = travel(theta, times, motion).travel
    for i, curve in enumerate(curves + 0.1 * rng.standard_normal(curves.shape), start=1):
        rows = np.column_stack([times / 1000.0, curve])
        file = folder / f"{motion}_{i:05d}.csv"
        np.savetxt(file, rows, "%.5f", ",", header="time,travel", comments="")
        table.append(f"{file.name},{motion},{i}")
(folder / "operations.csv").write_text("\n".join([*table, ""]), encoding="utf-8")
