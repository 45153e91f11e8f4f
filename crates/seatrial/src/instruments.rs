//! Instruments for batches of runs.

use std::path::Path;

use identification::{Batch, Excitation, Outcome};
pub use identification::{InstrumentKind, MeanRemoval, MeanRemoval as Removal};
use vessel::{Diverged, LANES, Lane, Vessel, check_diverged, simulate, simulate_one};

use crate::failure::Failure;
use vessel::Run;
use vessel::lanes::{SideBySide, by_lane, groups, interleave};

/// Makes batches of runs with their instruments.
pub struct Instruments<'a> {
    vessel: &'a Vessel,
    vessel_file: &'a Path,
    kind: InstrumentKind,
    nominal: Vec<Lane>,
}

/// Up to [`LANES`] runs side by side, with their instruments.
pub struct Prepared {
    runs: SideBySide,
    instrument_states: Vec<Lane>,
    starts: Vec<Vec<usize>>,
}

impl<'a> Instruments<'a> {
    /// Instruments of `kind` for `vessel`, which was read from `vessel_file`.
    pub fn new(vessel: &'a Vessel, vessel_file: &'a Path, kind: InstrumentKind) -> Self {
        let nominal = vessel.nominal.iter().copied().map(Lane::splat).collect();
        Self { vessel, vessel_file, kind, nominal }
    }

    /// Calls `work` on batches of neighbouring runs of equal length: (batch, runs of the batch).
    ///
    /// # Errors
    /// A nominal simulation that diverges, and whatever `work` refuses.
    pub fn batches(
        &self,
        runs: &[Run],
        mut work: impl FnMut(&Batch, &[Run]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
        for group in groups(&lengths) {
            let members = &runs[group];
            let prepared = self.prepare(members)?;
            work(&prepared.batch(self.vessel), members)?;
        }
        Ok(())
    }

    /// Calls `work` on every run with its estimate and how each degree of freedom was excited. Neighbours that share inputs,
    /// segments and initial state share their instruments.
    ///
    /// # Errors
    /// A nominal simulation that diverges, and whatever `work` refuses.
    pub fn estimates(
        &self,
        runs: &[Run],
        removal: MeanRemoval,
        mut work: impl FnMut(&Run, Outcome, [Excitation; 3]) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
        let mut shared: Option<Shared> = None;
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
                let batch = prepared.batch(self.vessel);
                identification::Instruments::new(&batch, removal).estimate_with_excitation(&batch)
            };
            for (run, (outcome, excitation)) in members.iter().zip(outcomes) {
                work(run, outcome, excitation)?;
            }
        }
        Ok(())
    }

    /// The instruments of `run` and of all that are alike.
    fn share<'r>(&self, run: &'r Run, removal: MeanRemoval) -> Result<Shared<'r>, Failure> {
        let states = simulate_one(&self.vessel.model, &self.vessel.nominal, run.initial, &run.exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(self.diverged(run, at));
        }
        let starts = run.starts();
        let unmeasured = vec![Lane::ZERO; states.len()];
        let batch = shared_batch(self.vessel, run, &states, &starts, &unmeasured);
        let sums = identification::Instruments::new(&batch, removal);
        Ok(Shared { run, states, starts, sums })
    }

    fn diverged(&self, run: &Run, at: Diverged) -> Failure {
        let what = format!("nominal model (`nominal`) over design {}, run {}", run.design, run.run);
        Failure::invalid(self.vessel_file, &at.invalid(what))
    }

    fn prepare(&self, runs: &[Run]) -> Result<Prepared, Failure> {
        let own = SideBySide::of(&runs.iter().map(Run::view).collect::<Vec<_>>());
        let instrument_states = match self.kind {
            InstrumentKind::Regressors => own.measured.clone(),
            InstrumentKind::Nominal => self.nominal_states(runs, &own)?,
        };
        Ok(Prepared { runs: own, instrument_states, starts: runs.iter().map(Run::starts).collect() })
    }

    fn nominal_states(&self, runs: &[Run], own: &SideBySide) -> Result<Vec<Lane>, Failure> {
        let mut states = vec![Lane::ZERO; own.measured.len()];
        simulate(&self.vessel.model, &self.nominal, own.initial, &own.exogenous, &[], &mut states);
        for (lane, run) in runs.iter().enumerate() {
            if let Some(at) = check_diverged(states.iter().map(|s| s[lane])) {
                return Err(self.diverged(run, at));
            }
        }
        Ok(states)
    }
}

impl Prepared {
    fn batch<'b>(&'b self, vessel: &'b Vessel) -> Batch<'b> {
        Batch {
            model: &vessel.model,
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
    sums: identification::Instruments,
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
