//! A made-up archipelago with a planned trial of nine maneuvers, of the size of the paper's.

use report::figures::map::{
    Cells, ChartedArea, Class, Frame, Graticule, Map, Margin, PlottedTrack, Purpose, Raster, TrackStyle,
};

const GRID: Raster = Raster { origin: [0.0, 0.0], cell_m: 25.0, nx: 176, ny: 140 };
const TURNS: [[f64; 2]; 10] = [
    [500.0, 500.0],
    [1500.0, 420.0],
    [2450.0, 560.0],
    [3600.0, 480.0],
    [3900.0, 1400.0],
    [3500.0, 2300.0],
    [2500.0, 2500.0],
    [1500.0, 2300.0],
    [1300.0, 1500.0],
    [400.0, 1350.0],
];
const ISLANDS: [([f64; 2], f64); 11] = [
    ([900.0, 950.0], 170.0),
    ([1950.0, 1000.0], 300.0),
    ([2950.0, 1050.0], 240.0),
    ([2300.0, 1750.0], 330.0),
    ([3150.0, 1700.0], 190.0),
    ([600.0, 2100.0], 330.0),
    ([700.0, 3050.0], 400.0),
    ([2000.0, 3100.0], 230.0),
    ([3300.0, 3050.0], 310.0),
    ([4200.0, 2700.0], 220.0),
    ([4330.0, 700.0], 180.0),
];

/// Distance of an island's shore from its centre in direction `angle`.
fn shore(island: usize, angle: f64) -> f64 {
    let phase = island as f64 * 1.7;
    let wobble =
        0.22 * (2.0 * angle + phase).sin() + 0.12 * (5.0 * angle - phase).sin() + 0.05 * (13.0 * angle).cos();
    ISLANDS[island].1 * (1.0 + wobble)
}

/// Approximate distance of a point from the nearest shore; negative on land.
fn from_shore([x, y]: [f64; 2]) -> f64 {
    let off = |k: usize| {
        let [cx, cy] = ISLANDS[k].0;
        (x - cx).hypot(y - cy) - shore(k, (y - cy).atan2(x - cx))
    };
    (0..ISLANDS.len()).map(off).fold(f64::MAX, f64::min)
}

fn per_cell<T>(value: impl Fn(f64) -> T) -> Vec<T> {
    let centre = |cell: usize, origin: f64| origin + (cell as f64 + 0.5) * GRID.cell_m;
    let cells = (0..GRID.nx * GRID.ny).map(|cell| [centre(cell % GRID.nx, 0.0), centre(cell / GRID.nx, 0.0)]);
    cells.map(|at| value(from_shore(at))).collect()
}

fn islands() -> Vec<ChartedArea> {
    let around = |k: usize, size: f64| {
        let ring = (0..240).map(|step| std::f64::consts::TAU * f64::from(step) / 240.0);
        let [x, y] = ISLANDS[k].0;
        ring.map(|a| [x + size * shore(k, a) * a.cos(), y + size * shore(k, a) * a.sin()]).collect::<Vec<_>>()
    };
    let lake = |k: usize| if k == 6 { vec![around(k, 0.3)] } else { Vec::new() };
    let land =
        (0..ISLANDS.len()).map(|k| ChartedArea { class: Class::Land, ring: around(k, 1.0), holes: lake(k) });
    let no_go = vec![[3050.0, 2760.0], [3020.0, 3300.0], [2280.0, 3250.0], [2330.0, 2710.0]];
    land.chain([ChartedArea { class: Class::NoGo, ring: no_go, holes: Vec::new() }]).collect()
}

/// Points from `from` to `to`, oscillating by `swing` metres `times` times in between.
fn swinging(from: [f64; 2], to: [f64; 2], swing: f64, times: f64) -> Vec<[f64; 2]> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    let at = |share: f64| {
        let off = swing * (std::f64::consts::TAU * times * share).sin();
        [from[0] + share * dx - off * dy / length, from[1] + share * dy + off * dx / length]
    };
    (0..=120).map(|k| at(f64::from(k) / 120.0)).collect()
}

fn along(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
}

/// A turn at corner `at` as a quadratic curve.
fn turn(from: [f64; 2], at: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
    let point = |t: f64| along(along(from, at, t), along(at, to, t), t);
    (0..=20).map(|k| point(f64::from(k) / 20.0)).collect()
}

fn plan() -> Vec<PlottedTrack> {
    const SWINGS: [(f64, f64); 3] = [(45.0, 4.0), (110.0, 2.0), (70.0, 1.0)];
    let track = |style, points, number| PlottedTrack { style, points, number };
    let mut tracks = Vec::new();
    for (leg, pair) in TURNS.windows(2).enumerate() {
        let (from, to) = (pair[0], pair[1]);
        let entry = along(from, to, 0.16);
        let begin = along(from, to, 0.28);
        let end = along(from, to, 0.84);
        let (swing, times) = SWINGS[leg * 2 % 3];
        if leg == 0 {
            tracks.push(track(TrackStyle::Basic, vec![from, entry], None));
        }
        tracks.push(track(TrackStyle::RunIn, vec![entry, begin], None));
        let number = u64::try_from(leg + 1).ok();
        tracks.push(track(TrackStyle::Maneuver(leg * 2 % 3), swinging(begin, end, swing, times), number));
        let next =
            TURNS.get(leg + 2).map_or_else(|| vec![end, to], |next| turn(end, to, along(to, *next, 0.16)));
        tracks.push(track(TrackStyle::Basic, next, None));
    }
    tracks
}

fn drifting(path: &[[f64; 2]], drift: f64, phase: f64) -> Vec<[f64; 2]> {
    let off = |k: usize| drift * (k as f64 / 250.0 + phase).sin() * (k as f64 / 600.0).min(1.0);
    path.iter().enumerate().map(|(k, [x, y])| [x + off(k), y + off(k + 150)]).collect()
}

fn hull(at: [f64; 2], next: [f64; 2]) -> Vec<[f64; 2]> {
    let (dx, dy) = (next[0] - at[0], next[1] - at[1]);
    let (c, s) = (dx / dx.hypot(dy), dy / dx.hypot(dy));
    let outline = [[-75.0, -15.0], [45.0, -15.0], [75.0, 0.0], [45.0, 15.0], [-75.0, 15.0]];
    outline.iter().map(|[f, p]| [at[0] + c * f - s * p, at[1] + s * f + c * p]).collect()
}

fn graticule() -> Graticule {
    let x = (0..5).map(|k| (330.0 + 925.0 * f64::from(k), format!("24°{:02}′E", 51 + k)));
    let y = (0..4).map(|k| (280.0 + 928.5 * f64::from(k), format!("60°{:04.1}′N", 4.0 + 0.5 * f64::from(k))));
    Graticule { x: x.collect(), y: y.collect() }
}

/// The whole map: everything that a map can show.
pub fn archipelago() -> Map {
    let tracks = plan();
    let whole: Vec<[f64; 2]> = tracks.iter().flat_map(|track| track.points.clone()).collect();
    let sheaf = (0..250).map(|run| PlottedTrack {
        style: TrackStyle::Realization,
        points: drifting(&whole, 8.0 + f64::from(run) / 5.0, f64::from(run) * 2.4),
        number: None,
    });
    let poses = tracks.iter().filter(|track| matches!(track.style, TrackStyle::Maneuver(_)));
    let hulls = poses.flat_map(|track| [60].map(|k| hull(track.points[k], track.points[k + 1]))).collect();
    let depth = |off: f64| (off > -40.0).then_some(Class::Depth { least_m: off / 11.0 });
    let name = |name: &str| (name.to_owned(), 3);
    Map {
        title: "Planned trial in an archipelago".to_owned(),
        description: "Nine maneuvers between eleven islands; the trial ends near where it began.".to_owned(),
        frame: Frame { west: 0.0, south: 0.0, east: 4400.0, north: 3500.0 },
        depth_limits_m: vec![5.0, 10.0, 20.0],
        cells: Some(Cells { grid: GRID, classes: per_cell(depth) }),
        areas: islands(),
        margins: vec![
            Margin {
                purpose: Purpose::Trial,
                grid: GRID,
                blocked: per_cell(|off| (40.0..100.0).contains(&off)),
            },
            Margin {
                purpose: Purpose::Transit,
                grid: GRID,
                blocked: per_cell(|off| (-30.0..40.0).contains(&off)),
            },
        ],
        maneuvers: vec![
            name("steep zig-zag, surge"),
            name("wide zig-zag, sway"),
            name("wide zig-zag, surge"),
        ],
        start: Some(TURNS[0]),
        goal: Some(TURNS[9]),
        tracks: sheaf.chain(tracks).collect(),
        hulls,
        graticule: graticule(),
        ..Map::default()
    }
}
