//! A new study: the hand-written files that it begins with, from a ship that is known, and from logs.

mod bags;
mod ingest;
mod looking;
mod presets;
mod unknown;

use std::path::Path;

use crate::pipeline::StudySettings;
use chart::{Bounds, Chart, Class, Distances, Layer, Plane, Raster};
use files::{Error, Provenance, budget};
use presets::with_schema;
use study::files::file_name;
use study::plan::{ChartsError, Means, PlanFile, read_charts};

pub use looking::{LogGuess, Looked};
pub use presets::{NewFile, PRESETS, Preset, of_ship};

/// The files of the study `name` of `preset` that is simulated, and with a chart planned on it.
///
/// # Errors
/// A ship that sails on no chart; a chart that cannot be read, or has no water for the trial.
pub fn simulated(preset: &Preset, name: &str, charted: Option<&Charted>) -> Result<Vec<NewFile>, Error> {
    let owned = |(name, text): (&str, &str)| (name.to_owned(), text.to_owned());
    let mut files: Vec<NewFile> = preset.files().map(owned).collect();
    if let Some(charted) = charted {
        let template = preset.plan().map_err(|why| Error::invalid(charted.file, why))?;
        files.push(("plan.toml".to_owned(), planned(charted, name, template)?));
    }
    Ok(files.into_iter().map(with_schema).collect())
}

/// The files of a study of `preset` with the logs in the folder `logs`, and what was found there: unless `quiet`, the terminal is
/// asked what may be several. On a chart its next trial is planned. Of a ship of which nothing else is known the terms are usual ones.
///
/// # Errors
/// A folder without logs, or with those of several ships; a log whose columns cannot be read; a chart as of [`simulated`].
pub fn measured(
    preset: Option<&Preset>,
    logs: &Path,
    charted: Option<&Charted>,
    quiet: bool,
) -> Result<(Vec<NewFile>, Looked), Error> {
    let needed = preset.map_or_else(unknown::needed, |preset| vec![preset.needed()]);
    let mut looked = Looked::at(logs, &needed, quiet)?;
    looked.ask(quiet);
    let unknown;
    let preset = match preset {
        Some(preset) => preset,
        None => {
            unknown = unknown::ship(&looked);
            &unknown
        }
    };
    let is_wind_logged = looked.take_wind();
    let mut files = vec![
        ("vessel.toml".to_owned(), preset.without_truth(is_wind_logged)),
        ("ingest.toml".to_owned(), ingest::written(&looked, preset)),
        ("study.toml".to_owned(), ingest::settings(&looked, preset)),
    ];
    files.extend(trial(preset, charted)?);
    Ok((files.into_iter().map(with_schema).collect(), looked))
}

/// The JSON Schemas of all hand-written files, which editors check them by.
pub fn schemas() -> Vec<NewFile> {
    let all = study::files::schemas().into_iter().chain([("study", StudySettings::schema())]);
    let file = |kind| format!("schemas/{}", file_name(kind));
    all.map(|(kind, schema)| (file(kind), format!("{schema:#}\n"))).collect()
}

/// Its maneuvers and its sea, in the folder `next`: a ship with forces sails the preset's maneuvers, of another the maneuvers are drawn
/// that inputs and motions of the logs allow.
fn trial(preset: &Preset, charted: Option<&Charted>) -> Result<Vec<(String, String)>, Error> {
    let plan = charted.map(|charted| preset.plan().map_err(|why| Error::invalid(charted.file, why)));
    let plan = plan.transpose()?;
    if preset.dictionary.is_empty() {
        return Ok(Vec::new());
    }
    let maneuvers = match preset.is_of_forces() {
        true => preset.dictionary.to_string(),
        false => drawn(&preset.dictionary, plan.map_or("", |(template, _)| template)),
    };
    let campaign = preset.campaign.to_string();
    let mut files = vec![("next/dictionary.toml", maneuvers), ("next/campaign.toml", campaign)];
    if let (Some(charted), Some((template, side_m))) = (charted, plan) {
        let by_shares = without_maneuvers(template, &preset.campaign);
        let template = if preset.is_of_forces() { template } else { &by_shares };
        files.push(("next/plan.toml", planned(charted, "next", (template, side_m))?));
    }
    Ok(files.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
}

/// `template` with maneuvers by the design's shares, for a trial as long as that of `campaign`.
fn without_maneuvers(template: &str, campaign: &str) -> String {
    let length = campaign.lines().find_map(|line| line.strip_prefix("duration_s = "));
    let length = length.and_then(|value| value.split_whitespace().next()).unwrap_or("600.0");
    let Some((before, (_, after))) = template
        .split_once("maneuver = [\n")
        .and_then(|(before, rest)| Some((before, rest.split_once("]\n")?)))
    else {
        return template.to_owned();
    };
    format!("{before}informative_s = {length}\n{after}")
}

/// Candidates within the speeds and as long as the maneuvers of `dictionary`, which begin at the speeds of `plan`, if it has some.
fn drawn(dictionary: &str, plan: &str) -> String {
    let numbers = |text: &str, key: &str| {
        let number = |line: &str| {
            line.strip_prefix(key)?.trim_start().strip_prefix('=')?.split('#').next()?.trim().parse().ok()
        };
        text.lines().filter_map(number).collect::<Vec<f64>>()
    };
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let modes = numbers(plan.split_once("[[speed_mode]]").map_or("", |(_, modes)| modes), "speed_m_s");
    let speeds = ["speed_m_s", "from_m_s", "to_m_s"].into_iter().flat_map(|key| numbers(dictionary, key));
    let speeds: Vec<f64> = speeds.chain(modes.iter().copied()).collect();
    let (speed, duration_s) = (largest(&speeds), largest(&numbers(dictionary, "duration_s")).max(1.0));
    let slow = speeds.into_iter().filter(|speed| *speed > 0.0).fold(speed, f64::min).min(0.8 * speed);
    let start = if modes.is_empty() { String::new() } else { format!("start_m_s = {modes:?}\n") };
    format!(
        "# What the helmsman may be asked for in the next trial: motions that are drawn, of which those stay that the inputs can hold within\n\
         # what was logged. Speeds [m/s], periods [s]; limits are wide, as the logs limit them.\n\
         duration_s = {duration_s}\n\n\
         [generate]\n\
         candidates = 200\n\
         kinds = [\"zig-zag\", \"accelerate\", \"decelerate\", \"steady-turn\", \"spiral\", \"pseudo-random-binary\", \"combined\"]\n\
         speed_m_s = [{slow}, {speed}]\n{start}\
         period_s = [{}, {}]\n\n\
         [generate.limits]\n\
         u_m_s = {}\nv_m_s = {speed}\nr_rad_s = 1.0\n",
        0.1 * duration_s,
        0.5 * duration_s,
        2.0 * speed
    )
}

/// Cell of the raster that the start is looked for on \[m\].
const CELL_M: f64 = 25.0;

/// The chart of a new study.
#[derive(Clone, Copy, Debug)]
pub struct Charted<'a> {
    /// A chart, or the folder of an exchange set.
    pub file: &'a Path,
    /// Longitude and latitude of the trial \[deg\].
    pub place: [f64; 2],
    /// When it may take place, from and until: it departs at the beginning.
    pub slot: Option<&'a [String; 2]>,
}

/// `plan.toml` from a preset's `template`, for the study `name` in an area of `side_m` on a side.
fn planned(charted: &Charted, name: &str, (template, side_m): (&str, f64)) -> Result<String, Error> {
    let Charted { file, place: [longitude, latitude], slot } = *charted;
    let at =
        |why| Error::refuse(file, "--place", format!("{longitude},{latitude}"), why, "name another place");
    let whole = file.canonicalize().map_err(|_| {
        Error::refuse(file, "--chart", "no such file", "a chart, or the folder of an exchange set", "name it")
    })?;
    let plane =
        Plane::new(longitude, latitude).map_err(|_| at("a longitude, then a latitude, in degrees"))?;
    let edge = side_m / 2.0;
    let square = Bounds::new([-edge, -edge], [edge, edge]).map_err(|why| Error::invalid(file, why))?;
    let (template, in_slot) = match slot {
        None => (template.to_owned(), String::new()),
        Some([from, until]) => {
            let departs = format!("departure = \"{from}\"\ncell_m");
            let slot = format!(
                "\n# When the trial may take place.\n[slot]\nfrom = \"{from}\"\nuntil = \"{until}\"\n"
            );
            (template.replacen("cell_m", &departs, 1), slot)
        }
    };
    let name = if refusal::check_name("name", name).is_ok() { name } else { "trial" };
    let filled = |bounds: &Bounds, [longitude, latitude]: [f64; 2], found: &str| {
        let start =
            format!("longitude_deg = {longitude:.5}\nlatitude_deg = {latitude:.5}\nheading_deg = 0.0");
        template
            .replace("\"{name}\"", &toml::Value::from(name).to_string())
            .replace("{area}", &area(&plane, bounds))
            .replace("{charts}", &charts(&whole))
            .replace("{found}", found)
            .replace("{start}", &start)
            + &in_slot
    };
    // The file is read as the stages read it, with the place as its start.
    let draft = filled(&square, charted.place, "");
    let config: PlanFile = toml::from_str(&draft).map_err(|why| {
        let expected = "a path that plan.toml can have";
        Error::refuse(file, "--chart", why.message(), expected, "rename the chart or its folder")
    })?;
    let (bounds, start, clear_m, extent) = roomiest(file, &config, &plane, &square)?;
    let is_on = |[x, y]: [f64; 2]| {
        extent.is_none_or(|[west, south, east, north]| {
            (west..=east).contains(&x) && (south..=north).contains(&y)
        })
    };
    let needed_m = config.safety.margin_m + config.hull.length_m;
    if clear_m < needed_m {
        if let Some([west, south, east, north]) = extent.filter(|_| !is_on(charted.place)) {
            let place = format!("{longitude},{latitude}");
            let expected = format!(
                "a place on the chart: longitude {west:.3} to {east:.3}, latitude {south:.3} to {north:.3}"
            );
            let remedy = match is_on([latitude, longitude]) {
                true => format!("exchange them: --place {latitude},{longitude}"),
                false => "name a place on it, or another chart".to_owned(),
            };
            return Err(Error::refuse(file, "--place", place, expected, remedy));
        }
        let depth_m = config.safety.trial_depth_m;
        return Err(at(&format!(
            "water on the chart within {edge:.0} m that is {depth_m} m deep and {needed_m:.0} m from dangers; at most \
             {clear_m:.0} m are"
        )));
    }
    let about = format!("The place in the area that is farthest from dangers and the edge: {clear_m:.0} m.");
    Ok(filled(&bounds, start, &about))
}

/// The keys of an area.
fn area(plane: &Plane, bounds: &Bounds) -> String {
    let [(west, south), (east, north)] = [bounds.min, bounds.max].map(|corner| plane.to_geographic(corner));
    format!("west_deg = {west:.4}\nsouth_deg = {south:.4}\neast_deg = {east:.4}\nnorth_deg = {north:.4}")
}

/// The part of the square `bounds` that is on the chart, the place with most room for maneuvers there (longitude, latitude),
/// its distance to dangers and the edge \[m\], and the extent of the chart.
fn roomiest(
    file: &Path,
    config: &PlanFile,
    plane: &Plane,
    bounds: &Bounds,
) -> Result<(Bounds, [f64; 2], f64, Option<Extent>), Error> {
    let invalid = |why| Error::invalid(file, why);
    let means = Means { area: (plane, bounds), budget: budget(), keep_going: &|| true };
    // Only the chart is read: the path of `plan.toml` does not matter.
    let charts = read_charts(file, config, &means, &mut Provenance::default()).map_err(|why| match why {
        ChartsError::Refused(error) => error,
        ChartsError::OutOfTime => unreachable!("there is no time limit"),
    })?;
    let extent = extent(&charts.layers);
    let Some(bounds) = on_chart(plane, bounds, &charts.layers) else {
        return Ok((*bounds, [0.0; 2], 0.0, extent));
    };
    let chart = Chart::new(*plane, bounds, &charts.layers, config.uncharted).map_err(invalid)?;
    let raster = Raster::covering(&bounds, CELL_M).map_err(invalid)?;
    let limits = [config.safety.trial_depth_m, bounds.max[0] - bounds.min[0]];
    let Some(distances) = Distances::new(&chart, raster, limits, &|| true).map_err(invalid)? else {
        unreachable!("there is no time limit")
    };
    let nodes = (0..raster.ny).flat_map(|row| (0..raster.nx).map(move |col| raster.node(col, row)));
    let room = |[x, y]: [f64; 2]| {
        let edge = [x - bounds.min[0], bounds.max[0] - x, y - bounds.min[1], bounds.max[1] - y];
        edge.into_iter().fold(distances.distance_m(x, y), f64::min)
    };
    let best = nodes
        .map(|node| (room(node), node))
        .reduce(|best, other| if other.0 > best.0 { other } else { best });
    let (clear_m, node) = best.unwrap_or((0.0, [0.0; 2]));
    let (longitude, latitude) = plane.to_geographic(node);
    Ok((bounds, [longitude, latitude], clear_m, extent))
}

/// West, south, east and north end \[deg\].
type Extent = [f64; 4];

/// The extent of all that is charted; `None` of nothing, or across the antimeridian.
fn extent(layers: &[Layer]) -> Option<Extent> {
    let places = layers.iter().flat_map(|layer| match layer {
        Layer::Polygons(polygons) => {
            polygons.areas.iter().flat_map(|area| area.rings.iter().flatten().copied()).collect()
        }
        Layer::Grid(grid) => {
            let [x, y] = [grid.columns, grid.rows].map(|count| count as f64 * grid.cell);
            let corners = [[0.0, 0.0], [x, 0.0], [0.0, y], [x, y]];
            let corners =
                corners.map(|[x, y]| grid.crs.to_geographic([grid.corner[0] + x, grid.corner[1] + y]).ok());
            corners.into_iter().flatten().map(<[f64; 2]>::from).collect::<Vec<_>>()
        }
    });
    let wider = |[w, s, e, n]: Extent, [x, y]: [f64; 2]| [w.min(x), s.min(y), e.max(x), n.max(y)];
    let extent = places.map(|[x, y]| [x, y, x, y]).reduce(|extent, [x, y, ..]| wider(extent, [x, y]))?;
    (extent[2] - extent[0] < 180.0).then_some(extent)
}

/// The part of `bounds` within the extent of the polygons: a chart of land knows nothing beyond it, and the planner takes that for
/// water. Grids, and charts with depths, know how far they go.
fn on_chart(plane: &Plane, bounds: &Bounds, layers: &[Layer]) -> Option<Bounds> {
    let areas = layers.iter().filter_map(|layer| match layer {
        Layer::Polygons(polygons) => Some(&polygons.areas),
        Layer::Grid(_) => None,
    });
    let areas: Vec<_> = areas.flatten().collect();
    if areas.is_empty() || areas.iter().any(|area| matches!(area.class, Class::Depth { .. })) {
        return Some(*bounds);
    }
    let corners: Vec<[f64; 2]> = areas
        .iter()
        .flat_map(|area| area.rings.iter().flatten())
        .map(|[longitude, latitude]| plane.to_plane(*longitude, *latitude))
        .collect();
    let extent = Bounds::enclosing(&corners)?;
    let inner =
        |pick: fn(f64, f64) -> f64, one: [f64; 2], two: [f64; 2]| [0, 1].map(|k| pick(one[k], two[k]));
    Bounds::new(inner(f64::max, bounds.min, extent.min), inner(f64::min, bounds.max, extent.max)).ok()
}

/// The `[[chart]]` groups of a file, by its ending and its words.
fn charts(file: &Path) -> String {
    let path = toml::Value::from(file.display().to_string());
    let one = |keys: &str| format!("[[chart]]\nfile = {path}{keys}");
    let name = file.file_name().map_or(String::new(), |name| name.to_string_lossy().to_lowercase());
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    let kind = |kind: &str| {
        one(&format!("\nkind = \"{kind}\"     # guessed: land, no-go, danger, depth, elevation or objects"))
    };
    match ending {
        _ if file.is_dir() => one(""),
        "000" | "031" => one(""),
        "geojson" | "json" => match files::read_to_string(file).unwrap_or_default() {
            text if text.contains("\"OBJL\"") => kind("objects"),
            // As other programs write the classes of objects.
            text if text.contains("\"objl\"") && text.contains("\"DEPARE\"") => {
                let of = |kind_of: &str, classes: &str| {
                    let only = format!("only = {{ property = \"objl\", values = [{classes}] }}");
                    format!("{}\n{only}", kind(kind_of))
                };
                let land = "\"LNDARE\", \"PONTON\", \"HULKES\"";
                format!("{}\n\n{}", of("depth", "\"DEPARE\", \"DRGARE\""), of("land", land))
            }
            text if text.contains("\"DRVAL1\"") => kind("depth"),
            _ => kind("land"),
        },
        _ if ["land", "mask", "shore"].iter().any(|word| name.contains(word)) => kind("land"),
        _ if ["elev", "dem", "topo", "gebco"].iter().any(|word| name.contains(word)) => kind("elevation"),
        _ => kind("depth"),
    }
}
