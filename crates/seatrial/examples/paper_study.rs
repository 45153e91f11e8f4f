//! The paper's simulation study in memory: an optimized experiment against random ones, no file touched.

use std::error::Error;

use seatrial::{CampaignFile, DictionaryFile, Estimator, Study, Vessel};

fn main() -> Result<(), Box<dyn Error>> {
    let vessel = Vessel::preset("ljungberg-model-ship")?;
    let dictionary: DictionaryFile = include_str!("../../../pipelines/paper/dictionary.toml").parse()?;
    let campaign: CampaignFile = toml::from_str(include_str!("../../../pipelines/paper/campaign.toml"))?;
    let study = Study::new(vessel, &dictionary, campaign)?;

    let moments = study.moments(&study.dictionary()?)?;
    let optimum = study.design(&moments)?;
    let runs = study.simulate(&optimum.designed())?;
    let estimates = study.estimate(&runs, Estimator::Iv)?;
    let scores = study.score(&estimates)?;

    let (settings, bounds) = (study.settings(), &study.settings().validation);
    println!("{} realizations of each design, seed {}", settings.realizations, settings.seed);
    for found in study.worth(&scores) {
        let [bound, of_parameters] = [bounds.parameter_error_bound, found.parameter_error_share];
        tell(&found.design, "parameter", bound, of_parameters, found.parameter_error_share_interval);
        let [bound, of_simulation] = [bounds.simulation_error_bound, found.simulation_error_share];
        tell(&found.design, "simulation", bound, of_simulation, found.simulation_error_share_interval);
    }
    Ok(())
}

/// Prints a share with its 95 % interval.
fn tell(design: &str, error: &str, bound: f64, share: f64, interval: Option<[f64; 2]>) {
    let [low, high] = interval.unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
    println!("{design}: {error} error below {bound} in {:.1} % ({low:.1} to {high:.1} %)", 100.0 * share);
}
