//! Figures of merit of standard maneuvers over many runs, or of a model with uncertain parameters.

mod slopes;
mod summary;

use engine::{Run, Streams, check_runaway, simulate_command};
use identification::pooled::Uncertain;
use maneuver::merit::{Figure, Hull, Record, figures};
use maneuver::{Generator, Standard};
use model::Vessel;
use refusal::Invalid;

pub use slopes::FigureSlopes;
pub use summary::{FigureMerit, ManeuverMerit, ShipTrack};

/// The figures of one maneuver in one run.
#[derive(Clone, Debug, PartialEq)]
pub struct MeritRow {
    /// Its design.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// The maneuver.
    pub maneuver: String,
    /// The figure.
    pub figure: Figure,
}

/// Why a maneuver is not simulated.
#[derive(Clone, Debug, PartialEq)]
pub enum Unsimulated {
    /// The dictionary's maneuver cannot be held.
    Unheld(Invalid),
    /// The ship diverges in it.
    Diverged(Invalid),
}

impl From<Unsimulated> for Invalid {
    fn from(own: Unsimulated) -> Self {
        match own {
            Unsimulated::Unheld(invalid) | Unsimulated::Diverged(invalid) => invalid,
        }
    }
}

/// What is gathered of a maneuver.
struct Gathered {
    index: usize,
    /// The figures of every run that has them.
    figures: Vec<Vec<Figure>>,
    /// Runs that lack them, and why the first does.
    without: u64,
    reason: Option<Invalid>,
    /// Those of them whose simulation diverges.
    diverged: u64,
    track: Option<ShipTrack>,
    /// The derivatives of the figures, or why the undisturbed ship has no figures; `None` where they were not computed.
    slopes: Option<Result<Vec<FigureSlopes>, Invalid>>,
}

impl Gathered {
    /// Counts a run without figures.
    fn lacks(&mut self, why: Invalid) {
        self.without += 1;
        self.reason.get_or_insert(why);
    }
}

/// Refuses figures of which one is no number.
fn all_finite(figures: Vec<Figure>) -> Result<Vec<Figure>, Invalid> {
    match figures.iter().find(|own| !own.value.is_finite()) {
        None => Ok(figures),
        Some(own) => {
            Err(Invalid::new(own.what, own.value.to_string(), "a number", "run it longer, or with more helm"))
        }
    }
}

/// Figures of the standard maneuvers of a dictionary.
pub struct Merit<'a> {
    generator: &'a Generator,
    hull: Hull<'a>,
    gathered: Vec<Gathered>,
    rows: Vec<MeritRow>,
}

impl<'a> Merit<'a> {
    /// None so far, for a ship of this length \[m\].
    ///
    /// # Errors
    /// A dictionary without standard maneuvers.
    pub fn new(vessel: &'a Vessel, generator: &'a Generator, length_m: f64) -> Result<Self, Invalid> {
        let standard = |index: &usize| generator.maneuvers()[*index].kind.standard().is_some();
        let blank = |index: usize| Gathered {
            index,
            figures: Vec::new(),
            without: 0,
            reason: None,
            diverged: 0,
            track: None,
            slopes: None,
        };
        let gathered: Vec<Gathered> = (0..generator.maneuvers().len()).filter(standard).map(blank).collect();
        if gathered.is_empty() {
            return Err(Invalid::new(
                "[[maneuver]]",
                "no standard maneuver",
                "one of kind `zig-zag-test`, `turning-circle`, `pull-out`, `spiral-test`, `reverse-spiral` or `stop`",
                "add one",
            ));
        }
        Ok(Self { generator, hull: Hull { vessel, length_m }, gathered, rows: Vec::new() })
    }

    /// Adds a recorded run; `poses` are its north, east \[m\] and heading \[rad\] at every sample, where they were recorded, else
    /// they are reckoned from its states.
    pub fn add(&mut self, run: &Run, poses: Option<&[[f64; 3]]>) {
        let vessel = self.hull.vessel;
        let width = vessel.model.exogenous();
        let ends = run.segments.iter().skip(1).map(|next| next.start).chain([run.samples()]);
        for (segment, end) in run.segments.iter().zip(ends) {
            let place = self
                .gathered
                .iter()
                .position(|own| self.generator.maneuvers()[own.index].name == segment.maneuver);
            let Some(place) = place else { continue };
            let samples = segment.start..end;
            let states = &run.measured[3 * samples.start..3 * (samples.end + 1)];
            let inputs = vessel.model.inputs_of(&run.exogenous[width * samples.start..width * samples.end]);
            let record = Record::of_states(states, inputs, vessel.sample_rate_hz);
            let record = match poses {
                Some(poses) => record.with_poses(&poses[samples.start..=samples.end]),
                None => record,
            };
            self.measure(place, &run.design, run.run, &record);
        }
    }

    /// Simulates every standard maneuver undisturbed, with `parameters`, as run `run`.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold, or in which it diverges.
    pub fn simulate(&mut self, parameters: &[f64], run: i32) -> Result<(), Unsimulated> {
        for place in 0..self.gathered.len() {
            let index = self.gathered[place].index;
            let (_, record) = undisturbed(self.hull.vessel, self.generator, index, parameters)?;
            self.measure(place, "model", run, &record);
        }
        Ok(())
    }

    /// Simulates them with parameters that are drawn `draws` times from what an estimate leaves uncertain. Draws that diverge or
    /// cannot hold a maneuver are counted as runs without figures.
    pub fn simulate_drawn(&mut self, uncertain: &Uncertain, draws: u32, seed: u64) {
        let streams = Streams::new(seed, "merit");
        for draw in 0..draws {
            let parameters = uncertain.drawn(&streams, draw);
            for place in 0..self.gathered.len() {
                let index = self.gathered[place].index;
                match undisturbed(self.hull.vessel, self.generator, index, &parameters) {
                    Ok((_, record)) => self.measure(place, "model", draw as i32, &record),
                    Err(why) => {
                        self.gathered[place].diverged += u64::from(matches!(why, Unsimulated::Diverged(_)));
                        self.gathered[place].lacks(why.into());
                    }
                }
            }
        }
    }

    fn measure(&mut self, place: usize, design: &str, run: i32, record: &Record) {
        let own = &mut self.gathered[place];
        let maneuver = &self.generator.maneuvers()[own.index];
        let Some(standard) = maneuver.kind.standard() else { return };
        let found = figures(standard, record, &self.hull);
        match found.and_then(all_finite) {
            Ok(found) => {
                self.rows.extend(found.iter().map(|figure| MeritRow {
                    design: design.to_owned(),
                    run,
                    maneuver: maneuver.name.clone(),
                    figure: figure.clone(),
                }));
                own.track.get_or_insert_with(|| ShipTrack::of(record, self.hull.length_m));
                own.figures.push(found);
            }
            Err(invalid) => own.lacks(invalid),
        }
    }

    /// A row for every figure of every run.
    pub fn rows(&self) -> &[MeritRow] {
        &self.rows
    }

    /// Every maneuver that was run. `of_parameters`: runs are draws of parameters, so that intervals hold 95 % of them; else
    /// intervals are those of the mean.
    ///
    /// # Errors
    /// Maneuvers that have no figures in any run; no maneuver that was run.
    pub fn summary(&self, of_parameters: bool) -> Result<Vec<ManeuverMerit>, Invalid> {
        let ran = |own: &&Gathered| own.without > 0 || !own.figures.is_empty();
        let all: Vec<&Gathered> = self.gathered.iter().filter(ran).collect();
        if all.is_empty() {
            let names = self.gathered.iter().map(|own| self.generator.maneuvers()[own.index].name.as_str());
            return Err(Invalid::new(
                "maneuvers",
                "no run of a standard maneuver of the dictionary",
                format!("one of `{}`", names.collect::<Vec<_>>().join("`, `")),
                "name the maneuvers in the dictionary as in the trajectories",
            ));
        }
        let reasons = || all.iter().filter_map(|own| Some((own, own.reason.as_ref()?)));
        if let (true, Some((own, reason))) = (all.iter().all(|own| own.figures.is_empty()), reasons().next())
        {
            let name = &self.generator.maneuvers()[own.index].name;
            return Err(Invalid { thing: format!("maneuver `{name}`, {}", reason.thing), ..reason.clone() });
        }
        let one = |own: &Gathered| {
            ManeuverMerit::new(
                &self.generator.maneuvers()[own.index],
                &own.figures,
                (own.without, own.diverged, own.reason.as_ref()),
                own.track.clone().unwrap_or_default(),
                of_parameters,
            )
            .with_slopes(own.slopes.as_ref())
        };
        Ok(all.into_iter().map(one).collect())
    }
}

/// A maneuver, and what the undisturbed ship with `parameters` does in it.
fn undisturbed<'a>(
    vessel: &Vessel,
    generator: &'a Generator,
    index: usize,
    parameters: &[f64],
) -> Result<(Standard<'a>, Record), Unsimulated> {
    let realized =
        generator.samples(index).and_then(|samples| Ok((samples, generator.realize(index, samples)?)));
    let (samples, realized) = realized.map_err(Unsimulated::Unheld)?;
    let maneuver = &generator.maneuvers()[index];
    let (Some(standard), Some(helm)) = (maneuver.kind.standard(), &realized.helm) else {
        let e = Invalid::new("maneuver", "no orders", "those of a standard maneuver", "remove it");
        return Err(Unsimulated::Unheld(e));
    };
    let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
    let run = simulate_command(model, parameters, realized.initial, samples, rate_hz, helm);
    if let Some(at) = check_runaway(&run.states, standard.speed_m_s()) {
        let what = format!("model in maneuver `{}`", maneuver.name);
        return Err(Unsimulated::Diverged(at.invalid(what, rate_hz)));
    }
    Ok((standard, Record::of_states(&run.states, model.inputs_of(&run.exogenous), rate_hz)))
}
