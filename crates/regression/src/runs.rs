//! Instruments of single runs, shared by those with the same inputs.

use numerics::lanes::{buffer, by_lane, groups, interleave, recycle};
use numerics::{GROUPS, LANES, Lane, Wide};
use refusal::Invalid;
use ship::engine::{
    Diverged, Run, SideBySide, Weather, check_diverged, diverged_lanes, simulate, simulate_groups,
    simulate_one,
};
use ship::model::{DegreeOfFreedom, Vessel};
use thiserror::Error;

use crate::pooled::{COLLINEAR, PartView, Regression, collinear, diagnose, first_named};
use crate::{Batch, Excitation, Instruments, MeanRemoval, Outcome};

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
            Ok(groups) if groups.iter().all(|prepared| prepared.as_long_as(&groups[0])) => {
                Prepared::simulate_groups(groups, &self.nominal);
            }
            _ => all.iter_mut().for_each(|prepared| prepared.simulate(&self.nominal)),
        }
        let mut outcomes = Vec::with_capacity(all.len() * LANES);
        for prepared in &all {
            let count = prepared.starts.len();
            let diverged = diverged_lanes(&prepared.instrument_states).into_iter().take(count).enumerate();
            if let Some((lane, at)) = diverged.into_iter().find_map(|(lane, at)| Some((lane, at?))) {
                return Err((outcomes.len() + lane, at));
            }
            let batch = prepared.batch();
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
        let lanes = SideBySide::of(&runs.iter().map(Run::view).collect::<Vec<_>>());
        Self::of(vessel, lanes, runs.iter().map(Run::starts).collect())
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
        let initial = [0, 1, 2].map(|d: usize| Wide(groups.each_ref().map(|group| group.runs.initial[d])));
        groups.iter_mut().for_each(|group| group.is_simulated = true);
        let runs = groups.each_mut();
        let runs =
            runs.map(|group| (group.runs.instrument_exogenous(), group.instrument_states.as_mut_slice()));
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

refusal::choices! {
    /// What instruments are made of.
    pub enum InstrumentKind {
        /// The nominal model simulated over the run's inputs from the run's initial state.
        Nominal = "nominal",
        /// The measured regressors themselves: least squares.
        Regressors = "regressors",
    }
}

/// The inputs and the initial state of a run.
#[derive(Clone, Debug)]
pub struct Doing<'a> {
    /// Its design.
    pub design: &'a str,
    /// Its number.
    pub run: i32,
    /// First samples of its segments.
    pub starts: Vec<usize>,
    /// State at the start.
    pub initial: [f64; 3],
    /// N × exogenous, row-major.
    pub exogenous: &'a [f64],
}

impl<'a> Doing<'a> {
    fn of(run: &'a Run) -> Self {
        let Run { design, initial, exogenous, .. } = run;
        Self { design, run: run.run, starts: run.starts(), initial: *initial, exogenous }
    }
}

/// The instruments of all runs with the same inputs.
pub struct SharedInputs<'a> {
    vessel: &'a Vessel,
    exogenous: &'a [f64],
    starts: Vec<usize>,
    states: Vec<f64>,
    sums: Instruments,
}

impl<'a> SharedInputs<'a> {
    /// The instruments of runs with the inputs and initial state of `one`.
    ///
    /// # Errors
    /// The nominal simulation diverges.
    pub fn new(vessel: &'a Vessel, one: &Doing<'a>, removal: MeanRemoval) -> Result<Self, NominalDiverged> {
        let Doing { design, run, starts, initial, exogenous } = one.clone();
        let states = simulate_one(&vessel.model, &vessel.nominal, initial, exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(NominalDiverged::over(design, run, at, vessel.sample_rate_hz));
        }
        let unmeasured = vec![Lane::ZERO; states.len()];
        let sums = Instruments::new(&batch(vessel, exogenous, &states, &starts, &unmeasured), removal);
        Ok(Self { vessel, exogenous, starts, states, sums })
    }

    /// The parameters of [`LANES`] such runs from their `measured` states, (N+1) × 3.
    pub fn parameters(&self, measured: &[Lane]) -> Vec<Outcome<Vec<f64>>> {
        self.sums.parameters(&self.batch(measured))
    }

    /// Their estimates, and the excitation of each degree of freedom.
    fn estimates_with_excitation(&self, measured: &[Lane]) -> Vec<(Outcome, [Excitation; 3])> {
        self.sums.estimate_with_excitation(&self.batch(measured))
    }

    fn batch<'b>(&'b self, measured: &'b [Lane]) -> Batch<'b, f64> {
        batch(self.vessel, self.exogenous, &self.states, &self.starts, measured)
    }
}

fn batch<'b>(
    vessel: &'b Vessel,
    exogenous: &'b [f64],
    instrument_states: &'b [f64],
    starts: &'b [usize],
    measured: &'b [Lane],
) -> Batch<'b, f64> {
    Batch {
        model: &vessel.model,
        measured,
        instrument_states,
        exogenous,
        instrument_exogenous: exogenous,
        segments: [starts; LANES],
    }
}

/// The nominal model's simulation over a run left every bound, so that there are no instruments.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the nominal model diverges over design {design}, run {run}, at sample {} in {}", .at.sample, DegreeOfFreedom::ALL[.at.state].name())]
pub struct NominalDiverged {
    /// The run's design.
    pub design: String,
    /// The run's number.
    pub run: i32,
    /// Where it diverged.
    pub at: Diverged,
    /// Samples per second \[Hz\].
    pub rate_hz: f64,
}

impl NominalDiverged {
    /// The part of the vessel that is invalid.
    pub fn invalid(&self) -> Invalid {
        let what = format!("nominal model (`nominal`) over design {}, run {}", self.design, self.run);
        self.at.invalid(what, self.rate_hz)
    }

    /// The divergence over a run of `design`.
    pub fn over(design: &str, run: i32, at: Diverged, rate_hz: f64) -> Self {
        Self { design: design.to_owned(), run, at, rate_hz }
    }
}

/// Name of the design of measured runs, whose true parameters are unknown.
const MEASURED: &str = "measured";

/// A direction in which the instrumental-variable estimate of a measured run would be noise.
#[derive(Clone, Debug, PartialEq)]
pub struct CollinearRun {
    /// 0 surge, 1 sway, 2 yaw: the first that has one.
    pub degree: usize,
    /// The dominant parameter, within the degree of freedom.
    pub parameter: usize,
    /// All degrees of freedom that have one, in words.
    pub words: String,
}

/// Looks for collinear instruments and regressors in a measured run: a condition index above [`COLLINEAR`], as in a
/// pooled estimate. Simulated runs are always estimated: their study shows the errors of those estimates. `None` also
/// if the nominal simulation diverges.
pub fn collinear_run(vessel: &Vessel, run: &Run, removal: MeanRemoval) -> Option<CollinearRun> {
    if run.design != MEASURED {
        return None;
    }
    let label = &run.segments.first()?.maneuver;
    let part = PartView { label, source: "", run: run.view().part(0..run.samples()) };
    let states = part.simulated(&vessel.model, &vessel.nominal).ok()?;
    let sums = Regression::with(&vessel.model, &part, &states).sums();
    let mut collinear_run: Option<CollinearRun> = None;
    for d in DegreeOfFreedom::ALL {
        let degree = &vessel.model.degrees[d as usize];
        let diagnosis = diagnose(&[&sums], removal, d as usize);
        if diagnosis.index <= COLLINEAR {
            continue;
        }
        let words = collinear(d, degree, &diagnosis, &[]);
        match &mut collinear_run {
            Some(known) => known.words = format!("{}; {words}", known.words),
            None => {
                let parameter = first_named(degree, &diagnosis);
                collinear_run = Some(CollinearRun { degree: d as usize, parameter, words });
            }
        }
    }
    collinear_run
}
