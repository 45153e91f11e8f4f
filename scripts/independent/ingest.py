"""Independent computation of what `ingest` does to measured channels, for the tests named `oracle_*` of crates/logs, and
small made-up logs for the stage's own tests.

    python scripts/independent/ingest.py --oracle fixtures/oracle --logs fixtures/logs

Needs numpy, scipy and pyarrow. It shares no code with the workspace and goes another way where there is one: filters by
scipy or by polynomials fitted window by window, averages by masks, radii of curvature by differentiating the ellipsoid,
lever arms as complex numbers, moments as a cross product of vectors in space, lags by numpy's correlation coefficients.
The same bytes come out again on one machine.
"""

from __future__ import annotations

import argparse
import gzip
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.integrate import solve_ivp
from scipy.signal import savgol_filter
from scipy.stats import norm

SEMI_MAJOR, FLATTENING = 6378137.0, 1.0 / 298.257223563


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--oracle", type=Path, required=True)
    parser.add_argument("--logs", type=Path, required=True)
    arguments = parser.parse_args()
    document = {
        "euler": euler(),
        "smoother": smoother(),
        "noise": noise(),
        "resampling": resampling(),
        "lever": lever(),
        "azimuth": azimuth(),
        "lag": lag(),
    }
    text = json.dumps(document, default=lambda array: np.asarray(array).tolist(), indent=1)
    (arguments.oracle / "ingest.json").write_text(text + "\n")
    for run, seconds in (("a", 60), ("b", 45)):
        write_logs(arguments.logs, run, seconds)


def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Surge, sway, yaw rate of the made-up ship."""
    return 1.0 + 0.2 * np.sin(0.15 * t), 0.1 * np.sin(0.2 * t), 0.12 * np.cos(0.1 * t)


def heading(t: np.ndarray) -> np.ndarray:
    """The integral of the yaw rate, from 5.9 rad, so that a compass passes north and wraps."""
    return 5.9 + 1.2 * np.sin(0.1 * t)


def track(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """North and east of the reference point."""

    def rate(time: float, _: np.ndarray) -> list[float]:
        u, v, _r = motion(np.float64(time))
        velocity = (u + 1j * v) * np.exp(1j * heading(np.float64(time)))
        return [velocity.real, velocity.imag]

    solution = solve_ivp(rate, (0.0, t[-1] + 1.0), [0.0, 0.0], t_eval=t, rtol=1e-11, atol=1e-12)
    return solution.y[0], solution.y[1]


def euler() -> dict:
    t = np.arange(0.0, 12.0, 0.5)
    x, y = track(t)
    psi = heading(t)
    velocity = np.diff(x + 1j * y) / 0.5 * np.exp(-1j * psi[:-1])
    return {"dt": 0.5, "x": x, "y": y, "psi": psi, "u": velocity.real, "v": velocity.imag, "r": np.diff(psi) / 0.5}


def smoother() -> dict:
    generator = np.random.Generator(np.random.PCG64(1))
    t = 0.1 * np.arange(60)
    values = np.sin(t) + 0.1 * t**2 + 0.05 * generator.standard_normal(60)
    uneven = np.cumsum(generator.uniform(0.05, 0.2, 60))
    fits = [window_fit(uneven, values, i, 9) for i in range(60)]
    return {
        "t": t,
        "values": values,
        "window": 11,
        "smooth": savgol_filter(values, 11, 2, mode="interp"),
        "slope": savgol_filter(values, 11, 2, deriv=1, delta=0.1, mode="interp"),
        "uneven_t": uneven,
        "uneven_window": 9,
        "uneven_smooth": [fit[0] for fit in fits],
        "uneven_slope": [fit[1] for fit in fits],
    }


def window_fit(t: np.ndarray, values: np.ndarray, i: int, window: int) -> tuple[float, float]:
    first = min(max(i - window // 2, 0), len(t) - window)
    part = slice(first, first + window)
    fit = np.polynomial.Polynomial.fit(t[part], values[part], 2)
    return float(fit(t[i])), float(fit.deriv()(t[i]))


def noise() -> dict:
    generator = np.random.Generator(np.random.PCG64(2))
    t = 0.1 * np.arange(400)
    values = np.sin(0.5 * t) + 0.02 * generator.standard_normal(400)
    residual = (values - savgol_filter(values, 11, 2))[5:-5]
    weight = savgol_filter(np.eye(11)[5], 11, 2)[5]
    std = np.median(np.abs(residual)) / norm.ppf(0.75) / np.sqrt(1.0 - weight)
    return {"t": t, "values": values, "std": float(std)}


def resampling() -> dict:
    """A channel on an uneven clock with one gap; averaged over 0.6 s; both on a grid. null: unknown."""
    generator = np.random.Generator(np.random.PCG64(3))
    t = np.cumsum(generator.uniform(0.05, 0.15, 80))
    t[40:] += 1.5
    values = np.cos(t) + 0.1 * generator.standard_normal(80)
    grid = t[0] - 0.3 + 0.25 * np.arange(48)
    averaged = np.concatenate([average(t[:40], values[:40], 0.6), average(t[40:], values[40:], 0.6)])
    known = ((grid >= t[0]) & (grid <= t[39])) | ((grid >= t[40]) & (grid <= t[-1]))

    def on_grid(channel: np.ndarray) -> list[float | None]:
        return [float(value) if ok else None for value, ok in zip(np.interp(grid, t, channel), known)]

    return {
        "t": t, "values": values, "max_gap_s": 0.5, "average_s": 0.6, "grid": grid,
        "plain": on_grid(values), "averaged": on_grid(averaged),
    }  # fmt: skip


def average(t: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    half = np.minimum(width / 2, np.minimum(t - t[0], t[-1] - t)) + 1e-6
    return np.array([values[np.abs(t - time) <= h].mean() for time, h in zip(t, half)])


def on_ellipsoid(latitude: float, longitude: float) -> np.ndarray:
    e2 = FLATTENING * (2.0 - FLATTENING)
    n = SEMI_MAJOR / np.sqrt(1.0 - e2 * np.sin(latitude) ** 2)
    return np.array(
        [
            n * np.cos(latitude) * np.cos(longitude),
            n * np.cos(latitude) * np.sin(longitude),
            n * (1.0 - e2) * np.sin(latitude),
        ]
    )


def radii(latitude: float, longitude: float) -> tuple[float, float]:
    """Metres per radian of latitude and of longitude: lengths of the ellipsoid's derivatives (central, fourth order)."""

    def length(direction: tuple[float, float]) -> float:
        h = 1e-3
        point = lambda k: on_ellipsoid(latitude + k * h * direction[0], longitude + k * h * direction[1])  # noqa: E731
        return float(np.linalg.norm((8.0 * (point(1) - point(-1)) - (point(2) - point(-2))) / (12.0 * h)))

    return length((1.0, 0.0)), length((0.0, 1.0))


def lever() -> list[dict]:
    cases = []
    for arm, position, psi, velocity, r in (
        ((3.0, -1.0), (10.0, 20.0), 0.7, (2.0, -0.3), 0.05),
        ((-12.5, 0.4), (-3.0, 4.0), -2.5, (0.4, 0.2), -0.11),
    ):
        arm_c, turn = complex(*arm), np.exp(1j * psi)
        at = complex(*position) - arm_c * turn
        moved = complex(*velocity) - 1j * r * arm_c
        cases.append({
            "arm": arm, "position": position, "psi": psi, "velocity": velocity, "r": r,
            "reference_position": [at.real, at.imag], "reference_velocity": [moved.real, moved.imag],
        })  # fmt: skip
    return cases


def azimuth() -> list[dict]:
    """Two stern thrusters and one forward, z down: the moment is the z component of position × force."""
    cases = []
    for place, coefficient, n, alpha in (
        ((-0.4, 0.1), 0.02, 12.0, 0.0), ((-0.4, -0.1), 0.02, 9.0, 0.6), ((0.45, 0.0), 0.01, -7.0, -2.2),
    ):  # fmt: skip
        force = coefficient * n * abs(n) * np.array([np.cos(alpha), np.sin(alpha), 0.0])
        moment = np.cross([*place, 0.0], force)
        cases.append({
            "position_m": place, "coefficient": coefficient, "n": n, "alpha": alpha,
            "forces": [force[0], force[1], moment[2]],
        })  # fmt: skip
    return cases


def lag() -> dict:
    generator = np.random.Generator(np.random.PCG64(4))
    t = 0.1 * np.arange(600)
    wave = lambda t: np.sin(0.3 * t) + 0.5 * np.sin(0.83 * t + 1.0)  # noqa: E731
    reference = wave(t) + 0.02 * generator.standard_normal(600)
    late = 0.7 * wave(t - 0.73) + 0.02 * generator.standard_normal(600)
    shifts = np.arange(-50, 51)
    coefficients = np.array([np.corrcoef(*overlap(late, reference, k))[0, 1] for k in shifts])
    peak = int(coefficients.argmax())
    a, b, _ = np.polyfit(shifts[peak - 1 : peak + 2], coefficients[peak - 1 : peak + 2], 2)
    return {"rate_hz": 10.0, "measured": late, "reference": reference, "lag_s": float(-b / (2.0 * a) / 10.0)}


def overlap(late: np.ndarray, reference: np.ndarray, shift: int) -> tuple[np.ndarray, np.ndarray]:
    if shift >= 0:
        return late[shift:], reference[: len(reference) - shift]
    return late[:shift], reference[-shift:]


ORIGIN = np.radians([60.1, 24.9])
ARM = 1.2 - 0.3j
EPOCH_MS = 1_600_000_000_000


def write_logs(folder: Path, run: str, seconds: int) -> None:
    """Position (5 Hz, its clock 0.25 s fast), compass and gyro (10 Hz, the gyro 0.2 s late), thruster (4 Hz)."""
    t = 0.2 * np.arange(5 * seconds + 1)
    x, y = track(t)
    antenna = x + 1j * y + ARM * np.exp(1j * heading(t))
    north, east = radii(*ORIGIN)
    latitude = np.degrees(ORIGIN[0] + antenna.real / north)
    longitude = np.degrees(ORIGIN[1] + antenna.imag / east)
    rows = ["time_ms;lat;lon"]
    rows += [f"{EPOCH_MS + 250 + round(1000 * k)};{a:.10f};{b:.10f}" for k, a, b in zip(t, latitude, longitude)]
    (folder / f"{run}_gnss.csv.gz").write_bytes(gzip.compress(("\n".join(rows) + "\n").encode(), mtime=0))
    t = 0.1 * np.arange(10 * seconds + 1)
    compass = np.degrees(heading(t)) % 360.0
    gyro = np.degrees(motion(t - 0.2)[2])
    stamp = np.datetime64(EPOCH_MS, "ms") + np.round(1000 * t).astype("timedelta64[ms]")
    rows = ["stamp,heading,rate"] + [f"{s}Z,{a:.5f},{b:.6f}" for s, a, b in zip(stamp, compass, gyro)]
    (folder / f"{run}_imu.csv").write_text("\n".join(rows) + "\n")
    t = 0.25 * np.arange(4 * seconds + 1)
    table = pa.table({
        "t_ns": pa.array(EPOCH_MS * 1_000_000 + np.round(1e9 * t).astype(np.int64)),
        "rpm": pa.array((600.0 + 60.0 * np.sin(0.3 * t)).astype(np.float32)),
        "angle_deg": pa.array(20.0 * np.sin(0.2 * t)),
        "mode": pa.array(["turn" if k < 20 else "straight" for k in t]),
    })  # fmt: skip
    pq.write_table(table, folder / f"{run}_thruster.parquet", compression="zstd")


if __name__ == "__main__":
    main()
