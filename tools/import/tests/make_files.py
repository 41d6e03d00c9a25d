#!/usr/bin/env python3
"""Writes tests/files and tests/files/expected.csv: files as laboratories have them, and the numbers that are in them.

Needs numpy, scipy, pandas, openpyxl, xlsxwriter, xlwt, odfpy, h5py, hdf5storage, nptdms, rosbags; LibreOffice (soffice), Gnumeric
(ssconvert) and GNU Octave (octave). `python3 make_files.py` writes all anew; what each is written by stands in files/README.md.
"""

import csv
import gzip
import math
import os
import shutil
import subprocess
import sys
import tempfile
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd

HERE = Path(__file__).parent / "files"
EXPECTED = []
WRITERS = []
G = 9.80665


def wire(n=80, dt=0.25, phase=0):
    """A wire of 160 mm and 0.125 mm that lifts 0.2 kg, heated in steps: all in SI, position from L_0."""
    t = np.arange(n) * dt
    duty = np.where((np.arange(n) + phase) % 40 < 20, 0.0, 0.45)
    duty[duty > 0] -= 0.05 * (np.arange(n)[duty > 0] // 40)
    ambient = 23.4
    temp = np.empty(n)
    temp[0] = ambient + 0.3
    for k in range(1, n):
        temp[k] = temp[k - 1] + dt / 1.4 * (220 * duty[k - 1] - (temp[k - 1] - ambient))
    share = 1 / (1 + np.exp((temp - 78) / 6))
    position = 0.0025 + 0.0052 * share + 2e-6 * np.sin(np.arange(n) * 2.3)
    resistance = 9.2 + 1.1 * share
    current = np.where(duty > 0, 5.9 / resistance, 0.0096)
    force = 1.96 + 0.04 * np.sin(np.arange(n) * 0.7)
    return dict(
        t=t, duty=duty, ambient=np.full(n, ambient) + 0.1 * np.sin(np.arange(n)), temp=temp, position=position, length=position + 0.16,
        resistance=resistance, current=current, v3=current * resistance, power=duty * current**2 * resistance, force=force,
        supply=np.full(n, 5.98) + 0.004 * np.cos(np.arange(n)),
    )


def rounded(values, digits):
    return np.array([float(f"{v:.{digits}f}") for v in values])


def expect(file, quantity, values, rows=None):
    """The numbers in SI at some rows. QUANTITY:change = less the first, for what has another zero."""
    n = len(values)
    for row in rows or sorted({0, 1, n // 3, n // 2, n - 1}):
        EXPECTED.append((file, quantity, row, "" if math.isnan(values[row]) else repr(float(values[row]))))


def rows_of(file, n):
    EXPECTED.append((file, "rows", "", n))


def says(file, words):
    """Words that stand in the table to confirm or in the mapping."""
    EXPECTED.append((file, "says", "", words))


def refused(file, words):
    EXPECTED.append((file, "refused", "", words))


def by(file, writer):
    WRITERS.append((file, writer))


def text(file, content, encoding="utf-8", writer="hand (Python)"):
    data = content if isinstance(content, bytes) else content.encode(encoding)
    (HERE / file).write_bytes(data)
    by(file, writer)


def comma(value, digits):
    return f"{value:.{digits}f}".replace(".", ",")


def run(*command, **options):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)


def by_hand():
    w = wire()
    n = len(w["t"])
    # a German measuring program: metadata, names, units, numbers, a footer; Windows-1252
    file = "messung_de.csv"
    lines = ["Messprotokoll;FGL-Draht 7", "Prüfer;Müller", "Datum;12.03.2024", "Abtastrate;4 Hz", "",
             "Zeit;Tastgrad;Weg;Kraft;Drahttemperatur;Umgebungstemperatur", "s;%;mm;N;°C;°C"]
    for k in range(n):
        lines.append(";".join([comma(w["t"][k], 2), comma(100 * w["duty"][k], 1), comma(1e3 * w["position"][k], 3), comma(w["force"][k], 3),
                               comma(w["temp"][k], 1), comma(w["ambient"][k], 1)]))
    lines += ["", "Ende der Messung"]
    text(file, "\r\n".join(lines) + "\r\n", "cp1252")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "duty", rounded(100 * w["duty"], 1) / 100)
    expect(file, "position_m", rounded(1e3 * w["position"], 3) / 1e3)
    expect(file, "force_n", rounded(w["force"], 3))
    expect(file, "temperature_c", rounded(w["temp"], 1))
    expect(file, "ambient_c", rounded(w["ambient"], 1))
    says(file, "windows-1252")
    says(file, "longer is positive")

    # the same program with shortening counted from cold, microns, and the time as a clock
    file = "verkuerzung_uhrzeit.txt"
    short = 1e6 * (w["position"][0] - w["position"])
    lines = ["Uhrzeit\tPWM [%]\tVerkürzung [µm]\tStrom [mA]"]
    start = datetime(2024, 3, 12, 23, 59, 50)
    for k in range(n):
        at = start + timedelta(seconds=float(w["t"][k]))
        lines.append("\t".join([at.strftime("%H:%M:%S,") + f"{at.microsecond // 1000:03d}", comma(100 * w["duty"][k], 0), comma(short[k], 1),
                                comma(1e3 * w["current"][k], 2)]))
    text(file, "\n".join(lines) + "\n", "utf-8-sig")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "duty", rounded(100 * w["duty"], 0) / 100)
    expect(file, "position_m:change", -(rounded(short, 1) - rounded(short, 1)[0]) / 1e6)
    expect(file, "current_a", rounded(1e3 * w["current"], 2) / 1e3)
    says(file, "TURNED ROUND")
    says(file, "position_zero")
    says(file, "past midnight")

    # an Arduino's serial monitor: no units, milliseconds, 8-bit PWM, a remark, a repeated header
    file = "arduino.log"
    lines = ["millis,pwm,pos,temp"]
    for k in range(n):
        if k == 40:
            lines.append("# heater on again")
        lines.append(f"{int(1000 * w['t'][k]) + 1532},{round(255 * w['duty'][k])},{1e3 * w['position'][k]:.2f},{w['temp'][k]:.1f}")
    text(file, "\r\n".join(lines) + "\r\n")
    rows_of(file, n)
    expect(file, "time_s", w["t"] + 1.532)
    expect(file, "duty", np.round(255 * w["duty"]) / 255)
    expect(file, "position_m", rounded(1e3 * w["position"], 2) / 1e3)
    expect(file, "temperature_c", rounded(w["temp"], 1))
    says(file, "has no unit")

    # French, semicolons, a no-break space between thousands, MS-DOS line ends
    file = "essai_fr.csv"
    lines = ["temps (ms);rapport cyclique (%);déplacement (µm);effort (N);température ambiante (°C)"]
    for k in range(n):
        micron = f"{1e6 * w['position'][k]:,.1f}".replace(",", "\u00a0").replace(".", ",")
        lines.append(f"{comma(1e3 * w['t'][k], 1)};{comma(100 * w['duty'][k], 1)};{micron};{comma(w['force'][k], 3)};{comma(w['ambient'][k], 2)}")
    text(file, "\r\n".join(lines) + "\r\n", "cp1252")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "duty", rounded(100 * w["duty"], 1) / 100)
    expect(file, "position_m", rounded(1e6 * w["position"], 1) / 1e6)
    expect(file, "force_n", rounded(w["force"], 3))
    expect(file, "ambient_c", rounded(w["ambient"], 2))

    # an imperial bench: inches, pounds, Fahrenheit, reversed load cell
    file = "tensile_us.csv"
    lines = ["Test: SMA-0042", "Operator: J. Doe", "", '"Time, s","Duty, %","Extension, in","Load, lbf","Wire Temp, °F"']
    for k in range(n):
        lines.append(f"{w['t'][k]:.2f},{100 * w['duty'][k]:.0f},{w['position'][k] / 0.0254:.5f},{-w['force'][k] / 4.4482216152605:.4f},{w['temp'][k] * 1.8 + 32:.1f}")
    text(file, "\n".join(lines) + "\n")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "position_m", rounded(w["position"] / 0.0254, 5) * 0.0254)
    expect(file, "force_n", rounded(w["force"] / 4.4482216152605, 4) * 4.4482216152605)
    expect(file, "temperature_c", (rounded(w["temp"] * 1.8 + 32, 1) - 32) / 1.8)
    says(file, "never pushes")

    # LabVIEW's measurement file, as its manual describes it: tabs, a comma as the decimal sign, an X column
    def lvm(file, x_columns, decimal):
        d = "Comma" if decimal == "," else "."
        fix = lambda s: s.replace(".", decimal)
        head = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", f"Decimal_Separator\t{decimal}",
                "Multi_Headings\tNo", f"X_Columns\t{x_columns}", "Time_Pref\tRelative", "Operator\tlab", "Date\t2024/03/12",
                fix("Time\t10:11:12.5"), "***End_of_Header***\t", "\t", "Channels\t3\t\t\t", f"Samples\t{n}\t{n}\t{n}\t",
                "Date\t2024/03/12\t2024/03/12\t2024/03/12\t", fix("Time\t10:11:12.5\t10:11:12.5\t10:11:12.5\t"), "Y_Unit_Label\tmA\tmm\tdegC\t",
                "X_Dimension\tTime\tTime\tTime\t", fix("X0\t0.0\t0.0\t0.0\t"), fix("Delta_X\t0.250000\t0.250000\t0.250000\t"),
                "***End_of_Header***\t\t\t\t", "X_Value\tCurrent\tDisplacement\tThermocouple\tComment"]
        for k in range(n):
            x = f"{w['t'][k]:.6f}" if x_columns == "One" else ""
            head.append(fix(f"{x}\t{1e3 * w['current'][k]:.6f}\t{1e3 * w['position'][k]:.6f}\t{w['temp'][k]:.6f}"))
        text(file, "\r\n".join(head) + "\r\n")
        rows_of(file, n)
        expect(file, "time_s", w["t"])
        expect(file, "current_a", rounded(1e3 * w["current"], 6) / 1e3)
        expect(file, "position_m", rounded(1e3 * w["position"], 6) / 1e3)
        expect(file, "temperature_c", rounded(w["temp"], 6))

    lvm("labview.lvm", "One", ".")
    lvm("labview_no_x.lvm", "No", ",")

    # columns of a fixed width, quoted ISO times, missing samples in three words
    file = "fixed_width.dat"
    lines = ["  time [min]   duty   position [mm]   force [gf]"]
    for k in range(n):
        pos = {5: "NaN", 6: "---", 7: "n/a"}.get(k, f"{1e3 * w['position'][k]:.4f}")
        lines.append(f"{w['t'][k] / 60:12.6f} {w['duty'][k]:6.2f} {pos:>15} {w['force'][k] / G * 1e3:12.2f}")
    text(file, "\n".join(lines) + "\n")
    pos = rounded(1e3 * w["position"], 4) / 1e3
    pos[5:8] = math.nan
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"] / 60, 6) * 60)
    expect(file, "position_m", pos, [0, 4, 5, 6, 7, 8, n - 1])
    expect(file, "force_n", rounded(w["force"] / G * 1e3, 2) * G / 1e3)

    # old Macintosh line ends, bars, an absolute length
    file = "bars_mac.txt"
    lines = ["| t/s | U/V | I/A | Länge/mm |"]
    for k in range(n):
        lines.append(f"| {w['t'][k]:.2f} | {w['v3'][k]:.4f} | {w['current'][k]:.5f} | {1e3 * w['length'][k]:.3f} |")
    text(file, "\r".join(lines) + "\r")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "v3_v", rounded(w["v3"], 4))
    expect(file, "current_a", rounded(w["current"], 5))
    expect(file, "position_m", rounded(1e3 * w["length"], 3) / 1e3 - 0.16)
    says(file, "less L_0")
    says(file, "over the current it is")

    # strain and stress of a testing machine, Windows-1252 with a superscript
    file = "zugversuch.csv"
    area = math.pi / 4 * 0.125e-3**2
    lines = ["Prüfzeit [s];Dehnung [%];Spannung [N/mm²];Probentemperatur [K]"]
    for k in range(n):
        lines.append(f"{comma(w['t'][k], 2)};{comma(100 * w['position'][k] / 0.16, 4)};{comma(w['force'][k] / area / 1e6, 2)};{comma(w['temp'][k] + 273.15, 2)}")
    text(file, "\n".join(lines) + "\n", "cp1252")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "position_m", rounded(100 * w["position"] / 0.16, 4) * 0.16 / 100)
    expect(file, "force_n", rounded(w["force"] / area / 1e6, 2) * 1e6 * area)
    expect(file, "temperature_c", rounded(w["temp"] + 273.15, 2) - 273.15)

    # a clock of whole seconds: four rows a second
    file = "whole_seconds.csv"
    lines = ["Time,Duty (%),Displacement (mm)"]
    for k in range(n):
        at = datetime(2024, 3, 12, 10, 0, 0) + timedelta(seconds=float(w["t"][k]))
        lines.append(f"{at:%m/%d/%Y %I:%M:%S %p},{100 * w['duty'][k]:.0f},{1e3 * w['position'][k]:.3f}")
    text(file, "\n".join(lines) + "\n")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "position_m", rounded(1e3 * w["position"], 3) / 1e3)
    says(file, "stands still")

    # refused
    text("commas_for_both.csv", "time_s,duty\n" + "".join(f"{k},0,0,5\n" for k in range(10)))
    refused("commas_for_both.csv", "has commas between its columns and in its numbers")
    text("no_table.txt", "Dear colleague,\nthe files are on the other disk.\nRegards\n")
    refused("no_table.txt", "has no rows of numbers")
    text("empty.csv", "\n\n")
    refused("empty.csv", "is empty")
    lines = ["t_s,position_mm"] + [f"{k},{k / 10}" for k in range(20)]
    lines[12] = "11,1.1,7"
    text("row_too_long.csv", "\n".join(lines) + "\n")
    refused("row_too_long.csv", "row_too_long.csv:13: has 3 cells in this row")
    lines = ["t_s,position_mm"] + [f"{k},{k / 10}" for k in range(20)]
    lines[7] = "6,overload!"
    text("word_in_column.csv", "\n".join(lines) + "\n")
    refused("word_in_column.csv", "word_in_column.csv:8: column \"position_mm\": \"overload!\" is no number")
    text("page.html", "<html><body><table><tr><td>1</td></tr></table></body></html>")
    refused("page.html", "web page")


def by_pandas():
    w = wire(phase=7)
    n = len(w["t"])

    def table(**columns):
        return pd.DataFrame(columns)

    def common(file, frame, names, factors, digits):
        rows_of(file, n)
        for (quantity, key), name, factor, d in zip(names, frame.columns, factors, digits):
            expect(file, quantity, rounded(w[key] / factor, d) * factor)

    # Japanese, Shift-JIS
    file = "keisoku_sjis.csv"
    frame = table(**{"時間(s)": rounded(w["t"], 2), "デューティ(%)": rounded(100 * w["duty"], 1), "変位(mm)": rounded(1e3 * w["position"], 3),
                     "荷重(N)": rounded(w["force"], 3), "温度(℃)": rounded(w["temp"], 1), "室温(℃)": rounded(w["ambient"], 1)})
    frame.to_csv(HERE / file, index=False, encoding="shift_jis")
    by(file, "pandas to_csv")
    common(file, frame, [("time_s", "t"), ("duty", "duty"), ("position_m", "position"), ("force_n", "force"), ("temperature_c", "temp"), ("ambient_c", "ambient")],
           [1, 0.01, 1e-3, 1, 1, 1], [2, 1, 3, 3, 1, 1])
    says(file, "Shift_JIS")

    # German, decimal commas, UTF-8 with a mark, an index column
    file = "pandas_de.csv"
    frame = table(**{"Zeit [s]": rounded(w["t"], 2), "Heizleistung [W]": rounded(w["power"], 4), "Weg [mm]": rounded(1e3 * w["position"], 3)})
    frame.to_csv(HERE / file, sep=";", decimal=",", encoding="utf-8-sig")
    by(file, "pandas to_csv")
    common(file, frame, [("time_s", "t"), ("power_w", "power"), ("position_m", "position")], [1, 1, 1e-3], [2, 4, 3])

    # UTF-16 with tabs, ISO times with a zone
    file = "pandas_utf16.txt"
    stamps = pd.date_range("2024-03-12T10:00:00", periods=n, freq="250ms", tz="Europe/Berlin")
    frame = table(timestamp=stamps, duty=rounded(w["duty"], 2), force_mN=rounded(1e3 * w["force"], 1), displacement_um=rounded(1e6 * w["position"], 1))
    frame.to_csv(HERE / file, sep="\t", index=False, encoding="utf-16")
    by(file, "pandas to_csv")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "duty", rounded(w["duty"], 2))
    expect(file, "force_n", rounded(1e3 * w["force"], 1) / 1e3)
    expect(file, "position_m", rounded(1e6 * w["position"], 1) / 1e6)

    # gzipped, seconds since 1970
    file = "epoch.csv.gz"
    frame = table(unix_time=rounded(1710237600 + w["t"], 2), current_mA=rounded(1e3 * w["current"], 1), stroke_mm=rounded(1e3 * w["position"], 3))
    frame.to_csv(HERE / file, index=False, compression={"method": "gzip", "mtime": 0})
    by(file, "pandas to_csv")
    rows_of(file, n)
    expect(file, "time_s", rounded(1710237600 + w["t"], 2))
    expect(file, "current_a", rounded(1e3 * w["current"], 1) / 1e3)
    expect(file, "position_m", rounded(1e3 * w["position"], 3) / 1e3)

    # two headers, as of a pivoted frame
    file = "two_headers.csv"
    frame = pd.DataFrame({("Zeit", "s"): rounded(w["t"], 2), ("Strom", "mA"): rounded(1e3 * w["current"], 1), ("Weg", "mm"): rounded(1e3 * w["position"], 3)})
    frame.to_csv(HERE / file, index=False, sep=";")
    by(file, "pandas to_csv")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "current_a", rounded(1e3 * w["current"], 1) / 1e3)
    expect(file, "position_m", rounded(1e3 * w["position"], 3) / 1e3)

    # numpy.savetxt with its own header, and without
    file = "savetxt.txt"
    np.savetxt(HERE / file, np.column_stack([w["t"], w["duty"], 1e3 * w["position"]]), header="t[s] duty[-] position[mm]", fmt="%.6e")
    by(file, "numpy savetxt")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "duty", np.array([float(f"{v:.6e}") for v in w["duty"]]))
    expect(file, "position_m", np.array([float(f"{1e3 * v:.6e}") for v in w["position"]]) / 1e3)
    file = "savetxt_semicolon.txt"
    np.savetxt(HERE / file, np.column_stack([1e3 * w["t"], w["temp"], w["ambient"], 1e3 * w["length"]]), delimiter=";", comments="% ", fmt="%.4f",
               header="Wire test 12\nt_ms;T_wire_degC;T_ambient_degC;length_mm")
    by(file, "numpy savetxt")
    rows_of(file, n)
    expect(file, "time_s", rounded(1e3 * w["t"], 4) / 1e3)
    expect(file, "temperature_c", rounded(w["temp"], 4))
    expect(file, "ambient_c", rounded(w["ambient"], 4))
    expect(file, "position_m", rounded(1e3 * w["length"], 4) / 1e3 - 0.16)
    file = "npy_array.npy"
    np.save(HERE / file, np.column_stack([w["t"], w["duty"]]))
    by(file, "numpy save")
    refused(file, "savetxt")


def sheets():
    import openpyxl
    import xlsxwriter
    import xlwt

    w = wire(n=50)
    n = len(w["t"])

    # openpyxl: title, units in their own row, dates, a chart's sheet before, text after
    file = "openpyxl.xlsx"
    book = openpyxl.Workbook()
    book.active.title = "Info"
    book.active.append(["Messung", "FGL 12"])
    book.active.append(["Masse", 0.2])
    sheet = book.create_sheet("Messwerte")
    sheet.append(["Messung vom 12.03.2024"])
    sheet.append([])
    sheet.append(["Zeitstempel", "Tastgrad", "Weg", "Kraft", "Bemerkung"])
    sheet.append([None, "%", "mm", "N", None])
    start = datetime(2024, 3, 12, 10, 0, 0)
    for k in range(n):
        sheet.append([start + timedelta(seconds=float(w["t"][k])), float(100 * w["duty"][k]), float(1e3 * w["position"][k]), float(w["force"][k]),
                      "an" if k == 20 else None])
    book.save(HERE / file)
    by(file, "openpyxl")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "duty", w["duty"])
    expect(file, "position_m", w["position"])
    expect(file, "force_n", w["force"])
    says(file, "Messwerte")

    # xlsxwriter: a merged group header over pairs of columns, times of day, an empty column
    file = "xlsxwriter.xlsx"
    book = xlsxwriter.Workbook(HERE / file)
    sheet = book.add_worksheet("Daten")
    clock = book.add_format({"num_format": "hh:mm:ss.000"})
    sheet.write_row(0, 0, ["Zeit", "Strom (mA)", "", "Spannung (V)", "Weg (mm)"])
    for k in range(n):
        sheet.write_datetime(k + 1, 0, (datetime(1900, 1, 1, 9, 30) + timedelta(seconds=float(w["t"][k]))).time(), clock)
        sheet.write_number(k + 1, 1, float(1e3 * w["current"][k]))
        sheet.write_number(k + 1, 3, float(w["v3"][k]))
        if k != 9:
            sheet.write_number(k + 1, 4, float(1e3 * w["position"][k]))
    book.close()
    by(file, "xlsxwriter")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "current_a", w["current"])
    expect(file, "v3_v", w["v3"])
    pos = w["position"].copy()
    pos[9] = math.nan
    expect(file, "position_m", pos, [0, 8, 9, 10, n - 1])

    # xlwt: the old format, numbers that are texts with commas
    file = "xlwt.xls"
    book = xlwt.Workbook()
    sheet = book.add_sheet("Tabelle1")
    for c, name in enumerate(["t [s]", "PWM [%]", "Position [mm]"]):
        sheet.write(0, c, name)
    for k in range(n):
        sheet.write(k + 1, 0, comma(w["t"][k], 2))
        sheet.write(k + 1, 1, comma(100 * w["duty"][k], 1))
        sheet.write(k + 1, 2, comma(1e3 * w["position"][k], 3))
    book.save(str(HERE / file))
    by(file, "xlwt")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 2))
    expect(file, "duty", rounded(100 * w["duty"], 1) / 100)
    expect(file, "position_m", rounded(1e3 * w["position"], 3) / 1e3)

    # pandas with odfpy
    file = "odfpy.ods"
    frame = pd.DataFrame({"Time (s)": w["t"], "Power (mW)": 1e3 * w["power"], "Displacement (mm)": 1e3 * w["position"], "Load (g)": w["force"] / G * 1e3})
    frame.to_excel(HERE / file, index=False, engine="odf")
    by(file, "pandas with odfpy")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "power_w", w["power"])
    expect(file, "position_m", w["position"])
    expect(file, "force_n", w["force"])

    # LibreOffice and Gnumeric out of one sheet with German formats
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "quelle.xlsx"
        book = openpyxl.Workbook()
        sheet = book.active
        sheet.title = "Messung"
        sheet.append(["Zeit [s]", "Tastverhältnis [%]", "Weg [µm]", "Drahttemperatur [°C]"])
        for k in range(n):
            sheet.append([float(w["t"][k]), float(100 * w["duty"][k]), round(float(1e6 * w["position"][k]), 1), round(float(w["temp"][k]), 2)])
        for row in sheet.iter_rows(min_row=2):
            row[2].number_format = "[$-407]#,##0.0"
            row[3].number_format = "[$-407]0.00"
        book.save(source)

        def german(file, writer):
            by(file, writer)
            rows_of(file, n)
            expect(file, "time_s", w["t"])
            expect(file, "duty", w["duty"])
            expect(file, "position_m", rounded(1e6 * w["position"], 1) / 1e6)
            expect(file, "temperature_c", rounded(w["temp"], 2))

        def office(file, target, locale="en-US"):
            env = dict(os.environ, HOME=folder)
            run("soffice", "--headless", f"-env:UserInstallation=file://{folder}/profile", "--convert-to", target, "--outdir", folder, str(source), env=env)
            shutil.copy(source.with_suffix("." + target.split(":")[0]), HERE / file)
            german(file, "LibreOffice")

        office("libreoffice.ods", "ods")
        office("libreoffice.xls", "xls")
        office("libreoffice.xlsx", "xlsx:Calc MS Excel 2007 XML")
        # as shown, German formats, semicolons, Windows-1252
        office("libreoffice_1252.csv", "csv:Text - txt - csv (StarCalc):59,34,1,1,,1031,false,true")
        office("libreoffice_utf16.csv", "csv:Text - txt - csv (StarCalc):9,34,65535,1,,1031,true,true")

        def gnumeric(file, *options):
            run("ssconvert", *options, str(source), str(HERE / file))
            german(file, "Gnumeric")

        gnumeric("gnumeric.xls")
        # indented XML, which calamine 0.38 does not read
        run("ssconvert", str(source), str(HERE / "gnumeric.ods"))
        by("gnumeric.ods", "Gnumeric")
        refused("gnumeric.ods", "save it again, as .xlsx or as CSV")
        gnumeric("gnumeric.csv")
        gnumeric("gnumeric.txt", "--export-type=Gnumeric_stf:stf_assistant", "-O", "separator=; format=raw charset=ISO-8859-1")


def binaries():
    import h5py
    import hdf5storage
    import scipy.io
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    w = wire(n=60, phase=11)
    n = len(w["t"])

    def whole(file, writer, position="position_m"):
        by(file, writer)
        rows_of(file, n)
        expect(file, "time_s", w["t"])
        expect(file, "duty", w["duty"])
        expect(file, position, w["position"])

    file = "scipy_v5.mat"
    scipy.io.savemat(HERE / file, {"t": w["t"], "duty": w["duty"], "pos_mm": 1e3 * w["position"], "comment": "run 7", "fs": 4.0})
    whole(file, "SciPy savemat")
    file = "scipy_packed.mat"
    scipy.io.savemat(HERE / file, {"data": {"time": w["t"], "pwm": 100 * w["duty"], "displacement_mm": 1e3 * w["position"],
                                             "info": {"operator": "x"}}}, do_compression=True, oned_as="column")
    whole(file, "SciPy savemat")
    file = "scipy_v4.mat"
    scipy.io.savemat(HERE / file, {"time": w["t"], "duty": w["duty"], "position_mm": (1e3 * w["position"]).astype(np.float32)}, format="4")
    by(file, "SciPy savemat")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "position_m", (1e3 * w["position"]).astype(np.float32).astype(float) / 1e3)

    def octave(script):
        with tempfile.TemporaryDirectory() as folder:
            scipy.io.savemat(Path(folder) / "in.mat", {k: v.reshape(-1, 1) for k, v in w.items()})
            run("octave", "--no-gui", "--eval", f"load('{folder}/in.mat'); cd('{HERE}'); {script}")

    octave("duty_percent = 100*duty; weg_mm = 1e3*position; zeit_s = t; save('-v7', 'octave_v7.mat', 'zeit_s', 'duty_percent', 'weg_mm');")
    whole("octave_v7.mat", "GNU Octave")
    octave("s.zeit_s = t; s.pwm = int16(round(1000*duty)); s.strom_mA = 1e3*current; s.weg_mm = 1e3*position; save('-v6', 'octave_v6_struct.mat', 's');")
    file = "octave_v6_struct.mat"
    by(file, "GNU Octave")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "current_a", w["current"])
    expect(file, "position_m", w["position"])
    octave("time_s = t; duty2 = duty; position_mm = 1e3*position; save('-v4', 'octave_v4.mat', 'time_s', 'duty2', 'position_mm');")
    file = "octave_v4.mat"
    by(file, "GNU Octave")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "position_m", w["position"])
    octave("x = [t duty position]; save('-text', 'octave_text.txt', 'x');")
    by("octave_text.txt", "GNU Octave")
    refused("octave_text.txt", "Octave's own text format")
    octave("zeit_s = t; pwm_percent = 100*duty; weg_mm = 1e3*position; save('-hdf5', 'octave_hdf5.h5', 'zeit_s', 'pwm_percent', 'weg_mm');")
    whole("octave_hdf5.h5", "GNU Octave")
    octave("dlmwrite('octave_dlm.txt', [t duty 1e3*position], 'delimiter', '\\t', 'precision', '%.6f');")
    file = "octave_dlm.txt"
    by(file, "GNU Octave")
    rows_of(file, n)
    expect(file, "time_s", rounded(w["t"], 6))
    says(file, "not understood")
    says(file, "its name does not say that it is a time")

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.mat"
        contents = {"t": w["t"], "duty": w["duty"], "pos_mm": (1e3 * w["position"]).reshape(-1, 1), "operator": "K. M.", "fs": 4.0}
        hdf5storage.savemat(str(path), contents, format="7.3", store_python_metadata=False)
        shutil.copy(path, HERE / "matlab_73.mat")
        (HERE / "matlab_73_cut.mat").write_bytes(path.read_bytes()[:900])
    whole("matlab_73.mat", "hdf5storage")
    by("matlab_73_cut.mat", "hdf5storage, cut off")
    refused("matlab_73_cut.mat", "'-v7')")
    with h5py.File(HERE / "h5py.h5", "w") as f:
        f.create_dataset("run/time_ms", data=(1e3 * w["t"]).astype(np.int32), chunks=(20,), compression="gzip")
        f.create_dataset("run/duty", data=w["duty"], chunks=(20,), compression="gzip", shuffle=True)
        f.create_dataset("run/displacement_mm", data=1e3 * w["position"])
    whole("h5py.h5", "h5py")
    file = "waveform.tdms"
    with TdmsWriter(HERE / file) as writer:
        properties = lambda unit: {"wf_increment": 0.25, "wf_start_offset": 0.0, "wf_samples": n, "unit_string": unit, "wf_start_time": np.datetime64("2024-03-12T10:00:00")}
        half = n // 2
        for part in (slice(0, half), slice(half, n)):
            writer.write_segment([RootObject({"name": "wire"}), GroupObject("Messung"),
                                  ChannelObject("Messung", "Strom", 1e3 * w["current"][part], properties("mA")),
                                  ChannelObject("Messung", "Weg", (1e3 * w["position"][part]).astype(np.float32), properties("mm")),
                                  ChannelObject("Messung", "Kraft", w["force"][part], properties("N"))])
    by(file, "nptdms")
    rows_of(file, n)
    expect(file, "time_s", w["t"])
    expect(file, "current_a", w["current"])
    expect(file, "position_m", (1e3 * w["position"]).astype(np.float32).astype(float) / 1e3)
    expect(file, "force_n", w["force"])
    file = "timestamps.tdms"
    stamps = np.datetime64("2024-03-12T10:00:00", "us") + (w["t"] * 1e6).astype("timedelta64[us]")
    with TdmsWriter(HERE / file) as writer:
        writer.write_segment([GroupObject("slow"), ChannelObject("slow", "room temperature", w["ambient"][:5], {"unit_string": "°C"}),
                              GroupObject("fast"), ChannelObject("fast", "time", stamps), ChannelObject("fast", "duty", w["duty"], {}),
                              ChannelObject("fast", "stroke", 1e3 * w["position"], {"unit_string": "mm"}),
                              ChannelObject("fast", "steps", np.arange(n, dtype=np.int32), {})])
    whole(file, "nptdms")
    says(file, "slow")


def ros():
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin, Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_FOXY)
    Float = store.types["std_msgs/msg/Float64"]
    with tempfile.TemporaryDirectory() as folder:
        for plugin, end in ((StoragePlugin.SQLITE3, "db3"), (StoragePlugin.MCAP, "mcap")):
            path = Path(folder) / end
            with Writer2(path, version=9, storage_plugin=plugin) as writer:
                topic = writer.add_connection("/wire/force", Float.__msgtype__, typestore=store)
                for k in range(5):
                    writer.write(topic, 10**9 * k, store.serialize_cdr(Float(data=1.0 * k), Float.__msgtype__))
            written = next(path.glob(f"*.{end}")).read_bytes()
            # a database is mostly empty pages
            (HERE / f"rosbag2.{end}.gz").write_bytes(gzip.compress(written, mtime=0))
            by(f"rosbag2.{end}.gz", "rosbags")
        store = get_typestore(Stores.ROS1_NOETIC)
        Float = store.types["std_msgs/msg/Float64"]
        with Writer1(HERE / "rosbag1.bag") as writer:
            topic = writer.add_connection("/wire/force", Float.__msgtype__, typestore=store)
            for k in range(5):
                writer.write(topic, 10**9 * k, store.serialize_ros1(Float(data=1.0 * k), Float.__msgtype__))
        by("rosbag1.bag", "rosbags")
    refused("rosbag2.db3.gz", "ros2 topic echo --csv")
    refused("rosbag2.mcap.gz", "ros2 topic echo --csv")
    refused("rosbag1.bag", "rostopic echo")


def main():
    shutil.rmtree(HERE, ignore_errors=True)
    HERE.mkdir()
    for make in (by_hand, by_pandas, sheets, binaries, ros):
        make()
    with open(HERE / "expected.csv", "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["file", "quantity", "row", "value"])
        writer.writerows(EXPECTED)
    programs = sorted({writer for _, writer in WRITERS})
    with open(HERE / "README.md", "w") as out:
        out.write("# Files as laboratories have them\n\nWritten by `../make_files.py`, the numbers in them in `expected.csv`.\n\n| file | written by |\n|---|---|\n")
        for file, writer in sorted(WRITERS):
            out.write(f"| `{file}` | {writer} |\n")
        others = sum(1 for _, writer in WRITERS if not writer.startswith("hand"))
        out.write(f"\n{len(WRITERS)} files, {others} of them by other programs.\n")
    large = [p for p in HERE.iterdir() if p.stat().st_size > 30_000 and p.name != "expected.csv"]
    if large:
        sys.exit(f"larger than 30 kB: {large}")


if __name__ == "__main__":
    main()
