//! The true vessel at sea: disturbed runs, [`LANES`] side by side.

use std::path::Path;

use vessel::{
    Disturbances, LANES, Lane, Source, Streams, Vessel, Weather, Wind, check_diverged, simulate, simulate_in,
};

use super::diverged;
use crate::failure::Failure;
use study::campaign_file::CampaignFile;
use vessel::lanes::{by_lane, interleave, lane};

/// What moves a vessel and what disturbs it.
pub(crate) struct Sea<'a> {
    vessel: &'a Vessel,
    vessel_file: &'a Path,
    truth: Vec<Lane>,
    disturbances: Disturbances,
    wind: Option<Wind>,
}

/// Runs of one design to be sailed side by side.
pub(crate) struct Departures<'a> {
    /// Name of the design.
    pub design: &'a str,
    /// What the disturbances are drawn from.
    pub streams: &'a Streams,
    /// Numbers of the runs, up to [`LANES`].
    pub runs: &'a [u32],
    /// Initial state of each: u, v \[m/s\], r \[rad/s\].
    pub initial: Vec<[f64; 3]>,
    /// Of each, N × exogenous; N is the same for all.
    pub exogenous: Vec<&'a [f64]>,
}

/// States of the runs, (N+1) × 3: true and measured.
pub(crate) struct Sailed {
    pub states: Vec<Lane>,
    pub measured: Vec<Lane>,
}

impl<'a> Sea<'a> {
    /// The disturbances of `config` and the true parameters of `vessel`.
    ///
    /// # Errors
    /// A vessel without true parameters.
    pub fn new(vessel_file: &'a Path, vessel: &'a Vessel, config: &CampaignFile) -> Result<Self, Failure> {
        let truth = vessel.parameters(Source::Value).map_err(|e| Failure::invalid(vessel_file, &e))?;
        let truth = truth.into_iter().map(Lane::splat).collect();
        Ok(Self { vessel, vessel_file, truth, disturbances: config.disturbances(), wind: config.wind })
    }

    /// The vessel.
    pub fn vessel(&self) -> &'a Vessel {
        self.vessel
    }

    /// Sails runs. What disturbs a run's first samples does not depend on how long it is.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn sail(&self, departures: &Departures) -> Result<Sailed, Failure> {
        let Departures { design, streams, runs, initial, exogenous } = departures;
        let (model, rate_hz) = (&self.vessel.model, self.vessel.sample_rate_hz);
        let samples = exogenous.first().map_or(0, |e| e.len() / model.exogenous().max(1));
        let numbers: [u32; LANES] = by_lane(runs.len(), |run| runs[run]);
        let start = [0, 1, 2].map(|d: usize| lane(runs.len(), |run| initial[run][d]));
        let lanes = interleave(exogenous);
        let current = self.disturbances.current(streams, numbers, samples, rate_hz);
        let mut states = vec![Lane::ZERO; 3 * (samples + 1)];
        let turning = self.disturbances.current.in_earth_axes();
        if turning || self.wind.is_some() {
            let force = self.wind.as_ref().map(|w| w.force(streams, numbers, samples, rate_hz));
            let turning = if turning { 1.0 / rate_hz } else { 0.0 };
            let weather = Weather { current: &current, turning, force: &force.unwrap_or_default() };
            simulate_in(model, &self.truth, start, &lanes, &weather, &mut states);
        } else {
            simulate(model, &self.truth, start, &lanes, &current, &mut states);
        }
        for (lane, run) in runs.iter().enumerate() {
            if let Some(at) = check_diverged(states.iter().map(|s| s[lane])) {
                return Err(diverged(self.vessel_file, &format!("model in design {design}, run {run}"), at));
            }
        }
        let mut measured = states.clone();
        self.disturbances.measure(streams, numbers, &mut measured);
        Ok(Sailed { states, measured })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use artifact::Provenance;
    use study::files::{read_campaign, read_vessel};

    #[test]
    fn law_a_run_that_goes_on_keeps_its_past() {
        let paper = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/paper");
        let mut noted = Provenance::default();
        let vessel = read_vessel(&paper.join("vessel.toml"), &mut noted).unwrap();
        let config = read_campaign(&paper.join("campaign.toml"), &mut noted).unwrap();
        let file = paper.join("vessel.toml");
        let sea = Sea::new(&file, &vessel, &config).unwrap();
        let (streams, exogenous) = (Streams::new(1, "trial"), vec![100.0; 3 * 41]);
        let sail = |samples: usize| {
            let exogenous = vec![&exogenous[..3 * samples]; 2];
            let initial = vec![[1.0, 0.0, 0.0]; 2];
            sea.sail(&Departures { design: "d", streams: &streams, runs: &[3, 4], initial, exogenous })
                .unwrap()
        };
        let (short, long) = (sail(20), sail(41));
        assert_eq!(short.states[..], long.states[..3 * 21]);
        assert_eq!(short.measured[..], long.measured[..3 * 21]);
        assert!(short.measured[1][0] != short.measured[1][1], "runs differ");
    }
}
