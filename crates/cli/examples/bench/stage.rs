//! The loop of the stage `monte-carlo`: runs of a campaign that are simulated, estimated, scored and counted in memory.

use std::collections::BTreeMap;

use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use estimation::{Estimator, ValidationRuns};
use maneuver::Generator;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use regression::MeanRemoval;
use seatrial::MonteCarlo;
use serde_json::{Value, json};
use ship::model::Source;
use study::campaign_file::CampaignFile;
use trial::campaign::{Campaign, Designed, Maneuvers};
use validation::tally::{Bounds, Tally};

use crate::paper::{OPTIMIZED, Paper};
use crate::timing::fastest;

/// So few that a busy machine leaves some repetitions undisturbed.
const RUNS: usize = 512;
const REPETITIONS: usize = 50;

/// Microseconds per run of the paper's study on one thread, of its optimized and of its random design, by instrumental
/// variables.
pub fn measure(paper: &Paper) -> anyhow::Result<Value> {
    let file: CampaignFile = toml::from_str(include_str!("../../../../pipelines/paper/campaign.toml"))?;
    let own = study(paper, &file)?;
    let bounds = Bounds {
        parameter_error: file.validation.parameter_error_bound,
        simulation_error: file.validation.simulation_error_bound,
    };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut found = BTreeMap::from([("rand_distr".to_owned(), json!({ "us_per_run": 1e6 * drawn(paper)? }))]);
    for (design, name) in own.campaign.names().into_iter().enumerate() {
        let (seconds, tally) = one.install(|| fastest(REPETITIONS, || counted(&own, design, bounds)))?;
        let counted = tally.counted.iter().find(|counted| counted.design == name);
        let below = counted.map_or(0, |counted| counted.parameter_errors_below);
        let share = below as f64 / RUNS as f64;
        found.insert(
            name.to_owned(),
            json!({"us_per_run": 1e6 * seconds / RUNS as f64, "parameter_error_share": share}),
        );
    }
    Ok(json!(found))
}

/// Seconds that rand_distr takes to draw as many normal numbers as disturb a run: two of the current and three of the measurement
/// at every sample, three at its end.
fn drawn(paper: &Paper) -> anyhow::Result<f64> {
    let samples: usize = OPTIMIZED.iter().map(|(_, samples)| samples).sum();
    let noise = paper.vessel.model.degrees.len() * (samples + 1) + 2 * samples;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut numbers = vec![0.0; noise];
    let (seconds, _) = fastest(REPETITIONS * RUNS / 10, || {
        for number in &mut numbers {
            *number = StandardNormal.sample(&mut rng);
        }
        Ok(std::hint::black_box(numbers[0]))
    })?;
    Ok(seconds)
}

fn counted(study: &MonteCarlo, design: usize, bounds: Bounds) -> anyhow::Result<Tally> {
    let mut tally = Tally::new(&study.campaign.names(), &study.estimators.estimators);
    tally.add(&study.scores(design, 0..RUNS)?, bounds);
    Ok(tally)
}

fn study<'a>(paper: &'a Paper, file: &CampaignFile) -> anyhow::Result<MonteCarlo<'a>> {
    let Paper { vessel, generator, .. } = paper;
    let order = OPTIMIZED.iter().map(|(q, samples)| (generator.maneuvers()[*q].name.clone(), *samples));
    let total: usize = OPTIMIZED.iter().map(|(_, samples)| samples).sum();
    let share = |(name, samples): (String, usize)| (name, samples as f64 / total as f64);
    let designed = Designed { shares: order.clone().map(share).collect(), order: Some(order.collect()) };
    let mut settings = file.settings(None);
    settings.realizations = RUNS as u32;
    let campaign = Campaign::new(file.sea(vessel)?, generator, &designed, &settings)?;
    let own = Generator::without_tables(vessel, &file.validation_dictionary())?;
    let maneuvers = Maneuvers::new(vessel, &own, Source::Value, "validation")?;
    let runs = maneuvers.simulate(0..maneuvers.count())?.0.into_iter().map(|simulated| simulated.run);
    let validation = ValidationRuns::new(vessel, runs.collect());
    Ok(MonteCarlo {
        campaign,
        estimators: RunEstimators {
            vessel,
            estimators: vec![Estimator::Iv],
            removal: MeanRemoval::Complete,
            initial: InitialState::Known,
            additional: AdditionalUnknowns::default(),
            levels: Some(file.levels(vessel.sample_rate_hz)),
        },
        validation: validation.ok_or_else(|| anyhow::anyhow!("no validation maneuver"))?,
        truth: vessel.value.iter().copied().collect(),
    })
}
