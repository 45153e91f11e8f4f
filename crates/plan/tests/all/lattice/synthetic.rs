//! Made-up archipelagos for tests and measurements.

use std::collections::HashSet;

use plan::lattice::{
    BasicFile, InformativeFile, LatticeFile, MoveFile, MoveId, Pose, Problem, ProblemFile, SCHEMA,
};

/// Pitch of the cells \[m\].
const CELL: f64 = 100.0;
/// Half the hull's length and width with a margin \[m\].
const HALF_LENGTH: f64 = 25.05;
const HALF_WIDTH: f64 = 9.05;
/// Cells per island, on average.
const CELLS_PER_ISLAND: usize = 45;
/// Boxes of an island along y.
const STRIPS: usize = 7;

/// A map of round islands with `informative` zigzags of `count` uses each and moves forward and on the spot as basic
/// ones of cost 1, on `nx * ny` cells with `headings` levels (a multiple of 4). The start is a free pose low in the
/// lattice, the goal one that basic moves reach from there, far up. The same seed gives the same problem.
pub fn archipelago(
    nx: usize,
    ny: usize,
    headings: usize,
    informative: usize,
    count: u32,
    seed: u64,
) -> ProblemFile {
    let mut random = Random(seed);
    let mut file = ProblemFile {
        schema: SCHEMA.into(),
        name: format!("archipelago_{nx}_{ny}_{headings}_{informative}_{count}_{seed}"),
        description: None,
        variant: None,
        lattice: LatticeFile { nx, ny, headings, cell: CELL, origin: [CELL / 2.0, CELL / 2.0] },
        bounds: [0.0, 0.0, CELL * nx as f64, CELL * ny as f64],
        obstacles: islands(nx, ny, &mut random),
        informative: (0..informative).map(|q| zigzag(q, count, headings)).collect(),
        basic: vec![
            forward(headings),
            turn("rotate_cw", headings, headings - 1),
            turn("rotate_ccw", headings, 1),
        ],
        start: [0, 0, 0],
        goal: [0, 0, 0],
        expected: None,
    };
    if let Some((start, goal)) = ends(&file) {
        (file.start, file.goal) = (start, goal);
    }
    file
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let word = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Discs as strips of boxes with whole metres as edges.
fn islands(nx: usize, ny: usize, random: &mut Random) -> Vec<[f64; 4]> {
    let mut boxes = Vec::new();
    for _ in 0..nx * ny / CELLS_PER_ISLAND {
        let (x, y) = (random.uniform(0.0, CELL * nx as f64), random.uniform(0.0, CELL * ny as f64));
        let radius = CELL * random.uniform(0.3, 2.2);
        for strip in 0..STRIPS {
            let edge = |k: usize| radius * (2.0 * k as f64 / STRIPS as f64 - 1.0);
            let centre = 0.5 * (edge(strip) + edge(strip + 1));
            let half = (radius * radius - centre * centre).sqrt();
            boxes.push([x - half, y + edge(strip), x + half, y + edge(strip + 1)].map(f64::round));
        }
    }
    boxes
}

/// Cells that are `length` cells away in the direction of a heading level, nearly.
fn ahead(heading: usize, headings: usize, length: f64, sideways: f64) -> (i32, i32) {
    let angle = std::f64::consts::TAU * heading as f64 / headings as f64;
    let (sin, cos) = angle.sin_cos();
    let round = |value: f64| (value + 1e-9).round() as i32;
    (round(length * cos - sideways * sin), round(length * sin + sideways * cos))
}

/// Zigzags of different lengths, bulges and drifts to the side.
fn zigzag(q: usize, count: u32, headings: usize) -> InformativeFile {
    let length = [2.0, 3.0, 1.0, 4.0, 2.0, 3.0][q % 6];
    let drift = [0.0, 1.0, 2.0, 0.0, -1.0][q % 5];
    let bulge = CELL * [0.3, 0.8, 0.2, 0.5][q % 4];
    let one = |heading: usize| {
        let (di, dj) = ahead(heading, headings, length, drift);
        MoveFile { h: heading, di, dj, to_h: heading, cost: None, swept: swept((di, dj), bulge, 12) }
    };
    InformativeFile { name: format!("zigzag_{q}"), count, cost: 0.0, moves: (0..headings).map(one).collect() }
}

/// Boxes along a sine of amplitude `bulge` about the line to `(di, dj)` cells.
fn swept((di, dj): (i32, i32), bulge: f64, boxes: usize) -> Vec<[f64; 4]> {
    let (x, y) = (CELL * f64::from(di), CELL * f64::from(dj));
    let length = x.hypot(y).max(1.0);
    let place = |k: usize| {
        let share = k as f64 / boxes as f64;
        let side = bulge * (std::f64::consts::TAU * share).sin();
        (share * x - side * y / length, share * y + side * x / length)
    };
    let reach = HALF_LENGTH.hypot(HALF_WIDTH).min(HALF_LENGTH);
    let nearby = |k: usize| {
        let ((x0, y0), (x1, y1)) = (place(k), place(k + 1));
        let low = |a: f64, b: f64| (a.min(b) - reach).floor() + 0.95;
        let high = |a: f64, b: f64| (a.max(b) + reach).floor() + 0.05;
        [low(x0, x1), low(y0, y1), high(x0, x1), high(y0, y1)]
    };
    (0..boxes).map(nearby).collect()
}

fn forward(headings: usize) -> BasicFile {
    let one = |heading: usize| {
        let length = if headings > 8 { 2.2 } else { 1.0 };
        let (di, dj) = ahead(heading, headings, length, 0.0);
        MoveFile { h: heading, di, dj, to_h: heading, cost: None, swept: swept((di, dj), 0.0, 3) }
    };
    BasicFile { name: "forward".into(), cost: 1.0, moves: (0..headings).map(one).collect() }
}

fn turn(name: &str, headings: usize, by: usize) -> BasicFile {
    let one = |heading: usize| {
        let to_h = (heading + by) % headings;
        MoveFile { h: heading, di: 0, dj: 0, to_h, cost: None, swept: swept((0, 0), 0.0, 1) }
    };
    BasicFile { name: name.into(), cost: 1.0, moves: (0..headings).map(one).collect() }
}

/// A start low in the lattice with room for most of the map, and the highest goal in reach.
fn ends(file: &ProblemFile) -> Option<([usize; 3], [usize; 3])> {
    let mut basic = file.clone();
    basic.informative.clear();
    let LatticeFile { nx, ny, .. } = file.lattice;
    let mut best: Option<(usize, [usize; 3], [usize; 3])> = None;
    for k in 0..32 {
        basic.start = [(k * 7) % nx, k / 4 % ny, 0];
        let problem = basic.into_problem().ok()?;
        let reached = reached(&problem);
        let goal = reached.iter().max_by_key(|pose| (pose.j, pose.i, pose.layer))?;
        if best.as_ref().is_none_or(|best| reached.len() > best.0) {
            best = Some((reached.len(), basic.start, [goal.i, goal.j, goal.layer]));
        }
    }
    best.map(|(_, start, goal)| (start, goal))
}

/// The poses that any moves lead to from the start, which is one of them.
fn reached(problem: &Problem) -> HashSet<Pose> {
    let (mut reached, mut open) = (HashSet::from([problem.start()]), vec![problem.start()]);
    while let Some(from) = open.pop() {
        for (action, a) in problem.actions().iter().enumerate() {
            let own = a.moves.iter().enumerate().filter(|(_, m)| m.from == from.layer);
            for (_, m) in own.filter(|(index, _)| problem.is_allowed(from, MoveId { action, index: *index }))
            {
                let along = |from: usize, by: i32| (from as i64 + i64::from(by)) as usize;
                let end = Pose { i: along(from.i, m.di), j: along(from.j, m.dj), layer: m.to };
                if reached.insert(end) {
                    open.push(end);
                }
            }
        }
    }
    reached
}
