use maud::{Markup, html};

use super::number::three;
use super::trajectory_words::{heading, level};
use study::documents::{PlanLattice, Primitive, Voyage};

/// How the maneuvers became moves of the lattice, folded away.
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
                     under the nominal model. Drift margin: clearance kept for an unknown current, besides the margin of safety. \
                     Fits: nodes of the lattice at which the move is clear of obstacles."
                }
            }
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

fn table(voyage: &Voyage) -> Markup {
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Maneuver" }
                th scope="col" { "Side" }
                th.number scope="col" { "Heading" }
                th.number scope="col" { "at its end" }
                th.number scope="col" { "East [m]" }
                th.number scope="col" { "North [m]" }
                th.number scope="col" { "Maneuver [s]" }
                th.number scope="col" { "Leg [s]" }
                th.number scope="col" { "Residual [m]" }
                th.number scope="col" { "Residual [°]" }
                th.number scope="col" { "Drift margin [m]" }
                th.number scope="col" { "Fits" }
            } }
            tbody { @for (index, primitive) in voyage.primitives.iter().enumerate() {
                (row(primitive, &voyage.lattice, index > 0 && differs(&voyage.primitives[index - 1], primitive)))
            } }
        } }
    }
}

fn differs(a: &Primitive, b: &Primitive) -> bool {
    a.maneuver != b.maneuver
}

fn row(primitive: &Primitive, lattice: &PlanLattice, first: bool) -> Markup {
    let metres = |nodes: i64| three(nodes as f64 * lattice.cell_m);
    html! {
        tr.first[first].stray[primitive.fits == 0] {
            th scope="row" { (primitive.maneuver) }
            td { (primitive.side.name()) }
            td.number { (heading(level(lattice, primitive.h as i64))) }
            td.number { (heading(level(lattice, primitive.to_h as i64))) }
            td.number { (metres(primitive.di)) }
            td.number { (metres(primitive.dj)) }
            td.number { (three(primitive.maneuver_s)) }
            td.number { (three(primitive.leg_s)) }
            td.number { (three(primitive.residual_m)) }
            td.number { (three(primitive.residual_deg)) }
            td.number { (three(primitive.drift_margin_m)) }
            td.number { (primitive.fits) }
        }
    }
}
