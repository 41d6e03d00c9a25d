"""Makes examples/dsc.csv: what a calorimeter's program exports of an alloy whose transformations are logistic.

A = 93 °C and M = 67 °C, k = 0.4 1/K, 24.2 J/g, 10 K/min; on cooling an R-phase of 3 J/g at 100 °C. German export: Windows-1252, semicolons,
decimal commas, remarks above.  Run: python3 tools/standards/tests/make_example.py
"""

import math
from pathlib import Path

RATE = 10.0  # K/min
STEP = 0.5  # K


def peak(k, x):
    return 0.25 * k / math.cosh(0.5 * k * x) ** 2


def heating(t):
    return 0.05 + 1e-4 * t + 24.2 * RATE / 60 * peak(0.4, t - 93)


def cooling(t):
    return -0.05 - 1e-4 * t - RATE / 60 * (24.2 * peak(0.4, t - 67) + 3.0 * peak(0.5, t - 100))


count = int(180 / STEP)
up = [-20 + STEP * i for i in range(count + 1)]
rows = [(t, heating(t)) for t in up] + [(t, cooling(t)) for t in reversed(up)]
lines = ["Probe;NiTi 7", "Masse;12,4 mg", "", "Zeit/min;Temp./°C;DSC/(mW/mg)"]
for i, (t, flow) in enumerate(rows):
    lines.append(f"{i * STEP / RATE:.3f};{t:.1f};{flow:.5f}".replace(".", ","))
out = Path(__file__).resolve().parents[3] / "examples" / "dsc.csv"
out.write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))
