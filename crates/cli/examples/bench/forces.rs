//! Fits of a ship with forces: what derivatives cost beside errors alone.

use std::path::Path;

use estimation::fitting::{Problem, RecordingView, Settings, SimulatedRun};
use serde_json::{Value, json};
use ship::forces::Forces;
use ship::model::{Vessel, VesselFile};
use study::trajectories::{Layout, TrajectoryReader};

use crate::timing::fastest;

const SHIP: &str = include_str!("../../../../pipelines/esso-osaka/vessel-forces.toml");
/// With these the ship has 39 free numbers.
const CUBICS: [(&str, &str); 2] = [
    (
        "sway = [",
        r#"
  { parameter = "Y_vvv", term = "v^3 / U", prime = 0.0, prior = 1.5 },
  { parameter = "Y_vvr", term = "v^2 r / U", prime = 0.0, prior = 1.0 },"#,
    ),
    (
        "yaw = [",
        r#"
  { parameter = "N_vvv", term = "v^3 / U", prime = 0.0, prior = 0.5 },
  { parameter = "N_vvr", term = "v^2 r / U", prime = 0.0, prior = 0.5 },"#,
    ),
];

/// Recordings that stand for those of the ship, and samples of each.
const RECORDINGS: usize = 23;
const SAMPLES: usize = 320;
const TURNS: usize = 20;

/// Inputs and disturbances of a recording, and what was measured.
type Rows = (Vec<f64>, Vec<f64>);

/// Seconds for errors alone, for errors with all derivatives, and for a fit, on one thread: of the trajectories in `file`,
/// which are of the Esso Osaka, else of simulated ones.
pub fn measure(file: Option<&Path>) -> anyhow::Result<Value> {
    let vessel = ship()?;
    let built = vessel.model.forces.as_ref().ok_or_else(|| anyhow::anyhow!("no forces"))?;
    let rows = match file {
        Some(path) => recorded(path, &vessel)?,
        None => (0..RECORDINGS).map(|i| simulated(&built.forces, &vessel, i)).collect(),
    };
    let recordings: Vec<RecordingView> =
        rows.iter().map(|(inputs, measured)| RecordingView { name: "", inputs, measured }).collect();
    let settings = Settings::new(1.0 / vessel.sample_rate_hz);
    let problem = Problem::new(&built.forces, recordings, vessel.model.exogenous(), settings)?;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    one.install(|| timed(&problem, &vessel.nominal))
}

fn timed(problem: &Problem, theta: &[f64]) -> anyhow::Result<Value> {
    let (errors_s, cost) = fastest(TURNS, || Ok(problem.cost(theta)))?;
    let (jacobian_s, rows) = fastest(TURNS, || Ok(problem.jacobian(theta)))?;
    let (sums_s, _) = fastest(TURNS, || Ok(problem.cost_and_slopes(theta)))?;
    let (fit_s, fit) = fastest(2, || Ok(problem.fit()?))?;
    Ok(json!({
        "parameters": theta.len(),
        "windows": problem.windows(),
        "entries": rows.iter().map(Vec::len).sum::<usize>(),
        "cost": cost,
        "errors_s": errors_s,
        "jacobian_s": jacobian_s,
        "jacobian_in_errors": jacobian_s / errors_s,
        "sums_in_errors": (sums_s - errors_s) / errors_s,
        "fit_s": fit_s,
        "fit_steps": fit.steps,
    }))
}

/// The Esso Osaka with 39 free numbers.
fn ship() -> anyhow::Result<Vessel> {
    let mut text = SHIP.to_owned();
    for (equation, terms) in CUBICS {
        text = text.replacen(equation, &format!("{equation}{terms}"), 1);
    }
    let vessel = Vessel::from_file(toml::from_str::<VesselFile>(&text)?)?;
    anyhow::ensure!(vessel.nominal.len() == 39, "{} free numbers", vessel.nominal.len());
    Ok(vessel)
}

/// Runs that stand in `path`.
fn recorded(path: &Path, vessel: &Vessel) -> anyhow::Result<Vec<Rows>> {
    let reader = TrajectoryReader::open(path, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    let rows = |run: ship::engine::Run| (run.exogenous, run.measured);
    Ok(reader.all()?.into_iter().map(rows).collect())
}

/// Recording `i`: rudder from side to side, revolutions in steps, ahead and astern, with errors of a hundredth.
fn simulated(forces: &Forces, vessel: &Vessel, i: usize) -> Rows {
    let wave = |k: usize, period: usize| if (k / period).is_multiple_of(2) { 1.0 } else { -1.0 };
    let row = |k: usize| {
        let n = if k % 240 > 200 { -8.0 } else { 8.0 + 4.0 * wave(k, 70 + i) };
        [n, 0.35 * wave(k, 15 + i), 0.4, 0.2 * wave(k, 90), 0.1]
    };
    let inputs: Vec<f64> = (0..SAMPLES).flat_map(row).collect();
    let width = vessel.model.exogenous();
    let run = SimulatedRun { initial: [0.4, 0.0, 0.0], inputs: &inputs, width, sample_s: 1.0 };
    let states = run.states(forces, &vessel.nominal);
    let error = |k: usize, d: usize| 0.004 * (1.7 * k as f64 + d as f64 + i as f64).sin();
    let measured = states.iter().enumerate().flat_map(|(k, own)| [0, 1, 2].map(|d| own[d] + error(k, d)));
    let measured = measured.collect();
    (inputs, measured)
}
