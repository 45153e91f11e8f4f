//! How often score tests reject a model that is right, and one that lacks two terms: the paper's experiment under several
//! kinds of disturbance. `cargo run --release --example criticism -- 300` simulates 300 trials of each.

use std::error::Error;

use identification::criticism::{Criticism, Subject, criticise};
use rayon::prelude::*;
use seatrial::{CampaignFile, DictionaryFile, Estimator, Study, Vessel};
use trial::campaign::SimulatedRun;
use vessel::RunView;

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

const PAPER: &str = include_str!("../../../crates/vessel/presets/ljungberg-model-ship.toml");

fn main() -> Result<(), Box<dyn Error>> {
    let trials: u32 = std::env::args().nth(1).map_or(Ok(40), |count| count.parse())?;
    let stated = std::env::args().nth(2).is_none_or(|word| word != "found");
    let dictionary: DictionaryFile =
        toml::from_str(include_str!("../../../pipelines/paper/dictionary.toml"))?;
    let read = |text: &str| toml::from_str::<vessel::VesselFile>(text);
    println!("{trials} trials each; noise {}", if stated { "stated" } else { "found by its likelihood" });
    println!(
        "disturbance      exact: rejected   two missing: rejected   one of them first   8 pooled: rejected   first"
    );
    for (name, campaign) in scenarios(trials)? {
        let exact = study(Vessel::from_file(read(PAPER)?)?, &dictionary, &campaign)?;
        let richer = study(Vessel::from_file(read(&format!("{PAPER}{MORE}"))?)?, &dictionary, &campaign)?;
        let designed = exact.design(&exact.moments(&exact.dictionary()?)?)?.designed();
        let mut told = Vec::new();
        for truth in [&exact, &richer] {
            let runs: Vec<SimulatedRun> =
                truth.simulate(&designed)?.into_iter().filter(|run| run.run.design == "optimized").collect();
            let estimates = exact.estimate(&runs, Estimator::Iv)?;
            let thetas = estimates.iter().map(|e| e.estimate.as_ref().map(|(theta, _)| theta.clone()));
            let pairs: Vec<(SimulatedRun, Vec<f64>)> =
                runs.into_iter().zip(thetas).filter_map(|(run, theta)| Some((run, theta?))).collect();
            told.push(judged(&exact, &campaign, &pairs, 1, stated));
            told.push(judged(&exact, &campaign, &pairs, 8, stated));
        }
        let [once, _, richer, pooled] = told.as_slice() else { continue };
        println!(
            "{name:<16} {}   {}   {}   {}   {}",
            share(once, |c| c.rejected),
            share(richer, |c| c.rejected),
            share(richer, first_is_missing),
            share(pooled, |c| c.rejected),
            share(pooled, first_is_missing)
        );
    }
    Ok(())
}

fn study(
    vessel: Vessel,
    dictionary: &DictionaryFile,
    campaign: &CampaignFile,
) -> Result<Study, Box<dyn Error>> {
    Ok(Study::new(vessel, dictionary, campaign.clone())?)
}

/// Disturbances as in `pipelines/scenarios`, and nearly none.
fn scenarios(trials: u32) -> Result<Vec<(&'static str, CampaignFile)>, Box<dyn Error>> {
    let paper = include_str!("../../../pipelines/paper/campaign.toml");
    let all = [
        ("white", paper.to_owned()),
        ("quiet", with_noise(paper, "0.02")),
        ("gm", include_str!("../../../pipelines/scenarios/current-gauss-markov/campaign.toml").to_owned()),
        ("const", include_str!("../../../pipelines/scenarios/current-constant/campaign.toml").to_owned()),
        ("wind", include_str!("../../../pipelines/scenarios/wind-bias/campaign.toml").to_owned()),
    ];
    let read = |(name, text): (&'static str, String)| -> Result<_, Box<dyn Error>> {
        let mut campaign: CampaignFile = toml::from_str(&text)?;
        campaign.realizations = trials;
        Ok((name, campaign))
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

/// The criticism of every `together` runs, of which each has its estimate; the first one's is that of all.
fn judged(
    study: &Study,
    campaign: &CampaignFile,
    runs: &[(SimulatedRun, Vec<f64>)],
    together: usize,
    stated: bool,
) -> Vec<Criticism> {
    let vessel = study.vessel();
    let model = vessel.model.with_intercepts();
    let rate_hz = vessel.sample_rate_hz;
    let one = |some: &[(SimulatedRun, Vec<f64>)]| {
        let views: Vec<RunView> = some.iter().map(|(run, _)| run.run.view()).collect();
        let mean: Vec<f64> = (0..some[0].1.len())
            .map(|i| some.iter().map(|(_, theta)| theta[i]).sum::<f64>() / some.len() as f64)
            .collect();
        criticise(&Subject {
            model: &model,
            parameters: &model.layout().woven(&mean, [0.0; 3]),
            runs: &views,
            rate_hz,
            known_start: true,
            levels: stated.then(|| campaign.levels(rate_hz)),
        })
    };
    runs.par_chunks_exact(together).filter_map(one).collect()
}

fn first_is_missing(found: &Criticism) -> bool {
    let first = found.absent.first();
    first.is_some_and(|a| {
        (a.name == "v |v|" && a.degree.as_deref() == Some("sway"))
            || (a.name == "r |r|" && a.degree.as_deref() == Some("yaw"))
    })
}

fn share(found: &[Criticism], holds: impl Fn(&Criticism) -> bool) -> String {
    let count = found.iter().filter(|c| holds(c)).count();
    format!("{:>5.1} % of {}", 100.0 * count as f64 / found.len().max(1) as f64, found.len())
}
