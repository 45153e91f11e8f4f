use vessel::lanes::{SideBySide, by_lane, groups, interleave};
use vessel::{Diverged, LANES, Lane, Run, Vessel, Weather, check_diverged, simulate, simulate_one};

use super::error::NominalDiverged;
use crate::{Batch, Excitation, InstrumentKind, Instruments, MeanRemoval, Outcome};

/// Makes batches of runs with their instruments.
pub struct RunInstruments<'a> {
    vessel: &'a Vessel,
    kind: InstrumentKind,
    nominal: Vec<Lane>,
}

/// Up to [`LANES`] runs side by side, with their instruments.
pub struct Prepared<'a> {
    vessel: &'a Vessel,
    runs: SideBySide,
    instrument_states: Vec<Lane>,
    starts: Vec<Vec<usize>>,
}

impl<'a> RunInstruments<'a> {
    /// Instruments of `kind` for `vessel`.
    pub fn new(vessel: &'a Vessel, kind: InstrumentKind) -> Self {
        let nominal = vessel.nominal.iter().copied().map(Lane::splat).collect();
        Self { vessel, kind, nominal }
    }

    /// Batches of neighbouring runs of equal length, each with the runs that it holds.
    pub fn batches<'r>(
        &self,
        runs: &'r [Run],
    ) -> impl Iterator<Item = Result<(Prepared<'a>, &'r [Run]), NominalDiverged>> {
        let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
        groups(&lengths).into_iter().map(|group| {
            let members = &runs[group];
            Ok((self.prepare(members)?, members))
        })
    }

    /// The estimate of every run and how each degree of freedom was excited. Neighbours that share inputs, segments and
    /// initial state share their instruments.
    ///
    /// # Errors
    /// A nominal simulation that diverges.
    pub fn estimates(
        &self,
        runs: &[Run],
        removal: MeanRemoval,
    ) -> Result<Vec<(Outcome, [Excitation; 3])>, NominalDiverged> {
        let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
        let mut shared: Option<Shared> = None;
        let mut all = Vec::with_capacity(runs.len());
        for group in groups(&lengths) {
            let members = &runs[group];
            let same =
                self.kind == InstrumentKind::Nominal && members.iter().all(|run| alike(run, &members[0]));
            let outcomes = if same {
                let known = shared.take().filter(|shared| alike(shared.run, &members[0]));
                let known = known.map_or_else(|| self.share(&members[0], removal), Ok)?;
                shared.insert(known).estimate(self.vessel, members)
            } else {
                let prepared = self.prepare(members)?;
                let batch = prepared.batch();
                Instruments::new(&batch, removal).estimate_with_excitation(&batch)
            };
            all.extend(outcomes.into_iter().take(members.len()));
        }
        Ok(all)
    }

    /// The instruments of `run` and of all that are alike.
    fn share<'r>(&self, run: &'r Run, removal: MeanRemoval) -> Result<Shared<'r>, NominalDiverged> {
        let states = simulate_one(&self.vessel.model, &self.vessel.nominal, run.initial, &run.exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(NominalDiverged::over(run, at));
        }
        let starts = run.starts();
        let unmeasured = vec![Lane::ZERO; states.len()];
        let batch = shared_batch(self.vessel, run, &states, &starts, &unmeasured);
        let sums = Instruments::new(&batch, removal);
        Ok(Shared { run, states, starts, sums })
    }

    fn prepare(&self, runs: &[Run]) -> Result<Prepared<'a>, NominalDiverged> {
        let mut prepared = Prepared::regressed(self.vessel, runs);
        if self.kind == InstrumentKind::Nominal {
            prepared.simulate(&self.nominal);
            for (lane, run) in runs.iter().enumerate() {
                if let Some(at) = prepared.diverged(lane) {
                    return Err(NominalDiverged::over(run, at));
                }
            }
        }
        Ok(prepared)
    }
}

impl<'a> Prepared<'a> {
    /// Up to [`LANES`] `runs` whose instruments are their regressors.
    pub(super) fn regressed(vessel: &'a Vessel, runs: &[Run]) -> Self {
        let own = SideBySide::of(&runs.iter().map(Run::view).collect::<Vec<_>>());
        let starts = runs.iter().map(Run::starts).collect();
        Self { vessel, instrument_states: own.measured.clone(), runs: own, starts }
    }

    /// Simulates every run with `parameters`, one lane each, and takes the states as instruments.
    pub(super) fn simulate(&mut self, parameters: &[Lane]) {
        let SideBySide { exogenous, initial, .. } = &self.runs;
        simulate(
            &self.vessel.model,
            parameters,
            *initial,
            exogenous,
            &Weather::CALM,
            &mut self.instrument_states,
        );
    }

    /// Where the simulation of one run diverged.
    pub(super) fn diverged(&self, lane: usize) -> Option<Diverged> {
        check_diverged(self.instrument_states.iter().map(|s| s[lane]))
    }

    /// The batch; lanes that are left repeat the last run.
    pub fn batch(&self) -> Batch<'_> {
        Batch {
            model: &self.vessel.model,
            measured: &self.runs.measured,
            instrument_states: &self.instrument_states,
            exogenous: &self.runs.exogenous,
            segments: by_lane(self.starts.len(), |run| self.starts[run].as_slice()),
        }
    }
}

/// Whether two runs have the same instruments.
fn alike(one: &Run, other: &Run) -> bool {
    one.initial == other.initial && one.segments == other.segments && one.exogenous == other.exogenous
}

/// Instruments of runs that are alike.
struct Shared<'r> {
    run: &'r Run,
    states: Vec<f64>,
    starts: Vec<usize>,
    sums: Instruments,
}

impl Shared<'_> {
    fn estimate(&self, vessel: &Vessel, runs: &[Run]) -> Vec<(Outcome, [Excitation; 3])> {
        let measured = interleave(&runs.iter().map(|r| r.measured.as_slice()).collect::<Vec<_>>());
        let batch = shared_batch(vessel, self.run, &self.states, &self.starts, &measured);
        self.sums.estimate_with_excitation(&batch)
    }
}

fn shared_batch<'b>(
    vessel: &'b Vessel,
    run: &'b Run,
    instrument_states: &'b [f64],
    starts: &'b [usize],
    measured: &'b [Lane],
) -> Batch<'b, f64> {
    let (model, exogenous) = (&vessel.model, run.exogenous.as_slice());
    Batch { model, measured, instrument_states, exogenous, segments: [starts; LANES] }
}
