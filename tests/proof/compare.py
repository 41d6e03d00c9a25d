#!/usr/bin/env python3
"""What other tools make of the same recordings in one run: SciPy's least_squares through `sinew simulate`, PySINDy.

usage: compare.py SINEW FOLDER [FOLDER...] [--docs docs/proof.md] [--seconds S]

Every FOLDER is a concealed case as `sinew-proof generate` writes it: rig.toml, train.csv.gz, held.csv.gz, answer.json.
Fitted is train.csv.gz, judged is held.csv.gz, which nobody is given. Errors are chi over all sensors in true noise.
With --docs the table goes into that page, between its markers. Without scipy, or pysindy, that row is skipped and
said to be."""
import argparse
import gzip
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time

try:
    import numpy as np
except ImportError:
    sys.exit("compare.py needs numpy: pip install numpy")
try:
    import scipy
    from scipy.optimize import least_squares
except ImportError:
    least_squares = None
try:
    import pysindy
except ImportError:
    pysindy = None

SENSORS = ["current_a", "v1_v", "v2_v", "v3_v", "force_n", "position_m"]
BEGIN, END = "<!-- comparison: begin -->", "<!-- comparison: end -->"
# keys of the rig file that a person would fit, with 1 sigma as a share of the value or in its unit
FITTED = {
    "convection_w_per_m2_k": ("share", 0.2),
    "heating_steepness_per_k": ("share", 0.25),
    "cooling_steepness_per_k": ("share", 0.25),
    "austenite_resistivity_uohm_cm": ("share", 0.1),
    "martensite_resistivity_uohm_cm": ("share", 0.1),
    "transformation_strain": ("share", 0.15),
    "austenite_modulus_gpa": ("share", 0.15),
    "martensite_modulus_gpa": ("share", 0.15),
    "latent_heat_j_per_kg": ("share", 0.25),
    "stress_shift_k_per_mpa": ("share", 0.2),
    "damping_n_s_per_m": ("share", 0.3),
    "austenite_temperature_c": ("unit", 5.0),
    "martensite_temperature_c": ("unit", 5.0),
    "ambient_c": ("unit", 2.0),
}


def table(path):
    opened = gzip.open(path, "rt") if path.endswith(".gz") else open(path)
    with opened as file:
        return np.genfromtxt(file, delimiter=",", names=True)


def shown(data, answer):
    return [s for s in SENSORS if s in data.dtype.names and s in answer["noise"]]


def chi(simulated, measured, answer):
    """Over all sensors, every sample counted alike."""
    errors = [(simulated[s] - measured[s]) / answer["noise"][s] for s in shown(measured, answer)]
    return math.sqrt(np.nanmean(np.concatenate(errors) ** 2))


def run(*command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError((done.stderr.strip().splitlines() or ["exit code %d" % done.returncode])[-1])
    return done


class Case:
    def __init__(self, sinew, folder, work):
        self.sinew, self.folder, self.work = sinew, folder, work
        self.rig, self.train, self.held = (os.path.join(folder, n) for n in ("rig.toml", "train.csv.gz", "held.csv.gz"))
        self.answer = json.load(open(os.path.join(folder, "answer.json")))
        self.measured = table(self.train)
        self.calls = 0

    def simulated(self, rig, recording):
        out = os.path.join(self.work, "simulated.csv")
        run(self.sinew, "simulate", rig, recording, "-o", out)
        self.calls += 1
        return table(out)

    def kept_back(self, rig):
        return chi(self.simulated(rig, self.held), table(self.held), self.answer)

    # each method: (chi on held.csv.gz, remark)
    def as_given(self):
        return self.kept_back(self.rig), "nothing fitted"

    def identify(self):
        out = os.path.join(self.work, "fitted.toml")
        run(self.sinew, "identify", self.rig, self.train, "-o", out)
        return self.kept_back(out), "the reference model's parameters and the rig's constants"

    def diagnose(self):
        out = os.path.join(self.work, "answer")
        run(self.sinew, "diagnose", self.rig, self.train, "--out", out)
        said = json.load(open(os.path.join(out, "diagnosis.json")))
        names = ", ".join(e["id"] for e in said["effects"] if e["grade"] != "suspected")
        return self.kept_back(os.path.join(out, "improved.toml")), said["verdict"] + (f": {names}" if names else "")

    def least_squares(self, seconds):
        """The same simulator in a general-purpose fit: parameters as shares of their sigma, residuals and priors."""
        text = open(self.rig).read()
        values = {}
        for key in FITTED:
            found = re.search(rf"^{key} = (\S+)$", text, re.M)
            if found and float(found.group(1)) != 0:
                values[key] = float(found.group(1))
        keys = list(values)
        sigmas = [s * (abs(values[k]) if kind == "share" else 1.0) for k in keys for kind, s in [FITTED[k]]]

        def written(z):
            new = text
            for key, sigma, step in zip(keys, sigmas, z):
                value = max(values[key] + sigma * step, 1e-3 * abs(values[key]))
                new = re.sub(rf"^{key} = \S+$", f"{key} = {value:.9g}", new, flags=re.M)
            path = os.path.join(self.work, "tried.toml")
            open(path, "w").write(new)
            return path

        names = shown(self.measured, self.answer)
        count = sum(np.isfinite(self.measured[s]).sum() for s in names)
        started = time.time()

        class Enough(Exception):
            pass

        best = [math.inf, np.zeros(len(keys))]

        def residual(z):
            if time.time() - started > seconds:
                raise Enough
            try:
                simulated = self.simulated(written(z), self.train)
            except RuntimeError:
                return np.full(count + len(keys), 1e3)
            parts = [(simulated[s] - self.measured[s]) / self.answer["noise"][s] for s in names]
            errors = np.concatenate(parts)
            all_of_it = np.concatenate([errors[np.isfinite(errors)], z])
            cost = float(all_of_it @ all_of_it)
            if cost < best[0]:
                best[:] = [cost, z.copy()]
            return all_of_it

        try:
            # steps of a hundredth of sigma: machine-size ones stall on hysteresis
            least_squares(residual, np.zeros(len(keys)), method="trf", diff_step=1e-2, x_scale=1.0, max_nfev=60)
            remark = "converged or 60 rounds"
        except Enough:
            remark = f"stopped after {seconds:.0f} s"
        return self.kept_back(written(best[1])), f"{len(keys)} parameters, {remark}"

    def sindy(self):
        """Sparse regression on what is measured: no temperature, no phase; simulated forward on held.csv.gz."""
        held = table(self.held)
        names = [s for s in shown(self.measured, self.answer) if s not in ("v1_v", "v2_v")]
        noise = np.array([self.answer["noise"][s] for s in names])

        def arranged(data):
            x = np.column_stack([data[s] for s in names])
            for column in x.T:
                bad = ~np.isfinite(column)
                column[bad] = np.interp(np.flatnonzero(bad), np.flatnonzero(~bad), column[~bad])
            return data["time_s"], x, data["duty"].reshape(-1, 1)

        t, x, u = arranged(self.measured)
        middle, scale = x.mean(0), x.std(0)
        dt = float(np.median(np.diff(t)))
        model = pysindy.SINDy(
            differentiation_method=pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": 21}),
            feature_library=pysindy.PolynomialLibrary(degree=2),
            optimizer=pysindy.STLSQ(threshold=0.05, alpha=0.1),
        )
        model.fit((x - middle) / scale, t=dt, u=u)
        terms = int(np.count_nonzero(model.coefficients()))
        t, measured, u = arranged(held)
        state = (measured[0] - middle) / scale
        path = [state]
        # forward by the improved Euler rule; a model that runs away is held at ten deviations
        for i in range(len(t) - 1):
            def rate(s):
                return np.asarray(model.predict(s.reshape(1, -1), u=u[i].reshape(1, -1))).ravel()
            step = t[i + 1] - t[i]
            first = rate(state)
            state = state + 0.5 * step * (first + rate(np.clip(state + step * first, -10, 10)))
            state = np.clip(np.nan_to_num(state), -10, 10)
            path.append(state)
        error = (np.array(path) * scale + middle - measured) / noise
        return math.sqrt(np.mean(error**2)), f"{terms} terms on {', '.join(names)}; what is hidden is not in it"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sinew")
    parser.add_argument("folders", nargs="+", metavar="FOLDER")
    parser.add_argument("--docs")
    parser.add_argument("--seconds", type=float, default=120.0, help="after which least_squares is stopped")
    args = parser.parse_args()
    rows = []
    for folder in args.folders:
        with tempfile.TemporaryDirectory() as work:
            case = Case(args.sinew, folder, work)
            concealed = case.answer["kind"]
            methods = [("the rig file as given", case.as_given), ("`sinew identify`", case.identify),
                       ("`sinew diagnose`", case.diagnose)]
            if least_squares:
                methods.append((f"SciPy {scipy.__version__} `least_squares` through `sinew simulate`",
                                lambda: case.least_squares(args.seconds)))
            else:
                print("scipy is missing: its row is skipped (pip install scipy)", file=sys.stderr)
            if pysindy:
                methods.append((f"PySINDy {pysindy.__version__}", case.sindy))
            else:
                print("pysindy is missing: its row is skipped (pip install pysindy)", file=sys.stderr)
            for name, method in methods:
                case.calls = 0
                started = time.time()
                try:
                    error, remark = method()
                    error = f"{error:.2f}" if error < 100 else f"{error:.0f}"
                except (RuntimeError, ValueError, np.linalg.LinAlgError) as trouble:
                    error, remark = "–", str(trouble).replace("|", "/")[:120]
                took = time.time() - started
                rows.append((case.answer["name"], concealed, name, error, f"{took:.1f}", remark))
                print(" | ".join(rows[-1]), flush=True)
    text = ["| case | concealed | method | chi, kept back | time, s | |", "|---|---|---|--:|--:|---|"]
    text += ["| " + " | ".join(row) + " |" for row in rows]
    section = "\n".join(
        [BEGIN, "## Beside other tools", "",
         "The same recordings in one run of `tests/proof/compare.py`, development seeds. Chi is over all sensors in "
         "true noise, of a recording that no method was given; times are wall times, the kept-back simulation "
         "included. `least_squares` is given the parameters a person would fit, their priors and the true noise, and "
         "calls the simulator as a process; PySINDy is given every measured column and knows no hidden state.", ""]
        + text + [END])
    if args.docs:
        page = open(args.docs).read()
        if BEGIN in page and END in page:
            page = page[: page.index(BEGIN)] + section + page[page.index(END) + len(END):]
        else:
            page = page.rstrip() + "\n\n" + section + "\n"
        open(args.docs, "w").write(page)
    else:
        print("\n" + section)


if __name__ == "__main__":
    main()
