use maud::{Markup, html};

use super::words::level;
use crate::number::three;
use crate::parts::Table;
use study::documents::{DroppedMove, Handling, PlanHandling, PlanLattice, Primitive, Voyage};

/// How the maneuvers became moves of the lattice, folded.
pub(super) fn moves(voyage: &Voyage) -> Markup {
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
                (table(voyage))
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

fn table(voyage: &Voyage) -> Table<(bool, &Primitive)> {
    let moves = &voyage.primitives;
    let first = |i: usize| i > 0 && moves[i - 1].maneuver != moves[i].maneuver;
    let metres = |nodes: i64| three(nodes as f64 * voyage.lattice.cell_m);
    Table::of(moves.iter().enumerate().map(|(i, primitive)| (first(i), primitive)))
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
