use maud::{display, html};
use study::documents::{DesignScores, Estimator, EstimatorScores};

use super::number::{median, or_dash, percent, q90};
use super::parts::{Section, statements};
use super::study::{Study, optimized_first};
use super::table::Table;

/// Statistics of many realizations in memory, by design and estimator, unless they are those of the validation.
pub(super) fn realizations(study: &Study) -> Option<Section> {
    let tally = study.tally.as_ref()?;
    let counted: u64 = tally.tally.counted.iter().map(|counted| counted.runs).sum();
    if tally.scores.len() < 2 && study.scored().iter().map(|design| design.runs).sum::<u64>() == counted {
        return None;
    }
    let rows: Vec<(Estimator, &DesignScores)> = tally.scores.iter().flat_map(designs).collect();
    let share = |share: f64, interval: Option<[f64; 2]>| {
        let half = |[low, high]: [f64; 2]| 50.0 * (high - low);
        or_dash(interval.map(|ends| format!("{:.2} ± {:.2} %", 100.0 * share, half(ends))))
    };
    let table = Table::of(rows)
        .compact()
        .name("Design", |(_, d)| d.design.as_str())
        .text("Estimator", |(estimator, _)| display(estimator))
        .number("Runs", |(_, d)| d.runs)
        .number("Parameter error below its bound", |(_, d)| {
            share(d.parameter_error_share, d.parameter_error_share_interval)
        })
        .number("Median", |(_, d)| median(&d.parameter_error))
        .number("90 %", |(_, d)| q90(&d.parameter_error))
        .number("Simulation error below its bound", |(_, d)| {
            share(d.simulation_error_share, d.simulation_error_share_interval)
        })
        .number("Diverged", |(_, d)| d.diverged)
        .number("Not identifiable", |(_, d)| d.not_identifiable);
    let body = html! {
        (table)
        (statements(&tally.statements))
        p.note {
            "Estimated and scored as soon as they are simulated (" code { "monte-carlo" } "), seed " (tally.seed)
            ". After ±: half of the 95 % interval (Wilson's). Quantiles are read from histograms, to "
            (percent(tally.quantile_error)) "."
        }
    };
    Some(Section::new("realizations", "Realizations", "Many realizations", body))
}

fn designs(by: &EstimatorScores) -> impl Iterator<Item = (Estimator, &DesignScores)> {
    optimized_first(&by.designs, |d| &d.design).into_iter().map(|scores| (by.estimator, scores))
}
