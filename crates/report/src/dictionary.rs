use maud::{Markup, html};
use study::documents::{DesignDocument, EstimateDocument, MomentsDocument};

use crate::figures::{Curve, TraceColumn, TraceRow, TrackCell, TrackLine, palette, traces, tracks};
use crate::number::{percent, percent_within, three, three_or_dash, three_within};
use crate::parts::{Figures, HtmlTable, Section, entry, grouped, missing};
use crate::study::{ManeuverTrace, Study, optimized_first};

/// Every maneuver over time and in the plane.
pub(super) fn dictionary(study: &Study, figures: &mut Figures) -> Section {
    let body = match study.dictionary.as_deref() {
        Some(maneuvers) if !maneuvers.is_empty() => drawn(maneuvers, study.design.as_ref(), figures),
        _ => missing("The maneuvers are", "dictionary.parquet", "simulate dictionary"),
    };
    Section::new("dictionary", "Dictionary", "Dictionary of maneuvers", body)
}

fn drawn(all: &[ManeuverTrace], design: Option<&DesignDocument>, figures: &mut Figures) -> Markup {
    let names = shown(all.iter().map(|maneuver| maneuver.name.as_str()), design);
    let maneuvers: Vec<&ManeuverTrace> = all.iter().filter(|m| names.contains(&m.name.as_str())).collect();
    let over_time = small_multiples(&maneuvers, design);
    let paths = maneuvers.iter().map(|maneuver| {
        let line = TrackLine { x: &maneuver.x, y: &maneuver.y, colour: Some(palette::BLUE) };
        TrackCell { name: &maneuver.name, lines: vec![line] }
    });
    let paths: Vec<TrackCell<'_>> = paths.collect();
    let track_caption = html! {
        b { "Plan view of every maneuver at one scale." }
        " Up is the heading at the start (x), right is starboard (y); the dot marks the start."
    };
    html! {
        (omission(all.len(), maneuvers.len()))
        (figures.place_wide("dictionary", over_time, &time_caption(&maneuvers)))
        (figures.place_wide("tracks", tracks(&paths), &track_caption))
        (descriptions(&maneuvers))
    }
}

/// The validation input as a single row of the same small multiples.
pub(super) fn validation_input(trace: &ManeuverTrace, figures: &mut Figures) -> Markup {
    let svg = small_multiples(&[trace], None);
    let caption = html! {
        b { "Validation input and the true response." }
        " The estimated models are simulated freely on this input and compared with this response."
    };
    figures.place_wide("validation-input", svg, &caption)
}

fn small_multiples(maneuvers: &[&ManeuverTrace], design: Option<&DesignDocument>) -> String {
    let inputs = InputScales::of(maneuvers);
    let columns = [
        TraceColumn { title: "inputs, each over its largest", legend: inputs.legend() },
        TraceColumn { title: "surge speed u [m/s]", legend: Vec::new() },
        TraceColumn { title: "sway speed v [m/s]", legend: Vec::new() },
        TraceColumn { title: "yaw rate r [rad/s]", legend: Vec::new() },
    ];
    let rows: Vec<TraceRow<'_>> = maneuvers.iter().map(|maneuver| row(maneuver, &inputs, design)).collect();
    traces(&columns, &rows)
}

fn row<'a>(
    maneuver: &'a ManeuverTrace,
    inputs: &InputScales<'_>,
    design: Option<&DesignDocument>,
) -> TraceRow<'a> {
    let design = design.filter(|design| used(design, &maneuver.name));
    let share = design.and_then(|design| design.shares.get(&maneuver.name));
    let states = [&maneuver.u, &maneuver.v, &maneuver.r];
    let states = states.map(|values| vec![Curve { values: values.clone(), ..Curve::default() }]);
    TraceRow {
        name: &maneuver.name,
        note: share.map(|share| format!("{} of the optimal experiment", percent(*share))),
        t: &maneuver.t,
        cells: std::iter::once(inputs.curves(maneuver)).chain(states).collect(),
    }
}

/// The inputs of all maneuvers: name, unit and largest modulus.
struct InputScales<'a> {
    all: Vec<(&'a str, &'a str, f64)>,
}

impl<'a> InputScales<'a> {
    fn of(maneuvers: &[&'a ManeuverTrace]) -> Self {
        let mut all: Vec<(&str, &str, f64)> = Vec::new();
        for (name, unit, values) in maneuvers.iter().flat_map(|maneuver| &maneuver.inputs) {
            let largest = values.iter().filter(|v| v.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
            match all.iter_mut().find(|(known, ..)| known == name) {
                Some((_, _, most)) => *most = most.max(largest),
                None => all.push((name, unit, largest)),
            }
        }
        Self { all }
    }

    fn legend(&self) -> Vec<(String, palette::Rgb)> {
        let entry = |(index, (name, unit, largest)): (usize, &(&str, &str, f64))| {
            let unit = if *unit == "1" { String::new() } else { format!(" {unit}") };
            (format!("{name}, 1 = {}{unit}", three(*largest)), palette::input(index))
        };
        self.all.iter().enumerate().map(entry).collect()
    }

    fn curves(&self, maneuver: &ManeuverTrace) -> Vec<Curve> {
        let curve = |name: &str, values: &[f64], is_thin: bool| {
            let index = self.all.iter().position(|(known, ..)| *known == name)?;
            let largest = self.all[index].2;
            let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
            let values = values.iter().map(|value| scale * value).collect();
            Some(Curve { values, colour: Some(palette::input(index)), is_thin, ..Curve::default() })
        };
        let settings = maneuver.inputs.iter().map(|(name, _, values)| curve(name, values, false));
        let commands = maneuver.commands.iter().map(|(name, values)| curve(name, values, true));
        settings.chain(commands).flatten().collect()
    }
}

fn time_caption(maneuvers: &[&ManeuverTrace]) -> Markup {
    html! {
        b { "Inputs and undisturbed states of every maneuver." }
        " All rows of a column share one axis. Each input is divided by its largest modulus over all maneuvers, named above."
        @if maneuvers.iter().any(|maneuver| !maneuver.commands.is_empty()) {
            " Thin lines are what was commanded, which the actuators followed."
        }
    }
}

fn descriptions(maneuvers: &[&ManeuverTrace]) -> Markup {
    let words = |maneuver: &ManeuverTrace| {
        let parts = [maneuver.description.as_str(), maneuver.reached.as_str()];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
    };
    let described: Vec<_> = maneuvers.iter().filter(|maneuver| !words(maneuver).is_empty()).collect();
    html! {
        @if !described.is_empty() {
            dl.names { @for maneuver in described { (entry(&maneuver.name, words(maneuver))) } }
        }
    }
}

/// A dictionary with more maneuvers is not shown completely.
const MOST: usize = 40;
/// A maneuver with a smaller share counts as not used.
const LEAST: f64 = 5e-4;

/// Whether the design spends time on maneuver `name`.
pub(super) fn used(design: &DesignDocument, name: &str) -> bool {
    design.shares.get(name).is_some_and(|share| *share > LEAST)
}

/// The names that the page shows, in their order: all of a small dictionary; of a large one those in use and those
/// with the highest efficiency, or just the first without a design.
pub(super) fn shown<'a>(
    names: impl Iterator<Item = &'a str>,
    design: Option<&DesignDocument>,
) -> Vec<&'a str> {
    let names: Vec<&str> = names.collect();
    let mut ranked: Vec<usize> = (0..names.len()).collect();
    let mut most = MOST;
    if let Some(design) = design {
        let sensitivity = |name| design.sensitivities.get(name).copied().unwrap_or(f64::NEG_INFINITY);
        ranked.sort_by(|a, b| {
            let (a, b) = (names[*a], names[*b]);
            let by_use = used(design, b).cmp(&used(design, a));
            by_use.then(sensitivity(b).total_cmp(&sensitivity(a)))
        });
        most = most.max(names.iter().filter(|name| used(design, name)).count());
    }
    ranked.truncate(most);
    ranked.sort_unstable();
    ranked.into_iter().map(|index| names[index]).collect()
}

/// Says that a large dictionary is not shown completely.
pub(super) fn omission(all: usize, shown: usize) -> Markup {
    html! {
        @if shown < all {
            p.note {
                (shown) " of " (all) " maneuvers are shown: those in use and those closest to being worth their time."
            }
        }
    }
}

/// The excitation of every degree of freedom, and the nonstationarity of the maneuvers.
pub(super) fn excitation(study: &Study) -> Section {
    let conditions = match &study.estimate {
        Some(estimate) => conditioning(estimate),
        None => missing("Condition numbers are", "estimate.json", "estimate"),
    };
    let changes = match &study.moments {
        Some(moments) => nonstationarity(moments, study.design.as_ref()),
        None => missing("Nonstationarity is", "moments.json", "moments"),
    };
    let body = html! { div.pair { div { (conditions) } div { (changes) } } };
    Section::new("excitation", "Excitation", "Excitation", body)
}

fn conditioning(estimate: &EstimateDocument) -> Markup {
    let designs = optimized_first(&estimate.designs, |d| &d.design);
    let table = HtmlTable::of(grouped(designs, |d| &d.degrees))
        .compact()
        .mark("first", |(first, ..)| first)
        .name("Design", |(first, d, _)| if first { d.design.as_str() } else { "" })
        .text("Degree", |(.., degree)| &degree.name)
        .number("Condition, median", |(.., degree)| {
            three_within(degree.condition_median, degree.condition_median_interval)
        })
        .number("Largest", |(.., degree)| three_or_dash(degree.condition_max))
        .text("Weakest parameter, runs", |(.., degree)| {
            let share = percent_within(degree.weakest_share, degree.weakest_share_interval);
            format!("{}, {share}", degree.weakest_parameter)
        });
    html! {
        h3 { "Condition of the estimation" }
        (table)
        p.note { "Condition number of the column-scaled normal matrix; the weakest parameter dominates its weakest direction." }
    }
}

fn nonstationarity(MomentsDocument(moments): &MomentsDocument, design: Option<&DesignDocument>) -> Markup {
    let names = shown(moments.maneuvers.iter().map(|maneuver| maneuver.name.as_str()), design);
    let maneuvers = moments.maneuvers.iter().filter(|maneuver| names.contains(&maneuver.name.as_str()));
    let named = HtmlTable::of(maneuvers).compact().name("Maneuver", |maneuver| &maneuver.name);
    let table = moments.degrees.iter().fold(named, |table, degree| {
        table.number(&degree.name, |maneuver| {
            let moments = maneuver.degrees.iter().find(|d| d.name == degree.name);
            three_or_dash(moments.map(|d| d.nonstationarity))
        })
    });
    html! {
        h3 { "Nonstationarity of the maneuvers" }
        (table.number("Samples", |maneuver| maneuver.samples))
        (omission(moments.maneuvers.len(), names.len()))
        p.note {
            "Largest change of a moment between the first and the second half: 0 is stationary. Near 1 the moments hold for \
             the maneuver as a whole only, and a share that is run as a part of it gives other information."
        }
    }
}
