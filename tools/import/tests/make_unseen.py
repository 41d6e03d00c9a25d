#!/usr/bin/env python3
"""Writes tests/unseen: ten files that were made before the importer was done and not looked at until it was, with other names, units,
orders and numbers than those of make_files.py. How they were read at first sight stands in unseen/README.md."""

import csv
import math
import subprocess
import tempfile
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd

import make_files
from make_files import comma, expect, refused, rounded, rows_of, says

make_files.HERE = HERE = Path(__file__).parent / "unseen"
G = 9.80665


def signals(n, dt, seed):
    """Heat in ramps, another wire's noise: not the signals of make_files.py."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) * dt
    duty = np.clip(0.28 * (1 - np.cos(2 * np.pi * t / (n * dt / 2.5))), 0, 0.5)
    temp = np.empty(n)
    temp[0] = 22.1
    for k in range(1, n):
        temp[k] = temp[k - 1] + dt / 1.1 * (230 * duty[k - 1] - (temp[k - 1] - 22.0))
    temp += 0.05 * rng.standard_normal(n)
    share = 1 / (1 + np.exp((temp - 80) / 5))
    position = 0.0012 + 0.0060 * share + 3e-6 * rng.standard_normal(n)
    resistance = 9.0 + 1.4 * share
    current = np.sqrt(duty) * 0.6
    return dict(t=t, duty=duty, temp=temp, position=position, length=position + 0.16, current=current, volts=current * resistance,
                power=current**2 * resistance, force=1.95 + 0.02 * rng.standard_normal(n), ambient=22 + 0.05 * rng.standard_normal(n))


def main():
    HERE.mkdir(exist_ok=True)
    # 1: an instrument's export
    s, file = signals(70, 0.2, 1), "01_instrument.csv"
    n = len(s["t"])
    lines = ['"Instrument","DAQ970A"', '"Serial","MY5900"', '"Start","2025-01-07 08:15:00"', '"Channels","4"', "",
             '"Scan","Time","101 (VDC) wire (mV)","102 (ADC) (A)","LVDT ext. (µm)"']
    for k in range(n):
        at = datetime(2025, 1, 7, 8, 15) + timedelta(seconds=float(s["t"][k]))
        lines.append(f'{k + 1},"{at:%Y-%m-%dT%H:%M:%S}.{at.microsecond // 1000:03d}",{1e3 * s["volts"][k]:.2f},{s["current"][k]:.5f},{1e6 * s["position"][k]:.1f}')
    make_files.text(file, "\r\n".join(lines) + "\r\n", "cp1252")
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "v3_v", rounded(1e3 * s["volts"], 2) / 1e3)
    expect(file, "current_a", rounded(s["current"], 5))
    expect(file, "position_m", rounded(1e6 * s["position"], 1) / 1e6)
    # 2: Japanese, contraction
    s, file = signals(64, 0.1, 2), "02_japanese.tsv"
    n = len(s["t"])
    contraction = rounded(1e3 * (s["position"][0] - s["position"]), 4)
    frame = pd.DataFrame({"番号": np.arange(n), "経過時間[ms]": (1e3 * s["t"]).round().astype(int), "電流[mA]": rounded(1e3 * s["current"], 1),
                          "電圧[V]": rounded(s["volts"], 3), "収縮量[mm]": contraction})
    frame.to_csv(HERE / file, sep="\t", index=False)
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "current_a", rounded(1e3 * s["current"], 1) / 1e3)
    expect(file, "v3_v", rounded(s["volts"], 3))
    expect(file, "position_m:change", -(contraction - contraction[0]) / 1e3)
    says(file, "TURNED ROUND")
    # 3: French, OpenDocument by LibreOffice
    s, file = signals(40, 0.5, 3), "03_francais.ods"
    n = len(s["t"])
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "03_francais.csv"
        columns = [s["t"] / 60, 1e3 * s["length"], s["power"], s["ambient"]]
        rows = ["Essai n° 14", "", "Temps (min),Longueur du fil (mm),Puissance (W),Température ambiante (°C)"]
        rows += [",".join(f"{c[k]:.6f}" for c in columns) for k in range(n)]
        source.write_text("\n".join(rows) + "\n")
        make_files.run("soffice", "--headless", f"-env:UserInstallation=file://{folder}/profile", "--infilter=CSV:44,34,76,1,,1033", "--convert-to", "ods",
                       "--outdir", str(HERE), str(source))
    rows_of(file, n)
    expect(file, "time_s", rounded(s["t"] / 60, 6) * 60)
    expect(file, "position_m", rounded(1e3 * s["length"], 6) / 1e3 - 0.16)
    expect(file, "power_w", rounded(s["power"], 6))
    expect(file, "ambient_c", rounded(s["ambient"], 6))
    # 4: MATLAB struct by SciPy
    import scipy.io

    s, file = signals(90, 0.15, 4), "04_struct.mat"
    n = len(s["t"])
    scipy.io.savemat(HERE / file, {"Messung": {"Zeit": s["t"], "Leistung_mW": 1e3 * s["power"], "Weg_um": 1e6 * s["position"], "Kraft_cN": 100 * s["force"],
                                               "Bediener": "k"}}, do_compression=True)
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "power_w", s["power"])
    expect(file, "position_m", s["position"])
    expect(file, "force_n", s["force"])
    # 5: TDMS, waveforms of several kinds of numbers
    from nptdms import ChannelObject, GroupObject, TdmsWriter

    s, file = signals(100, 0.05, 5), "05_rig.tdms"
    n = len(s["t"])
    grams = (s["force"] / G * 1e3).round().astype(np.int16)
    with TdmsWriter(HERE / file) as writer:
        properties = lambda unit: {"wf_increment": 0.05, "unit_string": unit}
        writer.write_segment([GroupObject("run 3"), ChannelObject("run 3", "Load Cell", grams, properties("g")),
                              ChannelObject("run 3", "LVDT", s["position"] * 1e3, properties("mm")),
                              ChannelObject("run 3", "Heater Duty", (100 * s["duty"]).astype(np.float32), properties("%"))])
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "force_n", grams * G / 1e3)
    expect(file, "position_m", s["position"])
    expect(file, "duty", (100 * s["duty"]).astype(np.float32).astype(float) / 100)
    # 6: three lines of header, by openpyxl
    import openpyxl

    s, file = signals(45, 0.4, 6), "06_three_headers.xlsx"
    n = len(s["t"])
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["", "Antrieb", "", "Sensoren", "", ""])
    sheet.append(["Zeit", "Sollwert", "Tastgrad", "Auslenkung", "Temperatur Draht", "Temperatur Raum"])
    sheet.append(["s", "mm", "%", "mm", "°C", "°C"])
    for k in range(n):
        sheet.append([float(s["t"][k]), 3.0, float(100 * s["duty"][k]), float(1e3 * s["position"][k]), float(s["temp"][k]), float(s["ambient"][k])])
    book.save(HERE / file)
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "duty", s["duty"])
    expect(file, "position_m", s["position"])
    expect(file, "temperature_c", s["temp"])
    expect(file, "ambient_c", s["ambient"])
    # 7: blanks, clock with commas
    s, file = signals(75, 0.3, 7), "07_logger.asc"
    n = len(s["t"])
    lines = ["% Logger V2.1", "% Kanal: 3", "Uhrzeit       Weg_mm    Strom_A   PWM_%"]
    for k in range(n):
        at = datetime(2025, 5, 5, 6, 59, 50) + timedelta(seconds=float(s["t"][k]))
        lines.append(f"{at:%H:%M:%S},{at.microsecond // 100000}   {comma(1e3 * s['position'][k], 3)}   {comma(s['current'][k], 4)}   {comma(100 * s['duty'][k], 1)}")
    make_files.text(file, "\r\n".join(lines) + "\r\n", "cp1252")
    rows_of(file, n)
    expect(file, "time_s", rounded(s["t"], 1))
    expect(file, "position_m", rounded(1e3 * s["position"], 3) / 1e3)
    expect(file, "current_a", rounded(s["current"], 4))
    expect(file, "duty", rounded(100 * s["duty"], 1) / 100)
    # 8: no units at all, kelvin, shortening positive
    s, file = signals(80, 0.2, 8), "08_bare.csv"
    n = len(s["t"])
    raw = rounded(30 - 1e3 * s["position"], 3)
    lines = ["t|T_wire|x|U_supply|p"] + [f"{s['t'][k]:.1f}|{s['temp'][k] + 273.15:.2f}|{raw[k]:.3f}|6.01|{s['power'][k]:.4f}" for k in range(n)]
    make_files.text(file, "\n".join(lines) + "\n")
    rows_of(file, n)
    expect(file, "time_s", rounded(s["t"], 1))
    expect(file, "temperature_c", rounded(s["temp"] + 273.15, 2) - 273.15)
    expect(file, "position_m:change", -(raw - raw[0]) / 1e3)
    expect(file, "supply_v", np.full(n, 6.01))
    expect(file, "power_w", rounded(s["power"], 4))
    says(file, "TURNED ROUND")
    # 9: Octave, rows of numbers, wanted and measured
    s, file = signals(66, 0.25, 9), "09_octave.mat"
    n = len(s["t"])
    with tempfile.TemporaryDirectory() as folder:
        scipy.io.savemat(Path(folder) / "in.mat", {k: v.reshape(1, -1) for k, v in s.items()})
        make_files.run("octave", "--no-gui", "--eval", f"load('{folder}/in.mat'); x_soll_mm = 4+0*t; x_ist_mm = 1e3*position; zeit_ms = 1e3*t; u_draht_mV = 1e3*volts; "
                       f"i_draht_mA = 1e3*current; save('-v7', '{HERE}/{file}', 'x_soll_mm', 'x_ist_mm', 'zeit_ms', 'u_draht_mV', 'i_draht_mA');")
    rows_of(file, n)
    expect(file, "time_s", s["t"])
    expect(file, "position_m", s["position"])
    expect(file, "v3_v", s["volts"])
    expect(file, "current_a", s["current"])
    # 10: refused
    s, file = signals(20, 0.2, 10), "10_pandas.json"
    pd.DataFrame({"t": s["t"], "duty": s["duty"]}).to_json(HERE / file)
    refused(file, "is JSON")
    with open(HERE / "expected.csv", "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["file", "quantity", "row", "value"])
        writer.writerows(make_files.EXPECTED)


if __name__ == "__main__":
    main()
