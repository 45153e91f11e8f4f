use std::f64::consts::TAU;

use crate::grid::{around, wrap};
use crate::{Grid, Handling, Leg, Phase, Purpose};

/// Names of the basic moves.
pub const BASIC_MOVES: [&str; 5] = ["straight", "faster", "slower", "turn-port", "turn-starboard"];

/// How many nodes beyond its shortest end a move is tried.
const FARTHER: usize = 5;
/// Most ends of a turn that are tried, nearest first.
const TURNS: usize = 24;

/// The basic moves from a heading level and mode: straight ahead, turns (on the spot at rest, arcs under
/// way), changes of speed. Each move has several legs, shortest first: a vessel that does not settle by the
/// end of one may settle by the end of a longer one.
///
/// Their names are [`BASIC_MOVES`]. At rest a vessel moves ahead at the crawl speed.
pub fn basic_moves(grid: &Grid, handling: &Handling, level: usize, mode: usize) -> Vec<Vec<Leg>> {
    let slower = mode.checked_sub(1);
    let faster = Some(mode + 1).filter(|mode| *mode < grid.modes.len());
    let modes = [Some(mode), faster, slower].into_iter().flatten();
    let mut moves: Vec<Vec<Leg>> = modes.map(|to| straights(grid, handling, level, mode, to)).collect();
    for side in [-1.0, 1.0] {
        // Levels count counter-clockwise, to port.
        let to = (level as i64 - side as i64).rem_euclid(grid.headings as i64) as usize;
        moves.push(match grid.modes[mode].speed_m_s {
            0.0 => vec![turn_on_the_spot(grid, level, to, mode, side)],
            _ => arcs(grid, handling, level, to, mode, side),
        });
    }
    moves
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

/// One step ahead, or as many as a change of speed needs, and longer ones.
fn straights(grid: &Grid, handling: &Handling, level: usize, from: usize, to: usize) -> Vec<Leg> {
    let (di, dj) = grid.step_along(level);
    let [north, east] = grid.displacement(di, dj);
    let (v0, v1) = (grid.modes[from].speed_m_s, grid.modes[to].speed_m_s);
    let needed = (v1 * v1 - v0 * v0).abs() / (2.0 * handling.acceleration_m_s2);
    let steps = (needed / libm::hypot(north, east)).ceil().max(1.0) as usize;
    (steps..=steps + FARTHER).map(|steps| straight(grid, level, [from, to], steps as i32)).collect()
}

/// `steps` steps ahead, from one mode to another.
fn straight(grid: &Grid, level: usize, [from, to]: [usize; 2], steps: i32) -> Leg {
    let (di, dj) = grid.step_along(level);
    let (v0, v1) = (grid.modes[from].speed_m_s, grid.modes[to].speed_m_s);
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

/// Straight–arc–straight from one level to the next, ending on nodes and within the yaw rate: the shortest first.
fn arcs(grid: &Grid, handling: &Handling, level: usize, to: usize, mode: usize, side: f64) -> Vec<Leg> {
    let speed = grid.modes[mode].speed_m_s;
    let (a, b) = (grid.heading_rad(level), grid.heading_rad(to));
    let turn = TAU / grid.headings as f64;
    let tangent = speed / handling.turn_rate_rad_s * libm::tan(turn / 2.0);
    // A move longer than the lattice is useless.
    let most = grid.nx.max(grid.ny) as f64;
    let reach = (3.0 + FARTHER as f64 + (2.0 * tangent / grid.cell_m).ceil()).min(most) as i32;
    let mut ends: Vec<(f64, i32, i32, f64)> = around(0, 0, reach)
        .filter_map(|(di, dj)| {
            let [north, east] = grid.displacement(di, dj);
            // North, east = p (cos a, sin a) + q (cos b, sin b).
            let det = libm::cos(a) * libm::sin(b) - libm::sin(a) * libm::cos(b);
            let p = (north * libm::sin(b) - east * libm::cos(b)) / det;
            let q = (libm::cos(a) * east - libm::sin(a) * north) / det;
            (p >= tangent - 1e-9 && q >= tangent - 1e-9).then_some((p + q, di, dj, p))
        })
        .collect();
    ends.sort_by(|x, y| x.0.total_cmp(&y.0));
    ends.truncate(TURNS);
    let radius_m = tangent / libm::tan(turn / 2.0);
    let along =
        |to: [f64; 2], heading_rad: f64| Phase::Line { to, heading_rad, from_m_s: speed, to_m_s: speed };
    let leg = |(_, di, dj, p): (f64, i32, i32, f64)| {
        let begin = [(p - tangent) * libm::cos(a), (p - tangent) * libm::sin(a)];
        let centre = [begin[0] - side * radius_m * libm::sin(a), begin[1] + side * radius_m * libm::cos(a)];
        let before = (p - tangent > 1e-6).then(|| along(begin, a));
        let arc = Phase::Arc { centre, radius_m, to_rad: wrap(b), side, speed_m_s: speed };
        Leg {
            purpose: Purpose::Basic(turn_name(side)),
            from: grid.layer(level, mode),
            di,
            dj,
            to: grid.layer(to, mode),
            phases: before.into_iter().chain([arc, along(grid.displacement(di, dj), b)]).collect(),
        }
    };
    ends.into_iter().map(leg).collect()
}
