//! Where legs end: trials planned from random starts, sailed by vessels and in currents that the plan does not know.
//!
//! `leg_ends CHART.geojson WEST SOUTH EAST NORTH STARTS [SEED]` plans the 60 m coaster of `fixtures/ships`, or with the chart
//! alone the study off Helsinki, and prints a row per start.

use std::path::{Path, PathBuf};
use std::time::Instant;

use chart::{Layer, LayerKind, PolygonLayer};
use lattice::Options;
use trial::voyage::{
    Area, Brief, CostRule, Goal, Hull, ManeuverUse, Place, Prepared, Primary, Safety, Search, Secondary, Task,
};
use trial::{Approach, Handling, Mode, Tolerance};
use vessel::{DictionaryFile, Generator, Run, Segment, Streams, Vessel};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let land = std::fs::read_to_string(&arguments[0])?;
    let layers = vec![Layer::Polygons(PolygonLayer::from_geojson(&land, &LayerKind::Land, None)?)];
    let number = |index: usize| arguments.get(index).map(|text| text.parse::<f64>()).transpose();
    let Some(west_deg) = number(1)? else { return plan("Helsinki", &mut helsinki(layers)?) };
    let [south_deg, east_deg, north_deg, starts] =
        [2, 3, 4, 5].map(|i| number(i).ok().flatten().unwrap_or(0.0));
    let area = Area { west_deg, south_deg, east_deg, north_deg };
    let seed = number(6)?.unwrap_or(1.0) as u64;
    let began = Instant::now();
    let prepared = Prepared::new(coaster(layers, area)?, &search())?;
    println!("{} legs rehearsed, {:.1} s", prepared.rehearsed.len(), began.elapsed().as_secs_f64());
    for dropped in &prepared.dropped {
        println!("no {} {:?} from layer {}: {}", dropped.name, dropped.side, dropped.from, dropped.why);
    }
    for own in prepared.rehearsed.iter().filter(|own| prepared.grid.level_and_mode(own.leg.from).0 < 2) {
        let (leg, s) = (&own.leg, own.seconds(1.0));
        println!(
            "{} {:?} {}: {} {} -> {}, {s} s, {:.0} m",
            own.name,
            leg.purpose.side(),
            leg.from,
            leg.di,
            leg.dj,
            leg.to,
            own.spread_m()
        );
    }
    let mut planned = 0;
    for draw in 0.. {
        if planned == starts as u32 {
            break;
        }
        let drawn = Streams::new(seed, "start").choices(draw, 0, 1 << 20, 3);
        let part = |i: usize| f64::from(drawn[i]) / f64::from(1 << 20);
        let mut own = prepared.clone();
        own.brief.task.start = Place {
            longitude_deg: west_deg + part(0) * (east_deg - west_deg),
            latitude_deg: south_deg + part(1) * (north_deg - south_deg),
            heading_deg: 360.0 * part(2),
            mode: None,
        };
        match tell(&format!("start {draw}"), &mut own) {
            Err(error) if error.to_string().starts_with("`start`") => {}
            Err(error) => {
                planned += 1;
                println!("start {draw}: refused: {error}");
            }
            Ok(()) => planned += 1,
        }
    }
    Ok(())
}

fn search() -> Search<'static> {
    Search { options: Options::default(), watch: &|| Box::new(|_| true), go_on: &|| true }
}

fn plan(name: &str, brief: &mut Brief) -> Result<(), Failure> {
    let began = Instant::now();
    let mut prepared = Prepared::new(brief.clone(), &search())?;
    println!("{} legs rehearsed, {:.1} s", prepared.rehearsed.len(), began.elapsed().as_secs_f64());
    for dropped in &prepared.dropped {
        println!("no {} {:?} from layer {}: {}", dropped.name, dropped.side, dropped.from, dropped.why);
    }
    for own in prepared.rehearsed.iter().filter(|own| prepared.grid.level_and_mode(own.leg.from).0 < 2) {
        let (leg, s) = (&own.leg, own.seconds(1.0));
        println!(
            "{} {:?} {}: {} {} -> {}, {s} s, {:.0} m",
            own.name,
            leg.purpose.side(),
            leg.from,
            leg.di,
            leg.dj,
            leg.to,
            own.spread_m()
        );
    }
    tell(name, &mut prepared)
}

/// Plans and tells what it comes to.
fn tell(name: &str, prepared: &mut Prepared) -> Result<(), Failure> {
    let began = Instant::now();
    let (solved, sailing) = prepared.plan(&search(), false)?;
    let check = &sailing.check;
    println!(
        "{name}: {} steps, cost {}, {:.0} s proved, {:.0} s sailed ({:+.2} %), tolerance used {:.2}, {} of {} ends astray, {} of {} aground, {} below, least {:.0} of {:.0} m, {} rounds, {:.1} s {}",
        sailing.legs.len(),
        solved.solution.cost.primary,
        check.proved_s,
        check.sailed_s,
        100.0 * (check.sailed_s / check.proved_s - 1.0),
        check.tolerance_used,
        check.ends_astray,
        check.ends,
        check.aground,
        check.runs,
        check.below_margin,
        check.clearance_quantiles_m[0],
        check.clearance_m,
        check.rounds,
        began.elapsed().as_secs_f64(),
        check.faults.join(", "),
    );
    Ok(())
}

fn folder(below: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(below)
}

/// Vessel and dictionary of a folder.
fn ship(below: &str) -> Result<(Vessel, Vec<Run>), Failure> {
    let text = |name: &str| std::fs::read_to_string(folder(below).join(name));
    let vessel = Vessel::from_file(toml::from_str(&text("vessel.toml")?)?)?;
    let dictionary: DictionaryFile = toml::from_str(&text("dictionary.toml")?)?;
    let generator = Generator::without_tables(&vessel, &dictionary)?;
    let run = |q: usize| {
        let samples = generator.samples(q)?;
        let realized = generator.realize(q, samples)?;
        let segments = vec![Segment { maneuver: generator.maneuvers()[q].name.clone(), start: 0 }];
        let measured = realized.initial.repeat(samples + 1);
        let (exogenous, initial) = (vessel.model.undisturbed(&realized.inputs), realized.initial);
        Ok(Run { design: "dictionary".to_owned(), run: q as i32, segments, exogenous, measured, initial })
    };
    let runs = (0..generator.maneuvers().len()).map(run).collect::<Result<_, vessel::Invalid>>()?;
    Ok((vessel, runs))
}

fn counted(counts: &[(&str, u32)]) -> Vec<ManeuverUse> {
    let own = |(name, count): &(&str, u32)| ManeuverUse {
        name: (*name).to_owned(),
        count: Some(*count),
        piece_s: None,
    };
    counts.iter().map(own).collect()
}

fn mode(name: &str, speed_m_s: f64) -> Mode {
    Mode { name: name.to_owned(), speed_m_s }
}

fn coaster(layers: Vec<Layer>, area: Area) -> Result<Brief, Failure> {
    let (vessel, dictionary) = ship("fixtures/ships/coaster60")?;
    let task = Task {
        area,
        cell_m: 250.0,
        headings: 8,
        raster_per_cell: 4,
        uncharted: None,
        hull: Hull { length_m: 60.0, beam_m: 11.0, reference_m: 0.0 },
        safety: Safety {
            transit_depth_m: 0.0,
            trial_depth_m: 0.0,
            margin_m: 150.0,
            unknown_current_m_s: 0.15,
            parameter_error: 0.15,
            runs: Some(256),
            vessels: None,
            aground_probability: None,
        },
        known_current_m_s: [0.0; 2],
        handling: Handling {
            turn_rate_rad_s: 0.012,
            crawl_m_s: 0.5,
            acceleration_m_s2: 0.02,
            response_s: 40.0,
            lookahead_m: 160.0,
        },
        approach: Approach {
            run_in_s: 30.0,
            tolerance: Tolerance {
                distance_m: 25.0,
                heading_rad: 6_f64.to_radians(),
                surge_m_s: 0.1,
                sway_m_s: 0.25,
                yaw_rate_rad_s: 0.0018,
            },
        },
        modes: vec![mode("slow", 2.5), mode("fast", 4.0)],
        maneuvers: counted(&[("zig-zag-fast", 2), ("zig-zag-slow", 2), ("circle", 1), ("crash-slow", 1)]),
        informative_s: None,
        start: Place { longitude_deg: 0.0, latitude_deg: 0.0, heading_deg: 0.0, mode: None },
        goal: Goal::Home {},
        cost: CostRule { primary: Primary::Seconds, secondary: Secondary::Turns },
    };
    Ok(Brief { vessel, task, layers, dictionary, design: None, seed: 1 })
}

fn helsinki(layers: Vec<Layer>) -> Result<Brief, Failure> {
    let (vessel, dictionary) = ship("pipelines/helsinki")?;
    let place = |longitude_deg, latitude_deg, heading_deg| Place {
        longitude_deg,
        latitude_deg,
        heading_deg,
        mode: None,
    };
    let task = Task {
        area: Area { west_deg: 24.905, south_deg: 60.105, east_deg: 25.035, north_deg: 60.170 },
        cell_m: 120.0,
        headings: 8,
        raster_per_cell: 4,
        uncharted: None,
        hull: Hull { length_m: 30.0, beam_m: 8.0, reference_m: 0.0 },
        safety: Safety {
            transit_depth_m: 0.0,
            trial_depth_m: 0.0,
            margin_m: 50.0,
            unknown_current_m_s: 0.15,
            parameter_error: 0.35,
            runs: Some(1536),
            vessels: Some(24),
            aground_probability: None,
        },
        known_current_m_s: [0.0; 2],
        handling: Handling {
            turn_rate_rad_s: 0.05,
            crawl_m_s: 0.5,
            acceleration_m_s2: 0.05,
            response_s: 30.0,
            lookahead_m: 60.0,
        },
        approach: Approach {
            run_in_s: 30.0,
            tolerance: Tolerance {
                distance_m: 12.0,
                heading_rad: 6_f64.to_radians(),
                surge_m_s: 0.1,
                sway_m_s: 0.25,
                yaw_rate_rad_s: 0.0075,
            },
        },
        modes: vec![mode("half", 1.5), mode("full", 3.0)],
        maneuvers: counted(&[("zig-zag-steep", 3), ("zig-zag-wide", 3), ("sway-zig-zag", 3)]),
        informative_s: None,
        start: place(24.9530, 60.1486, 135.0),
        goal: Goal::Places { places: vec![place(24.985, 60.112, 180.0)] },
        cost: CostRule { primary: Primary::BasicMoves, secondary: Secondary::Seconds },
    };
    Ok(Brief { vessel, task, layers, dictionary, design: None, seed: 1 })
}
