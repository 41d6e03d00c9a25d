"""Writes fixture.json: appendix A's conversions and gains for some systems, computed independently.

Conversions, eigenvalues and placed gains by scipy; the Riccati equations by eigenvectors in 50 digits (mpmath), since
scipy's own solvers keep only 7 for the states of a wire.
Run as `python3 fixture.py > fixture.json` with numpy 2.4, scipy 1.17 and mpmath 1.3.
"""

import json

import mpmath
import numpy as np
from scipy import linalg, signal

# Table 10's rig with chapter 9's martensite form at dxi/dT = -0.05/K (eq. 53): states of very different units.
AREA, LENGTH, MODULUS, STRAIN = np.pi * 0.1e-3**2 / 4, 0.233, 51.5e9, 0.04
MASS, SPRING, DAMPING = 0.13, 18.0, 0.915
CAPACITY = 6450 * AREA * LENGTH * 836
LATENT = 6450 * AREA * LENGTH * 24200
LOSS = 121.2 * np.pi * 0.1e-3 * LENGTH
SLOPE = -0.05
Q_HEAT = CAPACITY - LATENT * SLOPE
K_SMA = AREA * MODULUS / LENGTH
WIRE_A = np.array(
    [
        [0, 1, 0, 0],
        [-(SPRING + K_SMA) / MASS, -DAMPING / MASS, K_SMA * LENGTH * STRAIN / MASS, 0],
        [0, 0, 0, -LOSS * SLOPE / Q_HEAT],
        [0, 0, 0, -LOSS / Q_HEAT],
    ]
)
WIRE_B = np.array([[0], [0], [SLOPE / Q_HEAT], [1 / Q_HEAT]])
# Its velocity form (eq. 63), which is controllable.
VELOCITY_A = np.array(
    [
        [0, 1, 0],
        [-(SPRING + K_SMA) / MASS, -DAMPING / MASS, SLOPE * K_SMA * LENGTH * STRAIN / MASS],
        [0, 0, -LOSS / Q_HEAT],
    ]
)
VELOCITY_B = np.array([[0], [0], [1 / Q_HEAT]])

mpmath.mp.dps = 50


def subspace(m, wanted):
    """X of the invariant subspace [I; X] of the eigenvalues that are wanted."""
    n = m.rows // 2
    values, vectors = mpmath.eig(m)
    chosen = [k for k in range(2 * n) if wanted(values[k])]
    assert len(chosen) == n
    top = mpmath.matrix(n, n)
    low = mpmath.matrix(n, n)
    for j, k in enumerate(chosen):
        for i in range(n):
            top[i, j], low[i, j] = vectors[i, k], vectors[n + i, k]
    x = low * top**-1
    return np.array([[float(x[i, j].real) for j in range(n)] for i in range(n)])


def blocks(a, b, c, d):
    n = a.rows
    m = mpmath.matrix(2 * n, 2 * n)
    for i in range(n):
        for j in range(n):
            m[i, j], m[i, n + j], m[n + i, j], m[n + i, n + j] = a[i, j], b[i, j], c[i, j], d[i, j]
    return m


def care(a, b, q, r):
    a, b, q, r = (mpmath.matrix(m.tolist()) for m in (a, b, q, r))
    return subspace(blocks(a, -b * r**-1 * b.T, -q, -a.T), lambda v: v.real < 0)


def dare(a, b, q, r):
    a, b, q, r = (mpmath.matrix(m.tolist()) for m in (a, b, q, r))
    g, back = b * r**-1 * b.T, (a.T) ** -1
    return subspace(blocks(a + g * back * q, -g * back, -back * q, back), lambda v: abs(v) < 1)


rng = np.random.default_rng(7)


def case(name, a, b, c, poles, observer_poles, dt, q=None, r=None, noise=None, sigma=None):
    n, m, p = a.shape[0], b.shape[1], c.shape[0]
    q = np.eye(n) if q is None else q
    r = np.eye(m) if r is None else r
    noise = np.eye(n) if noise is None else noise
    sigma = np.eye(p) if sigma is None else sigma
    ad, bd, *_ = signal.cont2discrete((a, b, c, np.zeros((p, m))), dt)
    # the noise integral by quadrature, not by the exponential that is under test
    nodes, weights = np.polynomial.legendre.leggauss(60)
    qd = sum(
        0.5 * dt * w * linalg.expm(a * t) @ noise @ linalg.expm(a * t).T
        for t, w in zip(0.5 * dt * (nodes + 1), weights)
    )
    out = dict(name=name, dt=dt, a=a, b=b, c=c, q=q, r=r, noise=noise, sigma=sigma, ad=ad, bd=bd, qd=qd)
    out["eigenvalues"] = [[v.real, v.imag] for v in linalg.eigvals(a)]
    if poles is not None:
        out["poles"] = [[complex(v).real, complex(v).imag] for v in poles]
        out["k_placed"] = signal.place_poles(a, b, poles, rtol=1e-12, maxiter=200).gain_matrix
        out["care"] = care(a, b, q, r)
        out["lqr"] = np.linalg.solve(r, b.T @ out["care"])
        out["dare"] = dare(ad, bd, q, r)
        x = out["dare"]
        out["dlqr"] = np.linalg.solve(r + bd.T @ x @ bd, bd.T @ x @ ad)
    if observer_poles is not None:
        out["observer_poles"] = [[complex(v).real, complex(v).imag] for v in observer_poles]
        out["l_placed"] = signal.place_poles(a.T, c.T, observer_poles, rtol=1e-12, maxiter=200).gain_matrix.T
        p_c = care(a.T, c.T, noise, sigma)
        out["lqe"] = p_c @ c.T @ np.linalg.inv(sigma)
        p_d = dare(ad.T, c.T, qd, sigma)
        out["dlqe"] = p_d @ c.T @ np.linalg.inv(c @ p_d @ c.T + sigma)
    return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in out.items()}


cases = [
    case(
        "martensite form of the wire of table 10",
        WIRE_A,
        WIRE_B,
        np.array([[1.0, 0, 0, 0]]),
        None,
        [-8.0, -9.0, -10 + 60j, -10 - 60j],
        1e-3,
        noise=np.diag([1e-10, 1e-6, 1e-4, 1e2]),
        sigma=np.array([[1e-12]]),
    ),
    case(
        "velocity form of the wire of table 10",
        VELOCITY_A,
        VELOCITY_B,
        np.array([[1.0, 0, 0]]),
        [-3.0, -10 + 60j, -10 - 60j],
        [-30.0, -20 + 60j, -20 - 60j],
        1e-3,
        q=np.diag([25e4, 0.0, 0.0]),
        noise=np.diag([1e-8, 1e-4, 1e2]),
        sigma=np.array([[1e-8]]),
    ),
    case(
        "oscillator with an unstable mode",
        np.array([[0, 1.0, 0], [-4, -0.1, 1], [0.2, 0, 0.5]]),
        np.array([[0.0], [0], [1]]),
        np.array([[1.0, 0, 0]]),
        [-1 + 1j, -1 - 1j, -2.0],
        [-4 + 1j, -4 - 1j, -5.0],
        0.1,
    ),
]
for n in (2, 3, 5, 6):
    cases.append(
        case(
            f"random, {n} states",
            rng.normal(size=(n, n)),
            rng.normal(size=(n, 1)),
            rng.normal(size=(1, n)),
            -np.arange(1.0, n + 1),
            -np.arange(2.0, n + 2),
            0.05,
        )
    )
print(json.dumps(cases, indent=0).replace("\n", " ").replace("}, {", "},\n{"))
