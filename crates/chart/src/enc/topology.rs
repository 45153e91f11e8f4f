//! From nodes and edges to geometries.

use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, VecDeque};

use crate::enc::dataset::Parameters;
use crate::enc::record::{EDGE, Name, Object, Pointer, Vector};
use crate::enc::{Feature, Geometry, Invalid, QUAPOS};

const AGAINST: u8 = 2;
const NEITHER: u8 = 255;
const INSIDE: u8 = 2;
const BEGINNING: u8 = 1;
const END: u8 = 2;
/// Edges of rings that may be tested for each allowed place.
const MOST_TESTED: usize = 64;

/// Nodes and edges of a cell.
pub(crate) struct Topology<'a> {
    vectors: &'a BTreeMap<Name, Vector>,
    parameters: Parameters,
    most_places: u64,
    /// The remaining places.
    left: Cell<u64>,
}

/// Places and ends of all nodes and edges, as stored.
pub(crate) fn stored(vectors: &BTreeMap<Name, Vector>) -> u64 {
    vectors.values().map(|vector| (1 + vector.points.items.len() + vector.ends.items.len()) as u64).sum()
}

impl<'a> Topology<'a> {
    /// For objects with at most `most_places` places, counted as often as they are used.
    pub(crate) fn new(vectors: &'a BTreeMap<Name, Vector>, parameters: Parameters, most_places: u64) -> Self {
        Self { vectors, parameters, most_places, left: Cell::new(most_places) }
    }
}

impl Topology<'_> {
    /// Counts places before they are created.
    fn count(&self, places: usize, feature: &Feature) -> Result<(), Invalid> {
        let Some(left) = self.left.get().checked_sub(places as u64) else {
            let excess = format!("objects of more than {} places up to it", self.most_places);
            let expected = format!(
                "a cell of at most {} places, each counted as often as objects use it",
                self.most_places
            );
            let remedy = "allow more memory, or report the cell to its producer";
            return Err(Invalid::new(feature.named(), excess, expected, remedy));
        };
        self.left.set(left);
        Ok(())
    }

    /// An object with its geometry.
    pub(crate) fn feature(&self, object: &Object) -> Result<Feature, Invalid> {
        let (producer, number, part) = object.id;
        let mut feature = Feature {
            class: object.class,
            id: format!("{producer}-{number}-{part}"),
            attributes: object.attributes.clone(),
            geometry: Geometry::None,
            position_quality: Vec::new(),
        };
        let pointers = &object.pointers.items;
        feature.position_quality = self.quality(pointers, &feature)?;
        feature.geometry = match object.primitive {
            1 => self.points(pointers, &feature)?,
            2 => Geometry::Lines(self.degrees(runs(self.edges(pointers, &feature)?))),
            3 => self.area(pointers, &feature)?,
            _ => Geometry::None,
        };
        Ok(feature)
    }

    fn vector(&self, name: Name, feature: &Feature) -> Result<&Vector, Invalid> {
        self.vectors.get(&name).ok_or_else(|| {
            Invalid::new(
                feature.named(),
                format!("vector record {}-{}, which the cell lacks", name.0, name.1),
                "nodes and edges of the cell",
                "take base cell and updates of one edition, as their producer issued them",
            )
        })
    }

    /// The stated quality of the positions of an object's nodes and edges.
    fn quality(&self, pointers: &[Pointer], feature: &Feature) -> Result<Vec<u8>, Invalid> {
        let mut all = Vec::new();
        for pointer in pointers {
            let quality = self.vector(pointer.name, feature)?.attributes.get(&QUAPOS.0);
            all.extend(quality.and_then(|text| text.trim().parse::<u8>().ok()));
        }
        all.sort_unstable();
        all.dedup();
        Ok(all)
    }

    /// Points; those with a depth as soundings.
    fn points(&self, pointers: &[Pointer], feature: &Feature) -> Result<Geometry, Invalid> {
        let mut places = Vec::new();
        for pointer in pointers {
            let items = &self.vector(pointer.name, feature)?.points.items;
            self.count(items.len(), feature)?;
            places.extend(items);
        }
        let degree = |[lat, lon, _]: [i32; 3]| self.degree([lon, lat]);
        if feature.class != crate::enc::class("SOUNDG").unwrap_or_default() {
            return Ok(Geometry::Points(places.into_iter().map(degree).collect()));
        }
        let sounding = |place: [i32; 3]| {
            let [lon, lat] = degree(place);
            [lon, lat, f64::from(place[2]) / self.parameters.per_metre]
        };
        Ok(Geometry::Soundings(places.into_iter().map(sounding).collect()))
    }

    fn area(&self, pointers: &[Pointer], feature: &Feature) -> Result<Geometry, Invalid> {
        let (inside, outside): (Vec<Pointer>, Vec<Pointer>) =
            pointers.iter().partition(|p| p.usage == INSIDE);
        let (outside, inside) = (self.edges(&outside, feature)?, self.edges(&inside, feature)?);
        let closed = |edges: Vec<EdgeRun>| {
            rings(edges).map_err(|[lon, lat]| {
                let [lon, lat] = self.degree([lon, lat]);
                let boundary = format!("a boundary that ends at {lon}, {lat}");
                let remedy = "take base cell and updates of one edition, as their producer issued them";
                Invalid::new(feature.named(), boundary, "closed rings", remedy)
            })
        };
        let count = |looked_at: usize| self.count(looked_at / MOST_TESTED, feature);
        let polygons = polygons(closed(outside)?, closed(inside)?, count)?;
        Ok(Geometry::Area(polygons.into_iter().map(|rings| self.degrees(rings)).collect()))
    }

    /// The edges that pointers refer to, in their direction.
    fn edges(&self, pointers: &[Pointer], feature: &Feature) -> Result<Vec<EdgeRun>, Invalid> {
        pointers.iter().map(|pointer| self.edge(pointer, feature)).collect()
    }

    fn edge(&self, pointer: &Pointer, feature: &Feature) -> Result<EdgeRun, Invalid> {
        let edge = self.vector(pointer.name, feature)?;
        if edge.name.0 != EDGE {
            let node = format!("node {}-{}", edge.name.0, edge.name.1);
            return Err(Invalid::new(feature.named(), node, "edges", "report it to the chart's producer"));
        }
        self.count(edge.points.items.len() + edge.ends.items.len(), feature)?;
        let end = |topology: u8| -> Result<Option<Place>, Invalid> {
            let Some(pointer) = edge.ends.items.iter().find(|p| p.topology == topology) else {
                return Ok(None);
            };
            let node = self.vector(pointer.name, feature)?;
            Ok(node.points.items.first().map(|[lat, lon, _]| [*lon, *lat]))
        };
        let between = edge.points.items.iter().map(|[lat, lon, _]| [*lon, *lat]);
        let (first, last) = (end(BEGINNING)?, end(END)?);
        let mut places: Vec<Place> = first.into_iter().chain(between).chain(last).collect();
        if places.len() < 2 {
            let short = format!("edge {}-{} of {} places", edge.name.0, edge.name.1, places.len());
            return Err(Invalid::new(
                feature.named(),
                short,
                "at least two",
                "report it to the chart's producer",
            ));
        }
        if pointer.orientation == AGAINST {
            places.reverse();
        }
        Ok(EdgeRun { places, either_way: pointer.orientation == NEITHER })
    }

    fn degrees(&self, lines: Vec<Vec<Place>>) -> Vec<Vec<[f64; 2]>> {
        lines.into_iter().map(|line| line.into_iter().map(|place| self.degree(place)).collect()).collect()
    }

    fn degree(&self, place: Place) -> [f64; 2] {
        place.map(|units| f64::from(units) / self.parameters.per_degree)
    }
}

/// A place in the cell's units: longitude, latitude.
pub(crate) type Place = [i32; 2];

/// An edge in its direction.
struct EdgeRun {
    pub places: Vec<Place>,
    /// Whether it may also be traversed backwards.
    pub either_way: bool,
}

/// Outer and inner rings of a polygon, or lines.
pub(crate) type Rings = Vec<Vec<Place>>;

/// Edges as lines: consecutive ones are joined.
fn runs(edges: Vec<EdgeRun>) -> Rings {
    let mut lines: Rings = Vec::new();
    for edge in edges {
        match lines.last_mut() {
            Some(line) if line.last() == edge.places.first() => line.extend(&edge.places[1..]),
            _ => lines.push(edge.places),
        }
    }
    lines
}

/// Polygons with these outer and inner rings. Almost all have one outer ring. `count` is called with the
/// number of edges to be tested next, and may refuse.
fn polygons<E>(
    outside: Rings,
    inside: Rings,
    count: impl Fn(usize) -> Result<(), E>,
) -> Result<Vec<Rings>, E> {
    let mut polygons: Vec<Rings> = outside.into_iter().map(|ring| vec![ring]).collect();
    for hole in inside {
        let mut outer = 0;
        if polygons.len() > 1 {
            for (k, polygon) in polygons.iter().enumerate() {
                if holds(&polygon[0], &hole, &count)? {
                    outer = k;
                    break;
                }
            }
        }
        if let Some(polygon) = polygons.get_mut(outer) {
            polygon.push(hole);
        }
    }
    Ok(polygons)
}

/// Whether a ring contains another one that does not cross it: by the first place that is not on it.
fn holds<E>(ring: &[Place], hole: &[Place], count: impl Fn(usize) -> Result<(), E>) -> Result<bool, E> {
    for place in hole {
        count(ring.len())?;
        match side(ring, *place) {
            Side::On => {}
            side => return Ok(side == Side::Within),
        }
    }
    Ok(true)
}

/// Edges as rings: each continues with the first remaining edge that follows.
fn rings(edges: Vec<EdgeRun>) -> Result<Rings, Place> {
    let mut ends = Ends::of(&edges);
    let mut left: Vec<Option<EdgeRun>> = edges.into_iter().map(Some).collect();
    let mut rings = Vec::new();
    for first in 0..left.len() {
        let Some(EdgeRun { places: mut ring, .. }) = left[first].take() else { continue };
        while ring.first() != ring.last() {
            let [.., end] = ring[..] else { break };
            let next = ends.next_at(end, &left).and_then(|k| left[k].take()).ok_or(end)?;
            let mut places = next.places;
            if places.first() != Some(&end) {
                places.reverse();
            }
            ring.extend(&places[1..]);
        }
        rings.push(ring);
    }
    Ok(rings)
}

/// The edges that may be traversed from a place, in order.
struct Ends(HashMap<Place, VecDeque<usize>>);

impl Ends {
    fn of(edges: &[EdgeRun]) -> Self {
        let mut ends: HashMap<Place, VecDeque<usize>> = HashMap::new();
        for (k, edge) in edges.iter().enumerate() {
            let back = edge.places.last().filter(|_| edge.either_way);
            edge.places
                .first()
                .into_iter()
                .chain(back)
                .for_each(|end| ends.entry(*end).or_default().push_back(k));
        }
        Self(ends)
    }

    /// The first remaining edge that may be traversed from `end`.
    fn next_at(&mut self, end: Place, left: &[Option<EdgeRun>]) -> Option<usize> {
        let edges = self.0.get_mut(&end)?;
        while let Some(k) = edges.pop_front() {
            if left[k].is_some() {
                return Some(k);
            }
        }
        None
    }
}

/// The position of a place relative to a ring.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Within,
    On,
    Beyond,
}

/// On which side of a ring a place lies.
fn side(ring: &[Place], [x, y]: Place) -> Side {
    let wide = |v: i32| i64::from(v);
    let mut inside = false;
    for pair in ring.windows(2) {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        // Exact: differences of 32-bit numbers have 33 bits, their products 66.
        let across = i128::from(wide(x1) - wide(x0)) * i128::from(wide(y) - wide(y0))
            - i128::from(wide(x) - wide(x0)) * i128::from(wide(y1) - wide(y0));
        let within = x0.min(x1) <= x && x <= x0.max(x1) && y0.min(y1) <= y && y <= y0.max(y1);
        if across == 0 && within {
            return Side::On;
        }
        if (y0 > y) != (y1 > y) && ((across < 0) == (y1 > y0)) {
            inside = !inside;
        }
    }
    if inside { Side::Within } else { Side::Beyond }
}
