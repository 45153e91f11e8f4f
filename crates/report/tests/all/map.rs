//! The map is correct about classes, lengths and positions, and refuses what it cannot draw.

use crate::archipelago::archipelago;
use crate::drawing::{attribute, check, corners, doubled_area, elements, frame};
use report::figures::map::{
    Cells, ChartedArea, Class, Contour, Frame, Map, Margin, PlottedTrack, Purpose, Raster, Spot, Symbol,
    TrackStyle, Tube, parted,
};
use report::figures::map_figure;

const LAND: &str = "fill=\"#e2c59c\"";

fn drawn(map: &Map) -> String {
    let svg = map_figure(map).unwrap();
    check(&svg);
    svg
}

fn square(low: f64, high: f64) -> Vec<[f64; 2]> {
    vec![[low, low], [high, low], [high, high], [low, high]]
}

fn land(ring: Vec<[f64; 2]>, holes: Vec<Vec<[f64; 2]>>) -> ChartedArea {
    ChartedArea { class: Class::Land, ring, holes }
}

fn track(style: TrackStyle, points: Vec<[f64; 2]>, number: Option<u64>) -> PlottedTrack {
    PlottedTrack { style, points, number }
}

/// The path of land on the map, which comes before the legend.
fn land_path(svg: &str) -> &str {
    elements(svg, "path").find(|path| path.contains(LAND)).unwrap()
}

#[test]
fn every_class_of_the_archipelago_is_in_the_legend() {
    let svg = drawn(&archipelago());
    std::fs::write(concat!(env!("CARGO_TARGET_TMPDIR"), "/map.svg"), &svg).unwrap();
    for label in [
        "steep zig-zag, surge × 3",
        "wide zig-zag, sway × 3",
        "wide zig-zag, surge × 3",
        "basic move",
        "run-in",
        "Monte Carlo, 200 of 250",
        "hull",
        "start",
        "goal",
        "land",
        "no-go",
        "safety margin, transit",
        "safety margin, trial",
        "least depth below 5 m",
        "least depth 5–10 m",
        "least depth 10–20 m",
        "least depth 20 m and more",
        "water, no depth charted",
        "24°53′E",
        "60°04.5′N",
    ] {
        assert!(svg.contains(&format!(">{label}</text>")), "{label}");
    }
    assert!(svg.contains("<title>Planned trial in an archipelago</title>\n<desc>Nine maneuvers"));
    assert!(svg.contains("<title>7: steep zig-zag, surge</title>"));
    assert_eq!(svg, map_figure(&archipelago()).unwrap());
}

#[test]
fn a_class_that_is_absent_is_not_in_the_legend() {
    let map = Map { uncharted: true, ..Map::default() };
    let svg = drawn(&map);
    for label in ["land", "no-go", "margin", "depth", "hull", "start", "goal", "Maneuvers", "Track"] {
        assert!(!svg.contains(label), "{label}");
    }
    assert!(svg.contains(">not charted</text>"));
}

#[test]
fn law_the_scale_bar_is_as_long_as_it_says_on_both_axes() {
    for width in [0.7, 37.0, 950.0, 4400.0, 12_345.0, 1e6] {
        for aspect in [0.1, 0.75, 5.0] {
            let east = 1e4 + width;
            let map = Map {
                frame: Frame { west: 1e4, south: -5.0, east, north: width * aspect - 5.0 },
                ..Map::default()
            };
            let svg = drawn(&map);
            let [_, _, wide, high] = frame(&svg);
            let bar = svg.split("<title>scale: ").nth(1).unwrap();
            let (label, bar) = bar.split_once("</title>").unwrap();
            let (number, unit) = label.split_once(' ').unwrap();
            let said: f64 = number.parse::<f64>().unwrap() * if unit == "km" { 1000.0 } else { 1.0 };
            let length = attribute(elements(bar, "rect").next().unwrap(), "width") as f64;
            let metres = length * width / wide as f64;
            assert!((metres / said - 1.0).abs() < 2.0 / length + 1.0 / wide as f64, "{label}, {metres} m");
            assert!((high as f64 / wide as f64 - aspect).abs() < 0.01 * aspect, "{width} × {aspect}");
            assert!((0.1..0.5).contains(&(length / wide as f64)), "{label} of {width} m");
        }
    }
}

#[test]
fn a_frame_that_cannot_be_drawn_truly_is_refused() {
    let wrong = [
        Frame { east: f64::INFINITY, ..Frame::default() },
        Frame { east: -1.0, ..Frame::default() },
        Frame { north: 1e7, ..Frame::default() },
    ];
    for frame in wrong {
        let message = map_figure(&Map { frame, ..Map::default() }).unwrap_err().to_string();
        assert!(message.starts_with("map: frame: found ") && !message.contains('\n'), "{message}");
        assert!(message.contains(", expected ") && message.contains("; "), "{message}");
    }
}

#[test]
fn texts_may_hold_anything() {
    let text = "a <b> & \"c\" \u{1}\u{FFFE} ]]>";
    let mut map = Map {
        title: text.to_owned(),
        description: text.to_owned(),
        maneuvers: vec![(text.to_owned(), 1)],
        tracks: vec![track(TrackStyle::Maneuver(0), vec![[100.0, 100.0], [300.0, 100.0]], Some(1))],
        ..Map::default()
    };
    map.graticule.x.push((500.0, text.to_owned()));
    assert!(drawn(&map).contains("a &lt;b&gt; &amp; &quot;c&quot;"));
}

#[test]
fn law_what_lies_outside_the_frame_is_cut_at_it() {
    let wild: Vec<[f64; 2]> =
        (0..400).map(f64::from).map(|k| [5e3 * (k * 1.3).sin(), 3e3 * (k * 0.7).cos()]).collect();
    let grid = Raster { origin: [-333.0, -777.0], cell_m: 217.0, nx: 9, ny: 11 };
    let stripes = |n: usize| (0..99).map(move |cell| cell % n == 0);
    let depths = stripes(2).map(|land| Some(if land { Class::Land } else { Class::NoGo })).collect();
    let map = Map {
        areas: vec![land(wild.clone(), vec![]), land(square(-1e8, 1e8), vec![square(1e7, 2e7)])],
        cells: Some(Cells { grid, classes: depths }),
        margins: vec![
            Margin { purpose: Purpose::Trial, grid, blocked: stripes(3).collect() },
            Margin { purpose: Purpose::Transit, grid, blocked: stripes(5).collect() },
        ],
        tracks: vec![
            track(TrackStyle::Basic, wild.clone(), Some(1)),
            track(TrackStyle::Realization, wild, None),
        ],
        hulls: vec![square(900.0, 1100.0)],
        start: Some([2000.0, 0.0]),
        ..Map::default()
    };
    let svg = drawn(&map);
    let [x, y, wide, high] = frame(&svg);
    let drawing = &svg[..svg.find("<title>scale: ").unwrap()];
    let ticks_apart = elements(drawing, "path").flat_map(corners).flatten();
    for (cx, cy) in ticks_apart {
        assert!((x..=x + wide).contains(&cx) && (y..=y + high).contains(&cy), "({cx}, {cy})");
    }
    assert!(!drawing.contains("<title>start"));
}

#[test]
fn law_land_has_its_area_whatever_the_direction_of_its_rings() {
    let reversed = |mut ring: Vec<[f64; 2]>| {
        ring.reverse();
        ring
    };
    let closed = |mut ring: Vec<[f64; 2]>| {
        ring.push(ring[0]);
        ring
    };
    let (outer, hole) = (square(100.0, 900.0), square(300.0, 500.0));
    for (outer, hole) in [
        (outer.clone(), hole.clone()),
        (reversed(outer.clone()), hole.clone()),
        (outer.clone(), closed(reversed(hole.clone()))),
        (closed(reversed(outer)), reversed(hole)),
    ] {
        let svg = drawn(&Map { areas: vec![land(outer, vec![hole])], ..Map::default() });
        let side = frame(&svg)[2] as f64;
        let share = 0.5 * doubled_area(&corners(land_path(&svg))) as f64 / side.powi(2);
        assert!((share.abs() - 0.60).abs() < 1e-3, "{share}");
    }
}

#[test]
fn law_cells_of_land_have_their_area() {
    let grid = Raster { origin: [50.0, 50.0], cell_m: 30.0, nx: 30, ny: 30 };
    let class = |cell: usize| match cell * cell % 7 {
        0 | 1 => Some(Class::Land),
        2 => Some(Class::Depth { least_m: (cell % 30) as f64 }),
        _ => None,
    };
    let classes: Vec<_> = (0..900).map(class).collect();
    let count = classes.iter().filter(|class| **class == Some(Class::Land)).count() as f64;
    let map = Map {
        cells: Some(Cells { grid, classes: classes.clone() }),
        depth_limits_m: vec![-1.0, 4.5, 20.0],
        ..Map::default()
    };
    let svg = drawn(&map);
    let scale = frame(&svg)[2] as f64 / 1000.0;
    let area = 0.5 * doubled_area(&corners(land_path(&svg))) as f64 / scale.powi(2);
    assert!((area.abs() / (count * 900.0) - 1.0).abs() < 0.01, "{area} m², {count} cells");
    // Every border between land and something else has one line.
    let land = |i: i32, j: i32| {
        (0..30).contains(&i) && (0..30).contains(&j) && classes[(j * 30 + i) as usize] == Some(Class::Land)
    };
    let sides = (0..=30).flat_map(|j| (0..=30).map(move |i| (i, j)));
    let borders =
        sides.map(|(i, j)| i32::from(land(i, j) != land(i - 1, j)) + i32::from(land(i, j) != land(i, j - 1)));
    let expected = f64::from(30 * borders.sum::<i32>());
    let along = |ring: &Vec<(i64, i64)>| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| (a.0 - b.0).abs() + (a.1 - b.1).abs()).sum::<i64>()
    };
    let length = corners(land_path(&svg)).iter().map(along).sum::<i64>() as f64 / scale;
    assert!((length / expected - 1.0).abs() < 0.01, "{length} m of {expected} m");
    for label in ["least depth −1–4.5 m", "least depth 4.5–20 m", "least depth 20 m and more"] {
        assert!(svg.contains(label), "{label}");
    }
    assert!(!svg.contains("least depth below"));
}

#[test]
fn a_large_raster_stays_small_even_where_it_is_noise() {
    let grid = Raster { origin: [0.0, 0.0], cell_m: 10.0, nx: 600, ny: 600 };
    let depth = |cell: usize| {
        let (x, y) = ((cell % 600) as f64, (cell / 600) as f64);
        20.0 + 15.0 * (x / 31.0).sin() * (y / 23.0).cos() + 8.0 * (x / 7.0 + y / 5.0).sin()
    };
    let noise = |cell: usize| (cell.wrapping_mul(2_654_435_761) >> 7) as f64 % 40.0;
    for (name, value, most) in
        [("smooth", &depth as &dyn Fn(usize) -> f64, 600_000), ("noise", &noise, 1_000_000)]
    {
        let class = |cell| match value(cell) {
            least_m if least_m < 3.0 => Class::Land,
            least_m => Class::Depth { least_m },
        };
        let blocked: Vec<bool> = (0..360_000).map(|cell| (3.0..8.0).contains(&value(cell))).collect();
        let margin = |purpose| Margin { purpose, grid, blocked: blocked.clone() };
        let map = Map {
            frame: Frame { west: 0.0, south: 0.0, east: 6000.0, north: 6000.0 },
            cells: Some(Cells { grid, classes: (0..360_000).map(|cell| Some(class(cell))).collect() }),
            margins: vec![margin(Purpose::Transit), margin(Purpose::Trial)],
            depth_limits_m: vec![5.0, 10.0, 20.0],
            ..Map::default()
        };
        let svg = drawn(&map);
        assert!(svg.len() < most, "{name}: {} bytes", svg.len());
    }
}

#[test]
fn more_maneuvers_than_colours_look_different() {
    let maneuvers = (0..15).map(|k| (format!("m{k}."), k)).collect();
    let svg = drawn(&Map { maneuvers, ..Map::default() });
    let legend = svg.split(">Maneuvers</text>").nth(1).unwrap();
    let entries: Vec<&str> = legend.split("</text>").take(15).collect();
    let looks = entries.iter().map(|entry| {
        let strokes = elements(entry, "path").map(|path| path.split(" stroke=\"").nth(1).unwrap());
        strokes.map(str::trim).collect::<Vec<_>>().join(";")
    });
    let mut looks: Vec<String> = looks.collect();
    looks.sort_unstable();
    looks.dedup();
    assert_eq!(looks.len(), 15);
    assert!(entries.iter().enumerate().all(|(k, entry)| entry.ends_with(&format!(">m{k}. × {k}"))));
}

#[test]
fn numbers_of_steps_do_not_cover_each_other() {
    let mut map = archipelago();
    for number in 10..16 {
        let points = vec![[2000.0, 500.0], [2100.0, 600.0 + number as f64]];
        map.tracks.push(track(TrackStyle::Maneuver(0), points, Some(number)));
    }
    let svg = drawn(&map);
    let map_only = &svg[..svg.find("<title>scale: ").unwrap()];
    let radius = 80;
    let discs: Vec<(i64, i64)> = elements(map_only, "circle")
        .filter(|tag| attribute(tag, "r") == radius && tag.contains("#ffffff\" stroke=\""))
        .map(|tag| (attribute(tag, "cx"), attribute(tag, "cy")))
        .collect();
    assert_eq!(discs.len(), 15);
    for (k, a) in discs.iter().enumerate() {
        for b in &discs[k + 1..] {
            assert!((a.0 - b.0).pow(2) + (a.1 - b.1).pow(2) >= (2 * radius).pow(2), "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_trial_that_ends_at_home_shows_both_marks() {
    let svg = drawn(&Map { start: Some([500.0, 500.0]), goal: Some([500.0, 500.0]), ..Map::default() });
    let goal = svg.find("<title>goal</title>").unwrap();
    let start = svg.find("<title>start</title>").unwrap();
    assert!(goal < start, "the smaller disc lies above");
}

#[test]
fn labels_that_would_run_into_each_other_are_left_out() {
    let mut map = Map::default();
    map.graticule.x = (0..100).map(|k| (10.0 * f64::from(k), format!("24°{k:02}′E"))).collect();
    map.graticule.y = vec![(-1.0, "south of it".to_owned()), (500.0, "60°N".to_owned())];
    let svg = drawn(&map);
    let labels = svg.matches("′E</text>").count();
    assert!((4..12).contains(&labels), "{labels}");
    assert!(svg.contains("60°N") && !svg.contains("south of it"));
}

#[test]
fn charted_points_names_and_what_was_swept_are_drawn_where_there_is_room() {
    let spot = |x: f64, symbol, depth_m: Option<f64>| Spot {
        at: [x, 500.0],
        symbol,
        depth_m,
        title: "WRECKS <Anna>".to_owned(),
    };
    let spots = vec![
        spot(300.0, Symbol::Sounding, Some(12.37)),
        spot(302.0, Symbol::Sounding, Some(4.0)),
        spot(600.0, Symbol::Sounding, Some(44.9)),
        spot(800.0, Symbol::Danger, None),
        spot(2000.0, Symbol::Danger, Some(1.0)),
    ];
    let grid = Raster { origin: [0.0, 0.0], cell_m: 100.0, nx: 10, ny: 10 };
    let swept = (0..100).map(|k| k % 10 == 4).collect();
    let along = |k: u32| [300.0 + 20.0 * f64::from(k), 300.0 + 5.0 * f64::from(k % 2)];
    let contour = |depth_m, corners| Contour { depth_m, line: (0..corners).map(along).collect() };
    let contours = vec![contour(Some(7.0), 20), contour(Some(2.0), 4), contour(None, 20)];
    let names = vec![([500.0, 800.0], "Träholm".to_owned()), ([505.0, 800.0], "Smaller".to_owned())];
    let svg = drawn(&Map {
        spots,
        contours,
        names,
        tube: Some(Tube { grid, swept, vessels: 64 }),
        corridors: vec![vec![[100.0, 100.0], [900.0, 100.0], [900.0, 150.0], [100.0, 150.0]]],
        ..Map::default()
    });
    let map = &parted(&svg).unwrap()[0];
    // The shoaler of two that are too close, whole metres for great depths, nothing outside of the frame.
    for (text, times) in
        [("4", 1), ("12.3", 0), ("44", 1), ("1", 0), ("Träholm", 1), ("Smaller", 0), ("7", 1), ("2", 0)]
    {
        assert_eq!(map.matches(&format!(">{text}</text>")).count(), times, "{text}");
    }
    assert_eq!(map.matches("<title>WRECKS &lt;Anna&gt;</title>").count(), 1);
    for label in [
        "swept by 64 vessels",
        "corridor (XTD)",
        "sounding [m]",
        "depth contour [m]",
        "danger, depth over it [m]",
    ] {
        assert!(svg.contains(&format!(">{label}</text>")), "{label}");
    }
}

/// Fill of the legend's chip of a label.
fn chip<'a>(svg: &'a str, label: &str) -> &'a str {
    let before = &svg[..svg.find(&format!(">{label}</text>")).unwrap()];
    let chip = before.rsplit("<rect ").next().unwrap();
    chip.split("fill=\"").nth(1).unwrap().split('"').next().unwrap()
}

#[test]
fn the_shoalest_is_drawn_last_in_the_colour_of_its_label() {
    let depths = [30.0, 1.0, 7.0];
    let class = |least_m| Class::Depth { least_m };
    let grid = Raster { origin: [100.0, 100.0], cell_m: 100.0, nx: 3, ny: 1 };
    let cells = Cells { grid, classes: depths.iter().map(|&depth| Some(class(depth))).collect() };
    let area = |depth| ChartedArea { class: class(depth), ring: square(100.0, 400.0), holes: vec![] };
    let limits = vec![5.0, 10.0];
    let base = Map { depth_limits_m: limits, ..Map::default() };
    for map in [
        Map { cells: Some(cells), ..base.clone() },
        Map { areas: depths.into_iter().map(area).collect(), ..base },
    ] {
        let svg = drawn(&map);
        let shades = ["least depth 10 m and more", "least depth 5–10 m", "least depth below 5 m"]
            .map(|label| chip(&svg, label));
        let drawing = &svg[..svg.find("<title>scale: ").unwrap()];
        let fills = elements(drawing, "path").map(|path| path.split("fill=\"").nth(1).unwrap());
        let order: Vec<&str> = fills.map(|fill| fill.split('"').next().unwrap()).collect();
        assert_eq!(order[..3], shades);
    }
}

#[test]
fn a_shoal_cell_is_drawn_where_it_lies() {
    let classes = [30.0, 1.0, 7.0].map(|least_m| Some(Class::Depth { least_m })).to_vec();
    let grid = Raster { origin: [100.0, 100.0], cell_m: 100.0, nx: 3, ny: 1 };
    let cells = Some(Cells { grid, classes });
    let svg = drawn(&Map { cells, depth_limits_m: vec![5.0, 10.0], ..Map::default() });
    let [left, _, wide, _] = frame(&svg);
    let shoal = format!("fill=\"{}\"", chip(&svg, "least depth below 5 m"));
    let path = elements(&svg, "path").find(|path| path.contains(&shoal)).unwrap();
    let columns: Vec<i64> = corners(path).into_iter().flatten().map(|(x, _)| x).collect();
    let metres = |x: &i64| (x - left) as f64 * 1000.0 / wide as f64;
    let ends = (columns.iter().min().map(metres).unwrap(), columns.iter().max().map(metres).unwrap());
    assert!((ends.0 - 200.0).abs() < 0.5 && (ends.1 - 300.0).abs() < 0.5, "{ends:?}");
}

#[test]
fn a_block_of_cells_with_a_hole_has_two_rings_of_four_corners() {
    let grid = Raster { origin: [100.0, 100.0], cell_m: 100.0, nx: 3, ny: 3 };
    let classes = (0..9).map(|cell| (cell != 4).then_some(Class::Land)).collect();
    let svg = drawn(&Map { cells: Some(Cells { grid, classes }), ..Map::default() });
    let rings = corners(land_path(&svg));
    assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
}

#[test]
fn law_a_ring_that_leaves_the_frame_has_its_area_inside() {
    let diamond = vec![[500.0, -500.0], [1500.0, 500.0], [500.0, 1500.0], [-500.0, 500.0]];
    let corner = vec![[-100.0, -100.0], [300.0, -100.0], [-100.0, 300.0]];
    for (ring, expected) in [(diamond, 1.0), (corner, 0.02)] {
        let svg = drawn(&Map { areas: vec![land(ring, vec![])], ..Map::default() });
        let side = frame(&svg)[2] as f64;
        let share = 0.5 * doubled_area(&corners(land_path(&svg))) as f64 / side.powi(2);
        assert!((share.abs() - expected).abs() < 1e-4, "{share}");
    }
    let beyond = land(vec![[2000.0, 0.0], [3000.0, 0.0], [2000.0, 90.0]], vec![]);
    let svg = drawn(&Map { areas: vec![beyond], ..Map::default() });
    let drawing = &svg[..svg.find("<title>scale: ").unwrap()];
    assert!(!elements(drawing, "path").any(|path| path.contains(LAND)));
}

/// The lines of the only track of a map.
fn lines(points: Vec<[f64; 2]>) -> (Vec<Vec<(i64, i64)>>, [i64; 4]) {
    let svg = drawn(&Map { tracks: vec![track(TrackStyle::Basic, points, None)], ..Map::default() });
    let drawing = &svg[..svg.find("<title>scale: ").unwrap()];
    (elements(drawing, "path").last().map(corners).unwrap_or_default(), frame(&svg))
}

#[test]
fn a_track_that_leaves_and_returns_has_two_parts() {
    let track = [[100.0, 100.0], [100.0, 1500.0], [900.0, 1500.0], [900.0, 500.0], [800.0, 500.0]];
    let (parts, _) = lines(track.to_vec());
    assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [2, 3]);
}

#[test]
fn law_a_track_is_drawn_with_few_points_and_near_all_of_its_own() {
    let wave: Vec<[f64; 2]> =
        (0..2000).map(|i| f64::from(i) / 2.0).map(|x| [x, 500.0 + 30.0 * (x / 30.0).sin()]).collect();
    let (parts, [left, top, wide, high]) = lines(wave.clone());
    assert!(parts.len() == 1 && parts[0].len() < 400, "{} points", parts[0].len());
    let scale = wide as f64 / 1000.0;
    for [x, y] in wave {
        let (x, y) = (left as f64 + scale * x, (top + high) as f64 - scale * y);
        let off = |pair: &[(i64, i64)]| {
            let [a, b] = [pair[0], pair[1]].map(|(x, y)| (x as f64, y as f64));
            let along = (b.0 - a.0, b.1 - a.1);
            let share = ((x - a.0) * along.0 + (y - a.1) * along.1) / along.0.hypot(along.1).powi(2);
            let share = share.clamp(0.0, 1.0);
            (x - a.0 - share * along.0).hypot(y - a.1 - share * along.1)
        };
        // A tolerance of 0.06 pixels, and places rounded to a tenth of a pixel.
        let least = parts[0].windows(2).map(off).fold(f64::MAX, f64::min);
        assert!(least <= 0.6 + 0.8, "{least} tenths of a pixel");
    }
}
