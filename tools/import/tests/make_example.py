#!/usr/bin/env python3
"""Writes examples/messung.csv: what a German measuring program would have written of a simulated wire that cools a little better than
its rig file says. `sinew simulate` makes the numbers; this adds noise, another zero and the other direction, and the mess."""

import random
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[3]


def duty(t):
    if 2 <= t < 10:
        return 0.35
    if 10 <= t < 18:
        return 0.05
    if 18 <= t < 26:
        return (t - 18) / 8 * 0.4
    return 0.22 if 33 <= t < 40 else 0.0


def main():
    sinew = sys.argv[1] if len(sys.argv) > 1 else "sinew"
    random.seed(7)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        rig = (ROOT / "examples/messung.toml").read_text() + "material = { convection_w_per_m2_k = 95.0 }\n"
        (folder / "rig.toml").write_text(rig)
        (folder / "drive.csv").write_text("time_s,duty\n" + "".join(f"{k / 10},{duty(k / 10)}\n" for k in range(450)))
        subprocess.run([sinew, "simulate", "rig.toml", "drive.csv", "-o", "out.csv"], cwd=folder, check=True)
        lines = (folder / "out.csv").read_text().splitlines()
    names = lines[0].split(",")
    rows = [dict(zip(names, map(float, line.split(",")))) for line in lines[1:]]
    cold = rows[0]["position_m"]
    comma = lambda value, digits: f"{value:.{digits}f}".replace(".", ",")
    out = ["Versuch;FGL-Draht 7", "Prüfer;Müller", "Datum;12.03.2024", "", "Zeit;Tastgrad;Verkürzung;Strom", "ms;%;µm;mA"]
    for row in rows:
        on = row["duty"] > 0
        current = 1e3 * row["current_a"] + random.gauss(0, 0.5) if on else 0.0
        short = 1e6 * (cold - row["position_m"]) + random.gauss(0, 2.0)
        out.append(f"{comma(1e3 * row['time_s'], 0)};{comma(100 * row['duty'], 1)};{comma(short, 1)};{comma(current, 1) if on else ''}")
    out += ["", "Ende der Messung"]
    (ROOT / "examples/messung.csv").write_bytes("".join(line + "\r\n" for line in out).encode("cp1252"))


if __name__ == "__main__":
    main()
