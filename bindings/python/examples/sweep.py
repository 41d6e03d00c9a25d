"""A laboratory's sweep on Dask: a Monte-Carlo simulation, and a diagnosis of every recording, on as many machines as there are.

    pip install "dask[distributed]" sinew
    python sweep.py                          # on this machine
    python sweep.py tcp://scheduler:8786     # on a cluster whose workers have sinew installed

The functions of sinew are plain ones: they release the interpreter, take and return NumPy, and their results are pickled
like anything else. Nothing of sinew has to know of the scheduler. Each worker computes one thing at a time, so each is given one
thread (`jobs=1`).
"""

import sys
import time

import numpy as np
from distributed import Client, LocalCluster

import sinew

RIG = """
[rig]
name = "sweep"
rate_hz = 100.0
[[channel]]
name = "wire"
wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}
taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}
drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}
load = {{ mass_kg = {mass_kg}, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}
material = {{ convection_w_per_m2_k = {convection} }}
"""
TIME_S = np.arange(0, 60, 0.01)
DUTY = np.where(TIME_S % 5 < 2.5, 0.2 + 0.008 * (TIME_S // 5), 0.02)


def contraction_m(seed: int) -> float:
    """How far a wire drawn at random contracts, m: its mass and the air around it are known to 10 and 20 %."""
    random = np.random.default_rng(seed)
    rig = RIG.format(mass_kg=0.08 * random.normal(1, 0.1), convection=121.2 * random.normal(1, 0.2))
    position = sinew.simulate(rig, {"time_s": TIME_S, "duty": DUTY})["position_m"]
    return float(position.max() - position.min())


def verdict(seed: int) -> str:
    """What a diagnosis says of a recording of such a wire."""
    random = np.random.default_rng(seed)
    true = sinew.simulate(
        RIG.format(mass_kg=0.08, convection=121.2 * random.normal(1, 0.2)), {"time_s": TIME_S, "duty": DUTY}
    )
    recording = {name: true[name] for name in ("time_s", "duty")}
    recording["position_m"] = true["position_m"] + 15e-6 * random.standard_normal(TIME_S.size)
    return sinew.diagnose(RIG.format(mass_kg=0.08, convection=121.2), recording, jobs=1, progress=False).verdict


def timed(client: Client, function, seeds) -> tuple:
    """The results, and the seconds it took."""
    begun = time.monotonic()
    results = client.gather(client.map(function, seeds, pure=False))
    return results, time.monotonic() - begun


def main() -> None:
    """Runs both; on a cluster of its own first with one worker, then with two."""
    if len(sys.argv) > 1:
        with Client(sys.argv[1]) as client:
            report(client, 400, 40)
        return
    seconds = {}
    for workers in (1, 2):
        with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
            with Client(cluster) as client:
                client.gather(client.map(contraction_m, range(workers)))  # everybody has imported it
                seconds[workers] = report(client, 200, 8)
    for name in seconds[1]:
        print(f"{name}: two workers are {seconds[1][name] / seconds[2][name]:.2f} times as fast as one")


def report(client: Client, simulations: int, diagnoses: int) -> dict:
    """Says what came out, and how long it took."""
    contractions, simulating_s = timed(client, contraction_m, range(simulations))
    low, median, high = np.quantile(contractions, [0.05, 0.5, 0.95])
    print(f"{simulations} wires contract by {1e3 * median:.2f} mm (90 %: {1e3 * low:.2f} to {1e3 * high:.2f}): {simulating_s:.1f} s")
    verdicts, diagnosing_s = timed(client, verdict, range(diagnoses))
    said = {word: verdicts.count(word) for word in sorted(set(verdicts))}
    print(f"{diagnoses} recordings: {said}: {diagnosing_s:.1f} s")
    return {"simulate": simulating_s, "diagnose": diagnosing_s}


if __name__ == "__main__":
    main()
