use std::collections::BTreeMap;

use maneuver::merit::{Figure, Record};
use maneuver::{Generator, ManeuverKind};
use numerics::statistics::{mean, mean_interval, quantile, spread};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Merit, undisturbed};

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// The figures of merit of a standard maneuver.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ManeuverMerit {
    /// Its name in the dictionary.
    pub name: String,
    /// Its kind; empty where a log shows none.
    pub kind: String,
    /// What was sailed, as the log of the first run shows it; absent where it was simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sailed: Option<String>,
    /// Runs that have the figures.
    pub runs: u64,
    /// Runs that lack them.
    pub without: u64,
    /// Those of them, draws of a model's parameters, whose simulation diverges.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub diverged: u64,
    /// Why the first that lacks them does.
    pub reason: Option<String>,
    /// The figures.
    pub figures: Vec<FigureMerit>,
    /// What is to be known of them: an approach that was not steady, a current, what differs from the dictionary.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// What the ship did in the first run that has them.
    pub track: ShipTrack,
}

/// A figure of merit over all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FigureMerit {
    /// Its name.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Unit of its numbers: `deg`, `deg/s`, `L` (ship lengths), `s`, or the input's.
    pub unit: String,
    /// Its mean over the runs, as it was measured.
    pub value: f64,
    /// The mean without the current that the logs show; absent where they show none. The criterion is that of this value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corrected: Option<f64>,
    /// Its standard deviation; null of a single run.
    pub std: Option<f64>,
    /// Lower end of the 95 % interval: of the mean, or of 95 % of the models that the data leave possible; null of a single
    /// run, and where more than 5 % of these have no figures.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
    /// The greatest value that IMO MSC.137(76) allows; null where it says nothing of this test.
    pub most: Option<f64>,
    /// Whether it keeps to that; null without a criterion, and where the interval holds it.
    pub passes: Option<bool>,
    /// Its derivative by every parameter of the model, in its unit per unit of the parameter, by central differences of the
    /// undisturbed ship; absent without `--slopes`, and where a ship with another parameter has no such figure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slopes: Option<BTreeMap<String, f64>>,
    /// Why it has no derivatives, where they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_slopes: Option<String>,
    /// Whether it is beside those that trials are designed for.
    #[serde(skip)]
    is_aside: bool,
}

/// The track of a ship, from where the maneuver begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShipTrack {
    /// Times.
    pub t_s: Vec<f64>,
    /// Changes of heading, to starboard.
    pub heading_deg: Vec<f64>,
    /// Ship lengths along the course of the approach.
    pub ahead: Vec<f64>,
    /// Ship lengths to starboard of it.
    pub abeam: Vec<f64>,
    /// Surge speeds.
    pub surge_m_s: Vec<f64>,
    /// Yaw rates.
    pub yaw_rate_deg_s: Vec<f64>,
}

/// The most places of a path.
const MOST: usize = 400;

impl ShipTrack {
    /// That of a record, thinned out.
    pub fn of(record: &Record, length_m: f64) -> Self {
        let count = record.heading.len();
        let step = count.div_ceil(MOST).max(1);
        let places = || (0..count).step_by(step);
        let (sin, cos) = libm::sincos(record.heading[0]);
        let off = |k: usize| [0, 1].map(|axis| (record.place[k][axis] - record.place[0][axis]) / length_m);
        Self {
            t_s: places().map(|k| k as f64 / record.rate_hz).collect(),
            heading_deg: places().map(|k| (record.heading[k] - record.heading[0]).to_degrees()).collect(),
            ahead: places().map(off).map(|[north, east]| north * cos + east * sin).collect(),
            abeam: places().map(off).map(|[north, east]| east * cos - north * sin).collect(),
            surge_m_s: places().map(|k| record.surge[k]).collect(),
            yaw_rate_deg_s: places().map(|k| record.yaw_rate[k].to_degrees()).collect(),
        }
    }
}

impl ManeuverMerit {
    /// How many runs lack the figures: `13 of 100 runs without figures, 13 diverge`; `None` where none does.
    pub fn lacking(&self) -> Option<String> {
        let diverged = if self.diverged > 0 { format!(", {} diverge", self.diverged) } else { String::new() };
        let all = self.runs + self.without;
        (self.without > 0).then(|| format!("{} of {all} runs without figures{diverged}", self.without))
    }

    /// With the derivatives of its figures; `None` where they were not computed.
    pub(super) fn with_slopes(mut self, slopes: Option<&Result<Vec<FigureSlopes>, Invalid>>) -> Self {
        let Some(slopes) = slopes else { return self };
        for figure in self.figures.iter_mut().filter(|figure| !figure.is_aside) {
            let computed = slopes.as_ref().map(|all| all.iter().find(|one| one.figure == figure.name));
            match computed.map(|of| of.map(|one| &one.slopes)) {
                Ok(Some(Ok(slopes))) => figure.slopes = Some(slopes.clone()),
                Ok(Some(Err(why))) | Err(why) => figure.without_slopes = Some(why.to_string()),
                Ok(None) => {
                    figure.without_slopes = Some("the undisturbed model has no such figure".to_owned())
                }
            }
        }
        self
    }
}

impl FigureMerit {
    /// Those of every run, of which some may lack some; whether runs are draws `of` parameters, and whether few enough of them failed.
    pub(super) fn all(runs: &[Vec<Figure>], of: (bool, bool)) -> Vec<Self> {
        let mut known: Vec<&Figure> = Vec::new();
        for figure in runs.iter().flatten() {
            if known.iter().all(|one| one.name != figure.name) {
                known.push(figure);
            }
        }
        let named =
            |name: &str| runs.iter().flatten().filter(|figure| figure.name == name).collect::<Vec<_>>();
        known.into_iter().map(|figure| Self::new(&named(figure.name), of)).collect()
    }

    fn new(runs: &[&Figure], (of_parameters, is_interval_known): (bool, bool)) -> Self {
        let figure = runs[0];
        let values: Vec<f64> = runs.iter().map(|figure| figure.value).collect();
        let is_corrected = runs.iter().any(|figure| figure.corrected.is_some());
        let still: Vec<f64> = runs.iter().map(|figure| figure.corrected.unwrap_or(figure.value)).collect();
        let ends_of = |values: &[f64]| match of_parameters {
            true => middle(values).filter(|_| is_interval_known),
            false => mean_interval(values),
        };
        let value = mean(&values).unwrap_or(f64::NAN);
        let corrected = mean(&still).filter(|_| is_corrected);
        let (values, ends) = (&values, ends_of(&values));
        // Runs of different maneuvers under one name have no limit together.
        let most = figure.most.filter(|_| runs.iter().all(|run| run.most.is_some()));
        let passes = most.and_then(|most| match ends_of(&still) {
            Some([low, high]) if low <= most && most < high => None,
            _ => Some(corrected.unwrap_or(value) <= most),
        });
        Self {
            name: figure.name.to_owned(),
            what: figure.what.to_owned(),
            unit: figure.unit.clone(),
            value,
            corrected,
            std: (values.len() > 1).then(|| spread(values)).flatten(),
            low: ends.map(|[low, _]| low),
            high: ends.map(|[_, high]| high),
            most,
            passes,
            slopes: None,
            without_slopes: None,
            is_aside: figure.is_aside,
        }
    }

    /// In words: `first overshoot 4.95 ± 0.10 deg, at most 10 (IMO): passes`.
    pub fn words(&self) -> String {
        let Self { what, unit, value, corrected, low, high, most, passes, .. } = self;
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let ends = |(low, high): (f64, f64)| format!(" ({low:.3} to {high:.3})");
        let interval = low.zip(*high).map_or_else(String::new, ends);
        let still = corrected
            .map_or(String::new(), |corrected| format!(", {corrected:.3}{unit} corrected for the current"));
        let verdict = match (most, passes) {
            (Some(most), Some(true)) => format!(", IMO allows {most:.1}: passes"),
            (Some(most), Some(false)) => format!(", IMO allows {most:.1}: fails"),
            (Some(most), None) => format!(", IMO allows {most:.1}: open"),
            (None, _) => String::new(),
        };
        format!("{what} {value:.3}{unit}{interval}{still}{verdict}")
    }
}

/// Between which 95 % of the values are.
fn middle(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    if sorted.len() < 2 { None } else { Some([quantile(&sorted, 0.025)?, quantile(&sorted, 0.975)?]) }
}

/// The derivatives of a figure by the parameters, in its unit per unit of the parameter, by the parameter's name; or why it
/// has none.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureSlopes {
    /// Name of the figure.
    pub figure: &'static str,
    /// Its derivatives.
    pub slopes: Result<BTreeMap<String, f64>, Invalid>,
}

/// The figures of the undisturbed ship, or why it has none.
type MeanFigures = Result<Vec<Figure>, Invalid>;

/// Parts of a sample by which the helm of a zig-zag goes over later: figures are means over them. What a coarse model does
/// depends on where within a sample orders fall, and that jumps with the parameters.
const PHASES: u32 = 8;

impl Merit<'_> {
    /// Computes the derivatives of every figure at `parameters`: central differences of undisturbed ships, one parameter of
    /// each off by `step` of itself. Orders stay those of the dictionary, as in [`Merit::simulate_drawn`].
    ///
    /// # Errors
    /// A parameter of 0, which no step is relative to; a maneuver that the model cannot hold.
    pub fn differentiate(&mut self, parameters: &[f64], step: f64) -> Result<(), Invalid> {
        let names: Vec<&str> = self.hull.vessel.model.parameter_names().collect();
        if let Some((name, _)) = names.iter().zip(parameters).find(|(_, value)| **value == 0.0) {
            let (thing, remedy) = (format!("parameter `{name}`"), "give it a value, or take the term out");
            return Err(Invalid::new(thing, "0", "a value that a step is relative to", remedy));
        }
        let sample_s = 1.0 / self.hull.vessel.sample_rate_hz;
        let later = |phase| (f64::from(phase) + 0.5) / f64::from(PHASES) * sample_s;
        let phases: Vec<Generator> =
            (0..PHASES).filter_map(|phase| Some(self.generator?.clone().later(later(phase)))).collect();
        for place in 0..self.gathered.len() {
            let Some(index) = self.gathered[place].index else { continue };
            let figures_at = |parameters: &[f64]| self.mean_figures(&phases, index, parameters);
            let base = figures_at(parameters);
            let mut ends = Vec::with_capacity(names.len());
            for (i, name) in names.iter().enumerate() {
                let off = |sign: f64| {
                    let mut moved = parameters.to_vec();
                    moved[i] *= 1.0 + sign * step;
                    figures_at(&moved)
                };
                ends.push((*name, 2.0 * step * parameters[i], [off(-1.0), off(1.0)]));
            }
            self.gathered[place].slopes = Some(base.map(|figures| slopes(&figures, &ends)));
        }
        Ok(())
    }

    /// The figures of the undisturbed ship with `parameters`, means over the phases in which there is each.
    fn mean_figures(&self, phases: &[Generator], index: usize, parameters: &[f64]) -> MeanFigures {
        let is_phased = matches!(phases[0].maneuvers()[index].kind, ManeuverKind::ZigZagTest(_));
        let phases = if is_phased { phases } else { &phases[..1] };
        let mut mean: Vec<Figure> = Vec::new();
        for (number, phase) in phases.iter().enumerate() {
            let (standard, record) = undisturbed(self.hull.vessel, phase, index, parameters)?;
            let figures = maneuver::merit::figures(Some(standard), &record, &self.hull)?.figures;
            let figures: Vec<Figure> = figures.into_iter().filter(|figure| !figure.is_aside).collect();
            let part = 1.0 / phases.len() as f64;
            if number == 0 {
                mean = figures.iter().map(|figure| Figure { value: 0.0, ..figure.clone() }).collect();
            }
            mean.retain(|known| figures.iter().any(|figure| figure.name == known.name));
            for known in &mut mean {
                let value = figures.iter().find(|one| one.name == known.name).map(|one| one.value);
                known.value += part * value.unwrap_or(f64::NAN);
            }
        }
        Ok(mean)
    }
}

/// The slopes of all `figures` from those at both ends of every parameter's step, which has a name and a width.
fn slopes(figures: &[Figure], ends: &[(&str, f64, [MeanFigures; 2])]) -> Vec<FigureSlopes> {
    let one = |figure: &Figure| {
        let slopes = ends.iter().map(|(name, width, ends)| {
            slope(figure, name, *width, ends).map(|slope| ((*name).to_owned(), slope))
        });
        FigureSlopes { figure: figure.name, slopes: slopes.collect() }
    };
    figures.iter().map(one).collect()
}

/// The derivative of `figure` by the parameter `name` from the figures at both ends of its step, which are `width` apart.
fn slope(figure: &Figure, name: &str, width: f64, ends: &[MeanFigures; 2]) -> Result<f64, Invalid> {
    let thing = || format!("{} with another `{name}`", figure.what);
    let of = |end: &MeanFigures| {
        let figures =
            end.as_ref().map_err(|e| Invalid { thing: format!("{}: {}", thing(), e.thing), ..e.clone() })?;
        let value = figures.iter().find(|one| one.name == figure.name).map(|one| one.value);
        value.filter(|value| value.is_finite()).ok_or_else(|| {
            Invalid::new(thing(), "none", "one on both sides of the parameter", "run the maneuver longer")
        })
    };
    Ok((of(&ends[1])? - of(&ends[0])?) / width)
}
