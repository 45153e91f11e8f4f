"""Independent computation of the paper's simulation study, for the workspace's `oracle_*` tests.

    python scripts/oracle.py --study pipelines/paper --fixtures fixtures/oracle [--realizations 20]

Writes oracle.json (maneuvers, moments, designs, estimates, a free simulation, the scalar example) and runs.parquet
(the noisy data of the estimates). Needs numpy, scipy and pyarrow. Written from the paper: it shares no code with the
workspace and computes things another way where there is one. The same bytes come out again on the same machine.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from pathlib import Path
from typing import Any

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402  (one thread is asked for first)

from independent.checks import Estimates, worst_difference  # noqa: E402
from independent.design import Design, optimal  # noqa: E402
from independent.estimate import Estimate, estimate  # noqa: E402
from independent.free_run import INITIAL, multi_sine, rmse  # noqa: E402
from independent.moments import Moments, maneuver_moments  # noqa: E402
from independent.motion import realize, simulate  # noqa: E402
from independent.removal import REMOVALS  # noqa: E402
from independent.runs import Run, draw_runs  # noqa: E402
from independent.scalar import scalar_example  # noqa: E402
from independent.study import DEGREES, Study, read_study  # noqa: E402
from independent.text import pretty  # noqa: E402
from independent.trajectories import write_runs  # noqa: E402

SAMPLED = (1, 10, 100, 299)


def main() -> None:
    arguments = parse_arguments()
    study = read_study(arguments.study)
    moments = [maneuver_moments(study, index) for index in range(len(study.maneuvers))]
    designs = {removal: optimal(moments, removal) for removal in REMOVALS}
    runs = draw_runs(study, arguments.realizations)
    estimates = [all_estimates(study, run) for run in runs]
    report_checks(study, designs, runs, estimates)
    document = {
        "conventions": CONVENTIONS,
        "parameters": dict(zip((n for names in study.vessel.names for n in names), study.vessel.truth)),
        "maneuvers": [maneuver_entry(study, index) for index in range(len(study.maneuvers))],
        "moments": [moments_entry(study, index, m) for index, m in enumerate(moments)],
        "designs": {removal: design_entry(study, design) for removal, design in designs.items()},
        "runs": [run_entry(study, number, run, e) for number, (run, e) in enumerate(zip(runs, estimates))],
        "validation": validation_entry(study, estimates),
        "scalar_example": scalar_example(),
    }
    arguments.fixtures.mkdir(parents=True, exist_ok=True)
    (arguments.fixtures / "oracle.json").write_text(pretty(document) + "\n")
    write_runs(arguments.fixtures / "runs.parquet", study, runs)


CONVENTIONS = {
    "units": "SI: m/s, rad/s, N, N m",
    "maneuvers": "states[k] and nominal_states[k] after k steps (k = 0 is `initial`), inputs at sample k",
    "moments": "X = mean φζᵀ, Y = mean φ, Z = mean ζ; M = [[X, Y], [Zᵀ, 1]], row-major, row: regressor, column: instrument",
    "designs": "shares in the order of the maneuvers; log_det = Σ_d log|det| of the information matrix at shares that "
    "sum to 1; gap = max sensitivity − dimension",
    "runs": "of runs.parquet; theta in the order of `parameters`; per degree of freedom: condition (scaled to unit root "
    "mean square, means removed), gamma0, gamma1 of the likeliest moving average of order 1 of the residual",
    "validation": "RMSE of u, v, r over samples 1 to N, simulated from `initial` in still water",
}


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True, help="folder with vessel, dictionary and campaign")
    parser.add_argument("--fixtures", type=Path, required=True, help="folder to write to")
    parser.add_argument("--realizations", type=int, default=20, help="number of noisy runs")
    return parser.parse_args()


def all_estimates(study: Study, run: Run) -> Estimates:
    return {
        estimator: {removal: estimate(study.vessel, run, estimator, removal) for removal in REMOVALS}
        for estimator in ("iv", "ls")
    }


def maneuver_entry(study: Study, index: int) -> dict[str, Any]:
    vessel = study.vessel
    initial, inputs = realize(study, index, study.samples)
    states = simulate(vessel, vessel.value, initial, inputs)
    nominal = simulate(vessel, vessel.nominal, initial, inputs)
    return {
        "name": study.maneuvers[index]["name"],
        "samples": study.samples,
        "initial": list(initial),
        "k": list(SAMPLED),
        "inputs": [inputs[k].tolist() for k in SAMPLED],
        "states": [states[k].tolist() for k in SAMPLED],
        "nominal_states": [nominal[k].tolist() for k in SAMPLED],
    }


def moments_entry(study: Study, index: int, moments: list[Moments]) -> dict[str, Any]:
    def degree(name: str, m: Moments) -> dict[str, Any]:
        lifted = m.lifted()
        return {"name": name, "shape": list(lifted.shape), "M": lifted.reshape(-1).tolist()}

    degrees = [degree(name, m) for name, m in zip(DEGREES, moments)]
    return {"name": study.maneuvers[index]["name"], "samples": study.samples, "degrees": degrees}


def design_entry(study: Study, design: Design) -> dict[str, Any]:
    names = [str(maneuver["name"]) for maneuver in study.maneuvers]
    return {
        "shares": dict(zip(names, design.shares.tolist())),
        "sensitivities": dict(zip(names, design.sensitivities.tolist())),
        "dimension": design.dimension,
        "gap": design.gap,
        "log_det": design.log_det,
        "log_det_equal_shares": design.log_det_equal,
        "starts": design.starts,
        "agreeing_starts": design.agreeing,
    }


def run_entry(study: Study, number: int, run: Run, estimates: Estimates) -> dict[str, Any]:
    return {
        "run": number,
        "maneuvers": [study.maneuvers[index]["name"] for index in run.maneuvers],
        "estimates": {
            estimator: {removal: estimate_entry(study, e) for removal, e in by_removal.items()}
            for estimator, by_removal in estimates.items()
        },
    }


def estimate_entry(study: Study, e: Estimate) -> dict[str, Any]:
    truth = study.vessel.truth
    return {
        "theta": e.theta.tolist(),
        "parameter_error": math.sqrt(math.fsum(((x - t) / t) ** 2 for x, t in zip(e.theta.tolist(), truth))),
        "condition": e.condition,
        "gamma0": e.gamma0,
        "gamma1": e.gamma1,
        "standard_error": np.sqrt(e.variance).tolist(),
    }


def validation_entry(study: Study, estimates: list[Estimates]) -> dict[str, Any]:
    """The two instrumental-variable estimates with the smallest parameter error."""
    truth = np.array(study.vessel.truth)
    thetas = [e["iv"]["complete"].theta for e in estimates]
    best = sorted(range(len(thetas)), key=lambda i: float(np.linalg.norm((thetas[i] - truth) / truth)))[:2]
    inputs = multi_sine()
    scores = []
    for number in best:
        errors = rmse(study.vessel, thetas[number], inputs)
        norm = math.sqrt(math.fsum(e * e for e in errors))
        scores.append({"run": number, "theta": thetas[number].tolist(), "rmse": errors, "simulation_error": norm})
    return {"initial": list(INITIAL), "scores": scores, "inputs": inputs.tolist()}


def report_checks(study: Study, designs: dict[str, Design], runs: list[Run], estimates: list[Estimates]) -> None:
    """Refuses to write numbers that contradict themselves; says on stderr how well they agree."""
    for removal, design in designs.items():
        print(f"design, {removal}: gap {design.gap:.1e}, {design.agreeing}/{design.starts} starts", file=sys.stderr)
        if abs(design.gap) >= 1e-10:
            raise SystemExit(f"{removal}: the design's gap is {design.gap}, expected below 1e-10")
    worst = max(worst_difference(study.vessel, run, e) for run, e in zip(runs, estimates))
    print(f"estimates, two ways: {worst:.1e} relative", file=sys.stderr)
    if worst >= 1e-8:
        raise SystemExit(f"estimates differ by {worst} between two ways of computing them, expected below 1e-8")


if __name__ == "__main__":
    main()
