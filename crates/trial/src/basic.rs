use std::f64::consts::TAU;

use crate::grid::{around, wrap};
use crate::{Grid, Handling, Leg, Phase, Purpose};

/// Names of the basic moves.
pub const BASIC_MOVES: [&str; 5] = ["straight", "faster", "slower", "turn-port", "turn-starboard"];

/// The moves that get the vessel about: straight ahead, turns (on the spot at rest, arcs under way), changes of speed.
///
/// Their names are [`BASIC_MOVES`]. At rest a vessel goes ahead at the crawl speed.
pub fn basic_legs(grid: &Grid, handling: &Handling) -> Vec<Leg> {
    let mut legs = Vec::new();
    for layer in 0..grid.layers() {
        let (level, mode) = grid.level_and_mode(layer);
        let speed = grid.modes[mode].speed_m_s;
        legs.push(straight(grid, handling, level, mode, mode));
        if mode + 1 < grid.modes.len() {
            legs.push(straight(grid, handling, level, mode, mode + 1));
        }
        if mode > 0 {
            legs.push(straight(grid, handling, level, mode, mode - 1));
        }
        for side in [-1.0, 1.0] {
            // Levels count counter-clockwise, to port.
            let to = (level as i64 - side as i64).rem_euclid(grid.headings as i64) as usize;
            if speed == 0.0 {
                legs.push(turn_on_the_spot(grid, level, to, mode, side));
            } else {
                legs.extend(arc(grid, handling, level, to, mode, side));
            }
        }
    }
    legs
}

fn turn_name(side: f64) -> String {
    if side > 0.0 { "turn-starboard" } else { "turn-port" }.to_owned()
}

fn turn_on_the_spot(grid: &Grid, level: usize, to: usize, mode: usize, side: f64) -> Leg {
    Leg {
        purpose: Purpose::Basic(turn_name(side)),
        from: grid.layer(level, mode),
        di: 0,
        dj: 0,
        to: grid.layer(to, mode),
        phases: vec![Phase::Hold { at: [0.0, 0.0], heading_rad: grid.heading_rad(to) }],
    }
}

/// One step ahead, or as many as a change of speed takes.
fn straight(grid: &Grid, handling: &Handling, level: usize, from: usize, to: usize) -> Leg {
    let (di, dj) = grid.step_along(level);
    let [north, east] = grid.displacement(di, dj);
    let (v0, v1) = (grid.modes[from].speed_m_s, grid.modes[to].speed_m_s);
    let needed = (v1 * v1 - v0 * v0).abs() / (2.0 * handling.acceleration_m_s2);
    let steps = (needed / libm::hypot(north, east)).ceil().max(1.0) as i32;
    let end = grid.displacement(steps * di, steps * dj);
    let heading_rad = grid.heading_rad(level);
    let phases = if v0 == 0.0 && v1 == 0.0 {
        vec![Phase::Hold { at: end, heading_rad }]
    } else if v1 == 0.0 {
        vec![line(end, v0, v1), Phase::Hold { at: end, heading_rad }]
    } else {
        vec![line(end, v0, v1)]
    };
    let name = match to.cmp(&from) {
        std::cmp::Ordering::Equal => "straight",
        std::cmp::Ordering::Greater => "faster",
        std::cmp::Ordering::Less => "slower",
    };
    Leg {
        purpose: Purpose::Basic(name.to_owned()),
        from: grid.layer(level, from),
        di: steps * di,
        dj: steps * dj,
        to: grid.layer(level, to),
        phases,
    }
}

/// From the node along the course to `to`.
fn line(to: [f64; 2], from_m_s: f64, to_m_s: f64) -> Phase {
    Phase::Line { to, heading_rad: libm::atan2(to[1], to[0]), from_m_s, to_m_s }
}

/// The shortest straight–arc–straight from one level to the next that ends on a node and keeps within the yaw rate.
fn arc(grid: &Grid, handling: &Handling, level: usize, to: usize, mode: usize, side: f64) -> Option<Leg> {
    let speed = grid.modes[mode].speed_m_s;
    let (a, b) = (grid.heading_rad(level), grid.heading_rad(to));
    let turn = TAU / grid.headings as f64;
    let tangent = speed / handling.turn_rate_rad_s * libm::tan(turn / 2.0);
    // A move longer than the lattice is of no use.
    let reach = (3.0 + (2.0 * tangent / grid.cell_m).ceil()).min(grid.nx.max(grid.ny) as f64) as i32;
    let (_, di, dj, p) = around(0, 0, reach)
        .filter_map(|(di, dj)| {
            let [north, east] = grid.displacement(di, dj);
            // North, east = p (cos a, sin a) + q (cos b, sin b).
            let det = libm::cos(a) * libm::sin(b) - libm::sin(a) * libm::cos(b);
            let p = (north * libm::sin(b) - east * libm::cos(b)) / det;
            let q = (libm::cos(a) * east - libm::sin(a) * north) / det;
            (p >= tangent - 1e-9 && q >= tangent - 1e-9).then_some((p + q, di, dj, p))
        })
        .min_by(|x, y| x.0.total_cmp(&y.0))?;
    let radius_m = tangent / libm::tan(turn / 2.0);
    let end = grid.displacement(di, dj);
    let begin = [(p - tangent) * libm::cos(a), (p - tangent) * libm::sin(a)];
    let centre = [begin[0] - side * radius_m * libm::sin(a), begin[1] + side * radius_m * libm::cos(a)];
    let along =
        |to: [f64; 2], heading_rad: f64| Phase::Line { to, heading_rad, from_m_s: speed, to_m_s: speed };
    let mut phases = Vec::new();
    if p - tangent > 1e-6 {
        phases.push(along(begin, a));
    }
    phases.push(Phase::Arc { centre, radius_m, to_rad: wrap(b), side, speed_m_s: speed });
    phases.push(along(end, b));
    Some(Leg {
        purpose: Purpose::Basic(turn_name(side)),
        from: grid.layer(level, mode),
        di,
        dj,
        to: grid.layer(to, mode),
        phases,
    })
}
