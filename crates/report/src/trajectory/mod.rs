//! The planned trajectory.

mod sheet;
mod trials;
pub(crate) mod words;

use std::collections::BTreeMap;

use maud::{Markup, html};
use sheet::{facts, information, sheet};
use study::documents::{
    DroppedMove, FrontPoint, Handling, LeftOut, PlanChart, PlanDocument, PlanHandling, PlanLattice,
    Primitive, Voyage, VoyageLeg,
};
use trials::{passage, trials};
use words::{cost, cost_title, level, minutes};

use crate::figures::{FrontDot, front as drawing};
use crate::interactive::chart;
use crate::number::{exact, percent, three};
use crate::parts::{Figures, HtmlTable, Section, beyond, missing};
use crate::planned_trial::PlannedTrial;
use crate::study::Study;

/// The style of the section, only on pages with a trajectory.
pub(super) const STYLE: &str = include_str!("style.css");

/// The plan on its chart, at sea, for the crew, and its value. `None` in a study without a planned trajectory.
pub(super) fn trajectory(study: &Study, figures: &mut Figures) -> Option<Section> {
    let trajectory = study.trajectory.as_ref()?;
    let body = match &trajectory.main {
        Some(main) => planned(study, main, figures),
        None => missing("The planned trajectory is", "plan.json", "plan"),
    };
    let body = html! { (body) (variants(&trajectory.variants, figures)) (trials(study, trajectory)) };
    Some(Section::new("trajectory", "Trajectory", "Trajectory", body))
}

/// A plan on its chart, at sea and for the crew.
pub(super) fn planned(study: &Study, main: &PlannedTrial, figures: &mut Figures) -> Markup {
    let map = map(main, figures);
    let voyage = main.plan.voyage.as_ref();
    // Unit and datum of the depths of each chart.
    let depths = main.plan.charts.iter().filter_map(|chart| Some((&chart.file, chart.depths.as_ref()?)));
    let depths: Vec<String> = depths.map(|(file, depths)| format!("{file}: {}", depths.words())).collect();
    html! {
        p.caution {
            b { "Not for navigation." }
            " The plan was checked in simulation against the charts that are named under "
            a href="#files" { "Files" }
            " and against nothing else."
            @if let Some(uncharted) = voyage.and_then(Voyage::uncharted) { " " (uncharted) "." }
            " The master decides."
        }
        @if !depths.is_empty() { p.note { b { "Depths and heights." } " " (depths.join("; ")) "." } }
        @if let Some(check) = voyage.map(|voyage| &voyage.check).filter(|check| !check.safe) {
            p.caution {
                b { "Unsafe." }
                " The plan fails its own check and was written by " code { "--allow=unsafe" } " only: " (check.faults.join(", ")) "."
            }
        }
        @if !main.stale.is_empty() {
            p.missing {
                "The plan is older than this study: it was made from another " code { (main.stale.join(", ")) }
                "; run the stage " code { "plan" } " again."
            }
        }
        div.map-and-facts { (map) div { (facts(&main.plan)) } }
        @match voyage {
            Some(voyage) => {
                (information(&voyage.information, study.design.is_some()))
                (passage(&voyage.passage))
                (sheet(study, &main.plan, voyage))
                (front(&main.plan, voyage, figures))
                (beyond(&main.plan.beyond))
                (moves(voyage))
                (charts(&main.plan.charts))
            }
            None => p.missing { "Times, places and clearances not shown: the plan solves a lattice problem without a chart or a vessel." }
        }
    }
}

fn map(main: &PlannedTrial, figures: &mut Figures) -> Markup {
    let caption = html! {
        b { "The trial on its chart." } " " (main.plan.statement)
        " Numbers: informative maneuvers, as in the maneuver sheet."
    };
    let legs = main.plan.voyage.as_ref().map_or(&[][..], |voyage| &voyage.legs);
    drawn(main, "map", &caption, legs, figures).unwrap_or_else(|| missing("The map is", "map.svg", "plan"))
}

/// The map of a trial, in the place of its figure the layers of its chart; `None` without either.
fn drawn(
    trial: &PlannedTrial,
    name: &str,
    caption: &Markup,
    legs: &[VoyageLeg],
    figures: &mut Figures,
) -> Option<Markup> {
    let layers = trial.document.as_ref().map(|map| chart(&format!("{name}-layers"), map, legs));
    Some(figures.place_map(name, trial.map.as_ref()?, layers, caption))
}

/// Variants of the plan: a smaller map and one line each.
fn variants(all: &[PlannedTrial], figures: &mut Figures) -> Markup {
    html! {
        @if !all.is_empty() {
            h3 { "Planned otherwise" }
            div.variants {
                @for variant in all {
                    @match drawn(variant, &variant.name.replacen("plan", "map", 1), &in_one_line(variant), &[], figures) {
                        Some(map) => div { (map) },
                        None => p.note { (in_one_line(variant)) " No map.svg." },
                    }
                }
            }
        }
    }
}

fn in_one_line(variant: &PlannedTrial) -> Markup {
    let plan = &variant.plan;
    let title = variant.name.strip_prefix("plan-").unwrap_or(&variant.name).replace('-', " ");
    html! {
        b { (title) ":" } " "
        (plan.status.name()) ", " (cost(plan.cost, plan.cost_unit)) " (at least " (cost(plan.lower_bound, plan.cost_unit)) "), "
        (plan.steps.len()) " steps"
        @if let Some(voyage) = &plan.voyage { ", " (minutes(voyage.duration_s)) " at sea (" (three(voyage.duration_s)) "\u{a0}s)" }
        "."
        @if let Some(check) = plan.voyage.as_ref().map(|v| &v.check).filter(|check| !check.safe) {
            " " b { "Unsafe:" } " " (check.faults.join(", ")) "."
        }
        @if !variant.stale.is_empty() { " Made from another " (variant.stale.join(", ")) "." }
    }
}

/// The electronic charts of the plan, remarks on their files, and the objects that were omitted, with reasons.
fn charts(charts: &[PlanChart]) -> Markup {
    let rows: Vec<(&PlanChart, LeftOut)> =
        charts.iter().flat_map(|chart| chart.left_out().map(move |left_out| (chart, left_out))).collect();
    let table = HtmlTable::of(rows.iter())
        .compact()
        .name("Chart", |(chart, _)| &chart.file)
        .text("Class", |(_, left_out)| left_out.class)
        .number("Objects", |(_, left_out)| left_out.objects)
        .text("Why", |(_, left_out)| left_out.why);
    html! {
        @if !charts.is_empty() {
            details {
                summary { "Electronic charts, and what of them was left out" }
                @for chart in charts {
                    p.note { (chart.named()) @for note in &chart.notes { "; " (note) } "." }
                }
                @if !rows.is_empty() { (table) } @else { p.note { "No object was left out." } }
            }
        }
    }
}

/// How the maneuvers became moves of the lattice, folded.
fn moves(voyage: &Voyage) -> Markup {
    let lattice = &voyage.lattice;
    html! {
        details {
            summary { "How the maneuvers became moves of the lattice" }
            p.note {
                (lattice.nx) " × " (lattice.ny) " nodes, " (three(lattice.cell_m)) "\u{a0}m apart, with " (lattice.headings) " headings"
                @if !lattice.modes.is_empty() { " and the speeds " (speeds(lattice)) }
                ". " (residuals(&voyage.primitives))
            }
            @if voyage.primitives.is_empty() {
                p.missing { "The plan lists no moves." }
            } @else {
                (moves_table(voyage))
                p.note {
                    "Displacement: to the node where the recovery ends. Residual: distance from that node and difference from its heading, \
                     under the nominal model. Spread: largest distance from the nominal vessel of those who rehearsed it, before the recovery. \
                     Fits: nodes of the lattice at which the move is clear of obstacles."
                }
            }
            (dropped(&voyage.dropped))
            (handling(&voyage.handling))
        }
    }
}

/// Moves that were not available to the search.
fn dropped(dropped: &[DroppedMove]) -> Markup {
    let Some(first) = dropped.first() else { return html! {} };
    html! {
        p.note {
            (dropped.len()) " moves are not offered to the search, since not all who rehearsed them end settled: such as "
            (first.name) " (" (first.mode) "), " (first.why) "."
        }
    }
}

/// The handling of the vessel between maneuvers.
fn handling(handling: &PlanHandling) -> Markup {
    let PlanHandling { used, derived } = handling;
    let words = |handling: &Handling| {
        format!(
            "turns of up to {}\u{a0}rad/s, changes of speed by {}\u{a0}m/s², response within {}\u{a0}s, lines aimed at {}\u{a0}m ahead",
            three(handling.turn_rate_rad_s),
            three(handling.acceleration_m_s2),
            three(handling.response_s),
            three(handling.lookahead_m)
        )
    };
    html! {
        p.note {
            "Handled with " (words(used)) "."
            @if *used != derived.handling { " From the vessel alone would follow " (words(&derived.handling)) "." }
        }
    }
}

/// The modes with their speeds, slowest first.
fn speeds(lattice: &PlanLattice) -> String {
    let mut modes: Vec<(&String, &f64)> = lattice.modes.iter().collect();
    modes.sort_by(|a, b| a.1.total_cmp(b.1));
    let each: Vec<String> =
        modes.iter().map(|(name, speed)| format!("{name} ({}\u{a0}m/s)", three(**speed))).collect();
    each.join(", ")
}

fn residuals(all: &[Primitive]) -> String {
    let most = |value: fn(&Primitive) -> f64| all.iter().map(|p| value(p).abs()).fold(0.0, f64::max);
    format!(
        "{} moves, off their nodes by at most {}\u{a0}m and {}°.",
        all.len(),
        three(most(|p| p.residual_m)),
        three(most(|p| p.residual_deg))
    )
}

fn moves_table(voyage: &Voyage) -> HtmlTable<(bool, &Primitive)> {
    let moves = &voyage.primitives;
    let first = |i: usize| i > 0 && moves[i - 1].maneuver != moves[i].maneuver;
    let metres = |nodes: i64| three(nodes as f64 * voyage.lattice.cell_m);
    HtmlTable::of(moves.iter().enumerate().map(|(i, primitive)| (first(i), primitive)))
        .compact()
        .mark("first", |(first, _)| first)
        .mark("stray", |(_, p)| p.fits == 0)
        .name("Maneuver", |(_, p)| &p.maneuver)
        .text("Side", |(_, p)| p.side.name())
        .number("Heading", |(_, p)| level(&voyage.lattice, p.h))
        .number("at its end", |(_, p)| level(&voyage.lattice, p.to_h))
        .number("East [m]", |(_, p)| metres(p.di))
        .number("North [m]", |(_, p)| metres(p.dj))
        .number("Maneuver [s]", |(_, p)| three(p.maneuver_s))
        .number("Leg [s]", |(_, p)| three(p.leg_s))
        .number("Residual [m]", |(_, p)| three(p.residual_m))
        .number("Residual [°]", |(_, p)| three(p.residual_deg))
        .number("Spread [m]", |(_, p)| three(p.spread_m))
        .number("Fits", |(_, p)| p.fits)
}

/// The Pareto front of counts: fewer uses for less cost.
fn front(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    html! {
        h3 { "Information against cost" }
        @if voyage.front.is_empty() {
            p.missing { "Not shown: the search was not exhaustive, so what fewer uses would cost is not known." }
        } @else {
            (shown(plan, voyage, figures))
        }
    }
}

fn shown(plan: &PlanDocument, voyage: &Voyage, figures: &mut Figures) -> Markup {
    let labels: Vec<String> = voyage.front.iter().map(|point| uses(&point.counts)).collect();
    let dots: Vec<FrontDot<'_>> = voyage
        .front
        .iter()
        .zip(&labels)
        .map(|(point, label)| FrontDot {
            cost: point.cost,
            log_det: point.log_det,
            label,
            chosen: is_chosen(plan, point),
        })
        .collect();
    let order: Vec<&str> = plan.counts.keys().map(String::as_str).collect();
    let caption = html! {
        b { "Fewer uses for less." } " Each dot is the best plan with other counts (" (order.join(", "))
        "); counts that cost more and tell less are left out. Filled: this plan."
    };
    html! {
        div.pair.front {
            (figures.place("front", drawing(&dots, cost_title(plan.cost_unit)), &caption))
            (sweep_table(plan, voyage))
        }
    }
}

/// `3·2·3`, in the order of the names.
fn uses(counts: &BTreeMap<String, u64>) -> String {
    counts.values().map(u64::to_string).collect::<Vec<_>>().join("·")
}

/// Whether `point` is this plan.
fn is_chosen(plan: &PlanDocument, point: &FrontPoint) -> bool {
    point.counts == plan.counts
}

fn sweep_table(plan: &PlanDocument, voyage: &Voyage) -> Markup {
    let dimension = voyage.information.dimension as f64;
    let chosen = voyage.front.iter().find(|point| is_chosen(plan, point)).map(|point| point.log_det);
    let marked =
        HtmlTable::of(&voyage.front).class("compact tight").mark("main", |point| is_chosen(plan, point));
    let mut table = plan
        .counts
        .keys()
        .fold(marked, |table, name| table.number(name, |point| point.counts.get(name).copied().unwrap_or(0)));
    table = table
        .number(cost_title(plan.cost_unit), |point| exact((point.cost * 1e3).round() / 1e3))
        .number("Informative legs", |point| minutes(point.informative_s))
        .number("log|det|", |point| three(point.log_det));
    if let Some(chosen) = chosen {
        table = table.number("Efficiency", |point| percent(libm::exp((point.log_det - chosen) / dimension)));
    }
    html! {
        div {
            (table)
            p.note {
                "Informative legs: with approach and recovery. log|det|: as the counts promise it."
                @if chosen.is_some() { " Efficiency: against this plan (bold), the ratio of the determinants to the power 1/" (voyage.information.dimension) "." }
            }
        }
    }
}
