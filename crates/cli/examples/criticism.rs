//! What criticism and standard errors are worth: the paper's experiment under several kinds of disturbance, simulated again and
//! again.
//!
//! `cargo run --release --example criticism -- <what> <trials> <seed> [<disturbance>…]` with
//! `stated`: how often a right model and one that lacks two terms are rejected, the noise stated; `found`: the same where it has
//! to be found; `added`: which terms are added to a model that lacks two, and to one that lacks none; `errors`: how often the
//! 95 % intervals of estimates from eight runs hold the truth.

use std::collections::BTreeMap;
use std::error::Error;

use estimation::criticism::{Criticism, Subject, criticise, criticise_each};
use estimation::pooled::{Judgement, Pool, StandardErrors, standard_errors};
use numerics::statistics::student_half_width;
use numerics::statistics::{Z, clustered_share, wilson};
use rayon::prelude::*;
use regression::pooled::PooledRuns;
use seatrial::{CampaignFile, DictionaryFile, Estimator, Study, Vessel};
use ship::engine::{Run, RunView};
use trial::campaign::SimulatedRun;

/// What the paper's ship then has and the model lacks.
const MORE: &str = r#"
[[sway]]
parameter = "Y_vv"
term = "v |v|"
value = -0.4
nominal = 0.0

[[yaw]]
parameter = "N_rr"
term = "r |r|"
value = -0.3
nominal = 0.0
"#;

const PAPER: &str = include_str!("../../../crates/ship/presets/ljungberg-model-ship.toml");
/// Runs that are pooled.
const TOGETHER: usize = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let at = |i: usize| arguments.get(i).map(String::as_str);
    let what = at(0).unwrap_or("stated");
    let (trials, seed): (u32, u64) = (at(1).unwrap_or("40").parse()?, at(2).unwrap_or("1").parse()?);
    let dictionary: DictionaryFile = include_str!("../../../pipelines/scenarios/dictionary.toml").parse()?;
    let vessel = |more: &str| -> Result<Vessel, Box<dyn Error>> {
        Ok(Vessel::from_file(format!("{PAPER}{more}").parse()?)?)
    };
    println!("{what}: {trials} trials of each, seed {seed}");
    for (name, campaign) in scenarios(trials, seed)? {
        if arguments.len() > 3 && !arguments[3..].contains(&name.to_owned()) {
            continue;
        }
        let exact = Study::new(vessel("")?, &dictionary, campaign.clone())?;
        let richer = Study::new(vessel(MORE)?, &dictionary, campaign.clone())?;
        let designed = exact.design(&exact.moments(&exact.dictionary()?)?)?.designed();
        let runs = |truth: &Study| -> Result<Vec<SimulatedRun>, Box<dyn Error>> {
            let all = truth.simulate(&designed)?;
            Ok(all.into_iter().filter(|run| run.run.design == "optimized").collect())
        };
        let (right, lacking) = (runs(&exact)?, runs(&richer)?);
        let told = match what {
            "errors" => errors(&exact, &right),
            _ => rejections(&exact, &campaign, &right, &lacking, what == "stated")?,
        };
        told.iter().for_each(|line| println!("{name:<6} {line}"));
    }
    Ok(())
}

/// Disturbances as in `pipelines/scenarios`, and nearly none.
fn scenarios(trials: u32, seed: u64) -> Result<Vec<(&'static str, CampaignFile)>, Box<dyn Error>> {
    let paper = include_str!("../../../pipelines/paper/campaign.toml");
    let all = [
        ("white", paper.to_owned()),
        ("quiet", with_noise(paper, "0.02")),
        ("gm", include_str!("../../../pipelines/scenarios/current-gauss-markov/campaign.toml").to_owned()),
        ("const", include_str!("../../../pipelines/scenarios/current-constant/campaign.toml").to_owned()),
        ("wind", include_str!("../../../pipelines/scenarios/wind-bias/campaign.toml").to_owned()),
    ];
    let read = |(name, text): (&'static str, String)| -> Result<_, Box<dyn Error>> {
        let campaign: CampaignFile = toml::from_str(&text)?;
        Ok((name, CampaignFile { realizations: trials, seed, random: None, ..campaign }))
    };
    all.into_iter().map(read).collect()
}

/// `campaign` with this noise of its sensors.
fn with_noise(campaign: &str, std: &str) -> String {
    let replaced = |line: &str| match line.split_once(" = ") {
        Some((key @ ("std_u_m_s" | "std_v_m_s" | "std_r_rad_s"), _)) => format!("{key} = {std}\n"),
        _ => format!("{line}\n"),
    };
    campaign.lines().map(replaced).collect()
}

/// How often the model is rejected that is right, and the one that lacks two terms, by single runs and by several together.
fn rejections(
    study: &Study,
    campaign: &CampaignFile,
    right: &[SimulatedRun],
    lacking: &[SimulatedRun],
    stated: bool,
) -> Result<Vec<String>, Box<dyn Error>> {
    let vessel = study.vessel();
    let (model, rate_hz) = (vessel.model.with_intercepts(), vessel.sample_rate_hz);
    let levels = stated.then(|| campaign.levels(rate_hz));
    let known =
        Subject { model: &model, runs: &[], rate_hz, known_start: true, levels, names: &[], signs: &[] };
    let single = |runs: &[SimulatedRun]| -> Result<Vec<Criticism>, Box<dyn Error>> {
        let estimates = study.estimate(runs, Estimator::Iv)?;
        let thetas = estimates.iter().map(|e| e.estimate.as_ref().map(|(theta, _)| theta));
        let pairs: Vec<_> = runs.iter().zip(thetas).filter_map(|(run, theta)| Some((run, theta?))).collect();
        let some = |some: &[(&SimulatedRun, &Vec<f64>)]| {
            let views: Vec<RunView> = some.iter().map(|(run, _)| run.run.view()).collect();
            let woven = some.iter().map(|(_, theta)| model.layout().woven(theta, [0.0; 3]));
            criticise_each(&Subject { runs: &views, ..known }, &woven.collect::<Vec<_>>())
        };
        Ok(pairs.par_chunks(TOGETHER).flat_map_iter(some).flatten().collect())
    };
    let together = |some: &[SimulatedRun]| {
        let runs = pooled(some);
        let found = Pool::new(vessel).estimate(&runs.cut(None), Estimator::Iv).ok()?;
        let views: Vec<RunView> = some.iter().map(|run| run.run.view()).collect();
        criticise(&Subject { runs: &views, ..known }, &found.parameters(&model)?)
    };
    let pooled: Vec<Criticism> = lacking.par_chunks_exact(TOGETHER).filter_map(together).collect();
    let (right, lacking) = (single(right)?, single(lacking)?);
    let all = |found: &[Criticism], holds: fn(&Criticism) -> bool| {
        share(found.iter().filter(|c| holds(c)).count(), found.len())
    };
    Ok(vec![
        format!("right: rejected {}", all(&right, |c| c.rejected)),
        format!(
            "two missing: rejected {}, named first {}",
            all(&lacking, |c| c.rejected),
            all(&lacking, named)
        ),
        format!("8 pooled: rejected {}, named first {}", all(&pooled, |c| c.rejected), all(&pooled, named)),
    ])
}

fn named(found: &Criticism) -> bool {
    let first = found.absent.first();
    first.is_some_and(|a| {
        matches!((a.name.as_str(), a.degree.as_deref()), ("v |v|", Some("sway")) | ("r |r|", Some("yaw")))
    })
}

/// How often the 95 % intervals of estimates from several runs hold the truth, over all parameters.
fn errors(study: &Study, runs: &[SimulatedRun]) -> Vec<String> {
    let judgement = Judgement { replicates: 0, seed: 1 };
    let truth: Vec<f64> = study.vessel().value.iter().copied().flatten().collect();
    let of = |estimator: Estimator| {
        let held = |some: &[SimulatedRun]| {
            let runs = pooled(some);
            // By Student's t where parts are compared.
            let half_width = match estimator.searches() {
                true => student_half_width(runs.parts(None).len() as f64 - 1.0),
                false => Z,
            };
            let found = standard_errors(&Pool::new(study.vessel()), &runs, estimator, &judgement).ok()?;
            let held = |StandardErrors { theta, standard_errors }: StandardErrors| {
                let all = theta.into_iter().zip(standard_errors).zip(&truth);
                all.map(|((value, error), truth)| (value - truth).abs() <= half_width * error)
                    .collect::<Vec<bool>>()
            };
            found.map(held)
        };
        let sets: Vec<Vec<bool>> = runs.par_chunks_exact(TOGETHER).filter_map(held).collect();
        let by_parameter = |i: usize| sets.iter().filter(|held| held[i]).count();
        let names = study.vessel().model.parameter_names().enumerate();
        let least = names.map(|(i, name)| (by_parameter(i), name)).min().unwrap_or((0, ""));
        // The parameters of an estimate err together.
        let of_set =
            |held: &Vec<bool>| held.iter().filter(|held| **held).count() as f64 / held.len().max(1) as f64;
        let shares: Vec<f64> = sets.iter().map(of_set).collect();
        let [low, high] = clustered_share(&shares).unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
        format!(
            "{estimator}: held {:.1} % ({low:.1} to {high:.1}) of {}, least {} {}",
            100.0 * shares.iter().sum::<f64>() / shares.len().max(1) as f64,
            shares.len(),
            least.1,
            share(least.0, sets.len())
        )
    };
    [Estimator::Iv, Estimator::OutputError, Estimator::Auto].map(of).to_vec()
}

fn pooled(runs: &[SimulatedRun]) -> PooledRuns {
    let runs: Vec<Run> = runs.iter().map(|simulated| simulated.run.clone()).collect();
    PooledRuns::new(runs, &BTreeMap::new())
}

/// With its 95 % interval (Wilson's).
fn share(count: usize, total: usize) -> String {
    let [low, high] = wilson(count as u64, total as u64).unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
    let found = 100.0 * count as f64 / total.max(1) as f64;
    format!("{found:.1} % ({low:.1} to {high:.1}) of {total}")
}
