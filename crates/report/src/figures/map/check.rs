use std::fmt::Display;

use chart::{Invalid, Raster};

use super::input::{Area, Class, Frame, Graticule, Map, TrackStyle};

/// Beyond this no coordinate on Earth lies \[m\].
const FARTHEST: f64 = 1e9;
const LONGEST_SIDE: f64 = 1e8;
const SHORTEST_SIDE: f64 = 1e-2;
const MOST_ELONGATED: f64 = 20.0;
const MOST_LIMITS: usize = 12;

/// Refuses what could not be drawn truly.
pub(crate) fn check(map: &Map) -> Result<(), Invalid> {
    frame(&map.frame)?;
    limits(&map.depth_limits_m)?;
    cells(map)?;
    map.areas.iter().enumerate().try_for_each(|(index, each)| area(index, each))?;
    tracks(map)?;
    hulls(map)?;
    for (thing, end) in [("start", map.start), ("goal", map.goal)] {
        end.map_or(Ok(()), |at| points(thing, &[at]))?;
    }
    graticule(&map.graticule)
}

/// A map that could not be drawn truly because of `thing`.
fn refusal(thing: impl Display, found: impl Display, expected: &str, remedy: &str) -> Invalid {
    Invalid::new(format!("map: {thing}"), found.to_string(), expected, remedy)
}

fn frame(frame: &Frame) -> Result<(), Invalid> {
    let Frame { west, south, east, north } = *frame;
    points("frame", &[[west, south], [east, north]])?;
    let (width, height) = (east - west, north - south);
    let sides = SHORTEST_SIDE..=LONGEST_SIDE;
    let found = format!("{width} m × {height} m");
    if !(sides.contains(&width) && sides.contains(&height)) {
        let expected = "sides of 0.01 m to 100000 km, east above west and north above south";
        return Err(refusal("frame", found, expected, "correct the frame"));
    }
    if width.max(height) > MOST_ELONGATED * width.min(height) {
        let remedy = "widen the frame across its long side";
        return Err(refusal("frame", found, "sides within 20 to 1", remedy));
    }
    Ok(())
}

fn limits(limits: &[f64]) -> Result<(), Invalid> {
    let increasing = limits.windows(2).all(|pair| pair[0] < pair[1]);
    if increasing && limits.len() <= MOST_LIMITS && limits.iter().all(|limit| limit.is_finite()) {
        return Ok(());
    }
    let expected = "at most 12 finite depths, increasing";
    Err(refusal("depth limits", format!("{limits:?}"), expected, "correct the limits"))
}

fn cells(map: &Map) -> Result<(), Invalid> {
    if let Some(cells) = &map.cells {
        grid("cells", &cells.grid, cells.classes.len())?;
        let mut classes = cells.classes.iter().enumerate().filter_map(|(at, class)| Some((at, (*class)?)));
        classes.try_for_each(|(at, class)| depth(|| format!("depth of cell {at}"), class))?;
    }
    map.margins.iter().try_for_each(|margin| grid("margin", &margin.grid, margin.blocked.len()))
}

fn grid(thing: &str, grid: &Raster, cells: usize) -> Result<(), Invalid> {
    points(&format!("origin of {thing}"), &[grid.origin])?;
    if !(grid.cell_m > 0.0 && grid.cell_m <= FARTHEST) {
        let thing = format!("cell size of {thing}");
        return Err(refusal(thing, grid.cell_m, "metres above 0", "correct the cell size"));
    }
    if cells == 0 || grid.nx.checked_mul(grid.ny) != Some(cells) {
        let found = format!("{cells} values for {} × {}", grid.nx, grid.ny);
        return Err(refusal(thing, found, "one value per cell, at least one", "give nx · ny values"));
    }
    Ok(())
}

fn depth(thing: impl FnOnce() -> String, class: Class) -> Result<(), Invalid> {
    match class {
        Class::Depth { least_m } if !least_m.is_finite() => {
            Err(refusal(thing(), least_m, "a finite number", "leave out what is not charted"))
        }
        _ => Ok(()),
    }
}

fn area(index: usize, area: &Area) -> Result<(), Invalid> {
    depth(|| format!("depth of area {index}"), area.class)?;
    ring(&format!("ring of area {index}"), &area.ring)?;
    area.holes.iter().try_for_each(|hole| ring(&format!("hole of area {index}"), hole))
}

fn ring(thing: &str, ring: &[[f64; 2]]) -> Result<(), Invalid> {
    if ring.len() < 3 {
        let found = format!("{} points", ring.len());
        return Err(refusal(thing, found, "at least 3", "leave the ring out"));
    }
    points(thing, ring)
}

fn tracks(map: &Map) -> Result<(), Invalid> {
    for (index, track) in map.tracks.iter().enumerate() {
        points(&format!("track {index}"), &track.points)?;
        if let TrackStyle::Maneuver(k) = track.style
            && k >= map.maneuvers.len()
        {
            let thing = format!("maneuver of track {index}");
            let expected = format!("a number below {}", map.maneuvers.len());
            return Err(refusal(thing, k, &expected, "declare the maneuver"));
        }
    }
    Ok(())
}

fn hulls(map: &Map) -> Result<(), Invalid> {
    let mut hulls = map.hulls.iter().enumerate();
    hulls.try_for_each(|(index, hull)| ring(&format!("hull {index}"), hull))
}

fn graticule(graticule: &Graticule) -> Result<(), Invalid> {
    let mut labels = graticule.x.iter().chain(&graticule.y);
    labels.try_for_each(|(at, label)| points(&format!("graticule label {label:?}"), &[[*at, 0.0]]))
}

fn points(thing: &str, points: &[[f64; 2]]) -> Result<(), Invalid> {
    let valid = |value: &f64| value.abs() <= FARTHEST;
    match points.iter().position(|point| !point.iter().all(valid)) {
        None => Ok(()),
        Some(at) => {
            let [x, y] = points[at];
            let found = format!("({x}, {y}) at point {at}");
            Err(refusal(thing, found, "finite metres within ±1e9", "remove or split at such points"))
        }
    }
}
