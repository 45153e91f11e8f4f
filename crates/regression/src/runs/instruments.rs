use numerics::lanes::{buffer, by_lane, groups, interleave, recycle};
use numerics::{GROUPS, LANES, Lane, Wide};
use ship::engine::{
    Diverged, Run, SideBySide, Weather, check_diverged, diverged_lanes, simulate, simulate_groups,
};
use ship::model::Vessel;

use super::alike::{Doing, SharedInputs};
use super::nominal_diverged::NominalDiverged;
use crate::{Batch, Excitation, InstrumentKind, Instruments, MeanRemoval, Outcome};

/// Forms batches of runs with their instruments.
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
    /// Whether these are simulated; else they are the measured ones, and the recorded inputs belong to them.
    is_simulated: bool,
    starts: Vec<Vec<usize>>,
}

impl<'a> RunInstruments<'a> {
    /// Instruments of `kind` for `vessel`.
    pub fn new(vessel: &'a Vessel, kind: InstrumentKind) -> Self {
        let nominal = vessel.nominal.iter().copied().map(Lane::splat).collect();
        Self { vessel, kind, nominal }
    }

    /// Batches of neighbouring runs of equal length, each with its runs.
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

    /// The estimate of every run and the excitation of each degree of freedom. Neighbours that share inputs, segments
    /// and initial state share their instruments.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn estimates(
        &self,
        runs: &[Run],
        removal: MeanRemoval,
    ) -> Result<Vec<(Outcome, [Excitation; 3])>, NominalDiverged> {
        let lengths: Vec<usize> = runs.iter().map(Run::samples).collect();
        let mut shared: Option<(&Run, SharedInputs)> = None;
        let mut all = Vec::with_capacity(runs.len());
        for group in groups(&lengths) {
            let members = &runs[group];
            let same =
                self.kind == InstrumentKind::Nominal && members.iter().all(|run| alike(run, &members[0]));
            let outcomes = if same {
                let known = shared.take().filter(|(run, _)| alike(run, &members[0]));
                let share =
                    || Ok((&members[0], SharedInputs::new(self.vessel, &Doing::of(&members[0]), removal)?));
                let (_, instruments) = shared.insert(known.map_or_else(share, Ok)?);
                let measured = interleave(&members.iter().map(|r| r.measured.as_slice()).collect::<Vec<_>>());
                instruments.estimates_with_excitation(&measured)
            } else {
                let prepared = self.prepare(members)?;
                let batch = prepared.batch();
                Instruments::new(&batch, removal).estimate_with_excitation(&batch)
            };
            all.extend(outcomes.into_iter().take(members.len()));
        }
        Ok(all)
    }

    /// The parameters of runs that are already in lanes, group by group, with the starts of their segments. Instruments
    /// are simulated with the nominal model, regardless of `kind`.
    ///
    /// # Errors
    /// The run whose nominal simulation diverges, and where.
    pub fn nominal_side_by_side(
        &self,
        groups: impl IntoIterator<Item = (Vec<Vec<usize>>, SideBySide)>,
        removal: MeanRemoval,
    ) -> Result<Vec<Outcome<Vec<f64>>>, (usize, Diverged)> {
        let mut all: Vec<Prepared> =
            groups.into_iter().map(|(starts, runs)| Prepared::calm(self.vessel, runs, starts)).collect();
        match <&mut [Prepared; GROUPS]>::try_from(all.as_mut_slice()) {
            Ok(groups) if groups.iter().all(|own| own.as_long_as(&groups[0])) => {
                Prepared::simulate_groups(groups, &self.nominal);
            }
            _ => all.iter_mut().for_each(|own| own.simulate(&self.nominal)),
        }
        let mut outcomes = Vec::with_capacity(all.len() * LANES);
        for own in &all {
            let count = own.starts.len();
            let diverged = diverged_lanes(&own.instrument_states).into_iter().take(count).enumerate();
            if let Some((lane, at)) = diverged.into_iter().find_map(|(lane, at)| Some((lane, at?))) {
                return Err((outcomes.len() + lane, at));
            }
            let batch = own.batch();
            outcomes.extend(Instruments::new(&batch, removal).parameters(&batch).into_iter().take(count));
        }
        for Prepared { runs, instrument_states, .. } in all {
            recycle([runs.measured, runs.exogenous, runs.instrument_exogenous, instrument_states]);
        }
        Ok(outcomes)
    }

    fn prepare(&self, runs: &[Run]) -> Result<Prepared<'a>, NominalDiverged> {
        let mut prepared = Prepared::regressed(self.vessel, runs);
        if self.kind == InstrumentKind::Nominal {
            prepared.simulate(&self.nominal);
            for (lane, run) in runs.iter().enumerate() {
                if let Some(at) = prepared.diverged(lane) {
                    // A run of one maneuver is known by it.
                    let design = match run.segments.as_slice() {
                        [only] => format!("{}, maneuver `{}`", run.design, only.maneuver),
                        _ => run.design.clone(),
                    };
                    return Err(NominalDiverged::over(&design, run.run, at, self.vessel.sample_rate_hz));
                }
            }
        }
        Ok(prepared)
    }
}

impl<'a> Prepared<'a> {
    /// Up to [`numerics::LANES`] `runs` whose instruments are their regressors.
    pub fn regressed(vessel: &'a Vessel, runs: &[Run]) -> Self {
        let own = SideBySide::of(&runs.iter().map(Run::view).collect::<Vec<_>>());
        Self::of(vessel, own, runs.iter().map(Run::starts).collect())
    }

    /// Runs whose segments start at `starts`, and whose instruments are their regressors.
    fn of(vessel: &'a Vessel, runs: SideBySide, starts: Vec<Vec<usize>>) -> Self {
        Self { vessel, instrument_states: runs.measured.clone(), is_simulated: false, runs, starts }
    }

    /// Runs whose instruments are not simulated yet.
    fn calm(vessel: &'a Vessel, runs: SideBySide, starts: Vec<Vec<usize>>) -> Self {
        Self { vessel, instrument_states: buffer(runs.measured.len()), is_simulated: false, runs, starts }
    }

    fn as_long_as(&self, other: &Self) -> bool {
        self.runs.exogenous.len() == other.runs.exogenous.len()
    }

    /// [`Self::simulate`] for several batches of equal length.
    fn simulate_groups(groups: &mut [Self; GROUPS], parameters: &[Lane]) {
        let vessel = groups[0].vessel;
        let initial = [0, 1, 2].map(|d: usize| Wide(groups.each_ref().map(|own| own.runs.initial[d])));
        groups.iter_mut().for_each(|own| own.is_simulated = true);
        let runs = groups.each_mut();
        let runs = runs.map(|own| (own.runs.instrument_exogenous(), own.instrument_states.as_mut_slice()));
        simulate_groups(&vessel.model, parameters, initial, runs);
    }

    /// Simulates every run with `parameters`, one lane each, and takes the states as instruments.
    pub fn simulate(&mut self, parameters: &[Lane]) {
        let exogenous = self.runs.instrument_exogenous();
        let (model, initial) = (&self.vessel.model, self.runs.initial);
        self.is_simulated = true;
        simulate(model, parameters, initial, exogenous, &Weather::CALM, &mut self.instrument_states);
    }

    /// Where the simulation of one run diverged.
    pub fn diverged(&self, lane: usize) -> Option<Diverged> {
        check_diverged(self.instrument_states.iter().map(|s| s[lane]))
    }

    /// The batch; unused lanes repeat the last run.
    pub fn batch(&self) -> Batch<'_> {
        Batch {
            model: &self.vessel.model,
            measured: &self.runs.measured,
            instrument_states: &self.instrument_states,
            exogenous: &self.runs.exogenous,
            instrument_exogenous: match self.is_simulated {
                true => self.runs.instrument_exogenous(),
                false => &self.runs.exogenous,
            },
            segments: by_lane(self.starts.len(), |run| self.starts[run].as_slice()),
        }
    }
}

/// Whether two runs have the same instruments.
fn alike(one: &Run, other: &Run) -> bool {
    one.initial == other.initial
        && one.segments == other.segments
        && one.exogenous == other.exogenous
        && one.instrument_exogenous.is_empty()
        && other.instrument_exogenous.is_empty()
}
