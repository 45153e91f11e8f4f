//! The `plan.toml` of a new study: its chart, and where the trial begins on it.

use std::path::Path;

use chart::{Bounds, Chart, Class, Distances, Layer, Plane, Raster};
use files::{Error, Provenance, budget};
use study::plan::{ChartsError, Means, PlanFile, read_charts};

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
///
/// # Errors
/// A chart that cannot be read; a place off the earth, or where there is no water with the template's depth and margin.
pub(super) fn planned(
    charted: &Charted,
    name: &str,
    (template, side_m): (&str, f64),
) -> Result<String, Error> {
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
    let found = format!("The place in the area that is farthest from dangers and the edge: {clear_m:.0} m.");
    Ok(filled(&bounds, start, &found))
}

/// The keys of an area.
fn area(plane: &Plane, bounds: &Bounds) -> String {
    let [(west, south), (east, north)] = [bounds.min, bounds.max].map(|own| plane.to_geographic(own));
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
    let best =
        nodes.map(|node| (room(node), node)).reduce(|best, own| if own.0 > best.0 { own } else { best });
    let (clear_m, node) = best.unwrap_or((0.0, [0.0; 2]));
    let (longitude, latitude) = plane.to_geographic(node);
    Ok((bounds, [longitude, latitude], clear_m, extent))
}

/// West, south, east and north end \[deg\].
type Extent = [f64; 4];

/// The extent of all that is charted; `None` of nothing, or across the antimeridian.
fn extent(layers: &[Layer]) -> Option<Extent> {
    let places = layers.iter().flat_map(|layer| match layer {
        Layer::Polygons(own) => {
            own.areas.iter().flat_map(|area| area.rings.iter().flatten().copied()).collect()
        }
        Layer::Grid(own) => {
            let [x, y] = [own.columns, own.rows].map(|count| count as f64 * own.cell);
            let corners = [[0.0, 0.0], [x, 0.0], [0.0, y], [x, y]];
            let corners =
                corners.map(|[x, y]| own.crs.to_geographic([own.corner[0] + x, own.corner[1] + y]).ok());
            corners.into_iter().flatten().map(<[f64; 2]>::from).collect::<Vec<_>>()
        }
    });
    let wider = |[w, s, e, n]: Extent, [x, y]: [f64; 2]| [w.min(x), s.min(y), e.max(x), n.max(y)];
    let extent = places.map(|[x, y]| [x, y, x, y]).reduce(|own, [x, y, ..]| wider(own, [x, y]))?;
    (extent[2] - extent[0] < 180.0).then_some(extent)
}

/// The part of `bounds` within the extent of the polygons: a chart of land knows nothing beyond it, and the planner takes that for
/// water. Grids, and charts with depths, know how far they go.
fn on_chart(plane: &Plane, bounds: &Bounds, layers: &[Layer]) -> Option<Bounds> {
    let areas = layers.iter().filter_map(|layer| match layer {
        Layer::Polygons(own) => Some(&own.areas),
        Layer::Grid(_) => None,
    });
    let areas: Vec<_> = areas.flatten().collect();
    if areas.is_empty() || areas.iter().any(|area| matches!(area.class, Class::Depth { .. })) {
        return Some(*bounds);
    }
    let corners: Vec<[f64; 2]> = areas
        .iter()
        .flat_map(|own| own.rings.iter().flatten())
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
