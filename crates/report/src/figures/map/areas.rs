use std::ops::RangeBounds;

use crate::figures::map::input::{
    self, Cells, ChartedArea, Class, Contour, Frame, Map, Margin, PlottedTrack, Purpose, Raster, TrackStyle,
    Tube,
};
use crate::figures::map::view::{self, View, simplified};
use crate::figures::svg::{Look, Path, Point, Sheet};

/// Tolerance of a border \[px\].
const TOLERANCE: f64 = 0.08;

/// Number of shades of depth.
pub(crate) fn bands(limits: &[f64]) -> usize {
    limits.len() + 1
}

/// Shade of a least depth, 0 for the shoalest.
pub(crate) fn band(least_m: f64, limits: &[f64]) -> usize {
    limits.iter().filter(|&&limit| least_m >= limit).count()
}

/// Draws charted water, one path per shade, the shoaler above the deeper.
pub(crate) fn water(sheet: &mut Sheet, view: &View, map: &Map) {
    let limits = &map.depth_limits_m;
    let bands = bands(limits);
    for shade in (0..bands).rev() {
        let shaded = |class| matches!(class, Class::Depth { least_m } if band(least_m, limits) == shade);
        class(sheet, view, map, shaded, input::depth(shade, bands));
    }
}

/// Draws forbidden water, and land above it.
pub(crate) fn obstacles(sheet: &mut Sheet, view: &View, map: &Map) {
    class(sheet, view, map, |class| class == Class::NoGo, input::NO_GO);
    class(sheet, view, map, |class| class == Class::Land, input::LAND);
}

fn class(sheet: &mut Sheet, view: &View, map: &Map, is_shown: impl Fn(Class) -> bool, look: Look) {
    let mut path = Path::default();
    map.areas.iter().filter(|area| is_shown(area.class)).for_each(|area| add(&mut path, view, area));
    sheet.path(&path, look);
}

/// Adds an area, outer ring counter-clockwise and holes clockwise, so that overlapping areas do not cancel.
fn add(path: &mut Path, view: &View, area: &ChartedArea) {
    path.ring(&border(view, &area.ring, true));
    area.holes.iter().for_each(|hole| path.ring(&border(view, hole, false)));
}

fn border(view: &View, ring: &[[f64; 2]], outer: bool) -> Vec<Point> {
    let mut ring = view.placed(ring);
    if (doubled_area(&ring) < 0.0) != outer {
        ring.reverse();
    }
    let mut inside = view::ring(view, &ring);
    inside.extend(inside.first().copied());
    simplified(&inside, TOLERANCE)
}

/// Positive if the ring runs clockwise on the sheet.
fn doubled_area(ring: &[Point]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum()
}

/// Cells finer than this many pixels are merged.
const FINEST: f64 = 0.7;

/// Ranks of the cells that lie in the frame: 0 for nothing, the greater the more dangerous.
#[derive(Clone, Debug)]
struct Ranks {
    origin: [f64; 2],
    cell_m: f64,
    nx: usize,
    ny: usize,
    ranks: Vec<u8>,
}

impl Ranks {
    /// The part of `grid` inside the frame; `None` if they are disjoint. `rank` is called with a cell's index.
    pub(crate) fn new(view: &View, grid: &Raster, rank: impl Fn(usize) -> u8) -> Option<Self> {
        let Frame { west, south, east, north } = view.frame;
        let (first_i, end_i) = range(west, east, grid.origin[0], grid.cell_m, grid.nx)?;
        let (first_j, end_j) = range(south, north, grid.origin[1], grid.cell_m, grid.ny)?;
        let [x, y] = grid.origin;
        let origin = [x + first_i as f64 * grid.cell_m, y + first_j as f64 * grid.cell_m];
        let (nx, ny) = (end_i - first_i, end_j - first_j);
        let finest = (FINEST / (grid.cell_m * view.scale)).ceil().max(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
        let block = (finest as usize).min(nx.max(ny));
        let mut whole = Self { origin, cell_m: grid.cell_m, nx, ny, ranks: Vec::with_capacity(nx * ny) };
        for j in first_j..end_j {
            whole.ranks.extend((first_i..end_i).map(|i| rank(j * grid.nx + i)));
        }
        Some(whole.merged(block))
    }

    /// Blocks of `by` × `by` cells, each with its greatest rank.
    pub(crate) fn merged(self, by: usize) -> Self {
        if by < 2 {
            return self;
        }
        let (nx, ny) = (self.nx.div_ceil(by), self.ny.div_ceil(by));
        let mut ranks = vec![0; nx * ny];
        for (at, &rank) in self.ranks.iter().enumerate() {
            let block = &mut ranks[at / self.nx / by * nx + at % self.nx / by];
            *block = rank.max(*block);
        }
        Self { origin: self.origin, cell_m: self.cell_m * by as f64, nx, ny, ranks }
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> u8 {
        self.ranks[j * self.nx + i]
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        (self.nx, self.ny)
    }

    /// Whether there is a cell of this rank.
    pub(crate) fn holds(&self, rank: u8) -> bool {
        self.ranks.contains(&rank)
    }

    /// Pixels between two columns.
    pub(crate) fn pitch(&self, view: &View) -> f64 {
        self.cell_m * view.scale
    }

    /// Pixel of a vertex.
    pub(crate) fn vertex(&self, view: &View, (i, j): Vertex) -> Point {
        let [x, y] = self.origin;
        view.place([x + i as f64 * self.cell_m, y + j as f64 * self.cell_m])
    }

    /// Borders of all cells of these ranks, kept inside the frame.
    pub(crate) fn border(&self, view: &View, ranks: impl RangeBounds<u8>) -> Path {
        let mut path = Path::default();
        for ring in outlines(self.nx, self.ny, |i, j| ranks.contains(&self.at(i, j))) {
            let corners: Vec<Point> =
                ring.into_iter().map(|vertex| view.nearest(self.vertex(view, vertex))).collect();
            path.ring(&corners);
        }
        path
    }
}

/// First and end index of the cells between `low` and `high`.
fn range(low: f64, high: f64, origin: f64, cell: f64, count: usize) -> Option<(usize, usize)> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the count")]
    let index = |at: f64| at.clamp(0.0, count as f64) as usize;
    let first = index(((low - origin) / cell).floor());
    let end = index(((high - origin) / cell).ceil());
    (first < end).then_some((first, end))
}

/// Vertex of a grid: columns from the west, rows from the south.
pub(crate) type Vertex = (usize, usize);

/// Directions in the order of left turns.
const EAST: u8 = 0;
const NORTH: u8 = 1;
const WEST: u8 = 2;
const SOUTH: u8 = 3;

/// Borders of the cells of an `nx` × `ny` grid that are `inside`, as closed rings of corners with the cells at their
/// left: outer rings counter-clockwise, holes clockwise. Cells that touch only at a corner are separate.
fn outlines(nx: usize, ny: usize, inside: impl Fn(usize, usize) -> bool) -> Vec<Vec<Vertex>> {
    let mut borders = Borders::new(nx, ny, inside);
    let mut rings = Vec::new();
    for start in 0..borders.leaving.len() {
        while borders.leaving[start] != 0 {
            rings.push(borders.ring(start));
        }
    }
    rings
}

/// Per vertex, one bit for each direction in which a border leaves it.
struct Borders {
    wide: usize,
    leaving: Vec<u8>,
}

impl Borders {
    fn new(nx: usize, ny: usize, inside: impl Fn(usize, usize) -> bool) -> Self {
        let wide = nx + 1;
        let mut leaving = vec![0; wide * (ny + 1)];
        for j in 0..ny {
            for i in (0..nx).filter(|&i| inside(i, j)) {
                let at = j * wide + i;
                let sides = [
                    (j == 0 || !inside(i, j - 1), at, EAST),
                    (i + 1 == nx || !inside(i + 1, j), at + 1, NORTH),
                    (j + 1 == ny || !inside(i, j + 1), at + wide + 1, WEST),
                    (i == 0 || !inside(i - 1, j), at + wide, SOUTH),
                ];
                for (_, vertex, direction) in sides.into_iter().filter(|side| side.0) {
                    leaving[vertex] |= 1 << direction;
                }
            }
        }
        Self { wide, leaving }
    }

    /// Follows one border from `start` until it closes, and removes it.
    fn ring(&mut self, start: usize) -> Vec<Vertex> {
        let mut corners = Vec::new();
        let (mut at, mut direction) = (start, None);
        while let Some(next) = self.turn(at, direction) {
            if direction != Some(next) {
                corners.push((at % self.wide, at / self.wide));
            }
            self.leaving[at] &= !(1 << next);
            at = match next {
                EAST => at + 1,
                NORTH => at + self.wide,
                WEST => at - 1,
                _ => at - self.wide,
            };
            direction = Some(next);
            if at == start {
                break;
            }
        }
        corners
    }

    /// The next direction of a border: left if possible, else straight on, else right.
    fn turn(&self, at: usize, direction: Option<u8>) -> Option<u8> {
        let came = direction.unwrap_or(EAST);
        let choices = [came + 1, came, came + 3, came + 2].map(|turned| turned % 4);
        choices.into_iter().find(|choice| self.leaving[at] & (1 << choice) != 0)
    }
}

/// Maximum number of characters of all cells.
const MOST_CHARACTERS: usize = 300_000;

/// Draws the cells: those of every shade together with all more dangerous ones, then the next shade on top, so that
/// there is no seam between two.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, cells: &Cells, limits: &[f64]) {
    let rank = |cell: usize| cells.classes[cell].map_or(0, |class| rank(class, limits));
    let Some(mut ranks) = Ranks::new(view, &cells.grid, rank) else { return };
    let mut layers = layers(view, &ranks, limits);
    while layers.iter().map(|(path, _)| path.data().len()).sum::<usize>() > MOST_CHARACTERS
        && ranks.size() != (1, 1)
    {
        ranks = ranks.merged(2);
        layers = self::layers(view, &ranks, limits);
    }
    layers.iter().for_each(|(path, look)| sheet.path(path, *look));
}

/// Deepest water 1, shoalest as many as there are bands, then no-go, then land.
fn rank(class: Class, limits: &[f64]) -> u8 {
    let bands = bands(limits);
    let rank = match class {
        Class::Depth { least_m } => bands - band(least_m, limits),
        Class::NoGo => bands + 1,
        Class::Land => bands + 2,
    };
    u8::try_from(rank).unwrap_or(u8::MAX)
}

fn layers(view: &View, ranks: &Ranks, limits: &[f64]) -> Vec<(Path, Look)> {
    let bands = bands(limits);
    let shades = u8::try_from(bands).unwrap_or(u8::MAX - 2);
    let water = (1..=shades).map(|rank| (rank, u8::MAX, input::depth(bands - usize::from(rank), bands)));
    let danger = [(shades + 1, shades + 1, input::NO_GO), (shades + 2, shades + 2, input::LAND)];
    let present = water.chain(danger).filter(|(rank, ..)| ranks.holds(*rank));
    present.map(|(rank, last, look)| (ranks.border(view, rank..=last), look)).collect()
}

/// Maximum number of characters of a margin.
const MOST_MARGIN_CHARACTERS: usize = 120_000;
/// Least distance between lines of the hatching [px].
const APART: f64 = 4.5;

/// Draws a margin: pale red for transit, hatched for trial.
pub(crate) fn draw_margin(sheet: &mut Sheet, view: &View, margin: &Margin) {
    let Some((cells, border)) = bordered(view, &margin.grid, &margin.blocked) else { return };
    if margin.purpose == Purpose::Trial {
        sheet.path(&hatching(view, &cells), input::HATCH);
    }
    sheet.path(&border, input::margin(margin.purpose));
}

/// Draws the area swept by hulls.
pub(crate) fn tube(sheet: &mut Sheet, view: &View, tube: &Tube) {
    if let Some((_, border)) = bordered(view, &tube.grid, &tube.swept) {
        sheet.path(&border, input::TUBE);
    }
}

/// Cells, merged until their border is short enough, and that border.
fn bordered(view: &View, grid: &Raster, set: &[bool]) -> Option<(Ranks, Path)> {
    let mut cells = Ranks::new(view, grid, |cell| u8::from(set[cell]))?;
    let mut border = cells.border(view, 1..);
    while border.data().len() > MOST_MARGIN_CHARACTERS && cells.size() != (1, 1) {
        cells = cells.merged(2);
        border = cells.border(view, 1..);
    }
    Some((cells, border))
}

/// Diagonals of the cells on every n-th diagonal of the grid, each run of cells as one line.
fn hatching(view: &View, cells: &Ranks) -> Path {
    let (nx, ny) = cells.size();
    let pitch = cells.pitch(view) * std::f64::consts::FRAC_1_SQRT_2;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates")]
    let every = (APART / pitch).ceil().max(1.0) as usize;
    let mut path = Path::default();
    for diagonal in (0..nx + ny).step_by(every) {
        let (i, j) = (diagonal.saturating_sub(ny), ny.saturating_sub(diagonal));
        for ends in runs(cells, (i, j)) {
            let [from, to] = ends.map(|vertex| cells.vertex(view, vertex));
            view::segment(view, from, to).into_iter().for_each(|(from, to)| path.line(&[from, to]));
        }
    }
    path
}

/// First and end vertex of every run of blocked cells on the diagonal from vertex `start` to the north-east.
fn runs(cells: &Ranks, start: Vertex) -> Vec<[Vertex; 2]> {
    let (nx, ny) = cells.size();
    let length = (nx - start.0.min(nx)).min(ny - start.1.min(ny));
    let vertex = |step: usize| (start.0 + step, start.1 + step);
    let blocked = |step: usize| step < length && cells.at(start.0 + step, start.1 + step) > 0;
    let starts = (0..length).filter(|&step| blocked(step) && (step == 0 || !blocked(step - 1)));
    let end = |from: usize| (from..=length).find(|&step| !blocked(step)).unwrap_or(length);
    starts.map(|from| [from, end(from)].map(vertex)).collect()
}

/// Tolerance of a line [px].
const TRACK_TOLERANCE: f64 = 0.06;
/// The same for one of many realizations.
const COARSE: f64 = 0.25;
/// Maximum number of realizations that are drawn.
pub(crate) const MOST_REALIZATIONS: usize = 200;

/// Draws the tracks: realizations below, then basic moves, run-ins, and maneuvers on top.
pub(crate) fn draw_tracks(sheet: &mut Sheet, view: &View, map: &Map) {
    let styled = |style| map.tracks.iter().filter(move |track| track.style == style);
    let sheaf = chosen(&styled(TrackStyle::Realization).collect::<Vec<_>>());
    let look = input::realization(sheaf.len());
    sheaf.iter().for_each(|track| sheet.path(&path(view, track, COARSE), look));
    for (style, look, halo) in [
        (TrackStyle::Basic, input::BASIC, input::halo(3.6)),
        (TrackStyle::RunIn, input::RUN_IN, input::halo(2.4)),
    ] {
        let paths: Vec<Path> = styled(style).map(|track| path(view, track, TRACK_TOLERANCE)).collect();
        paths.iter().for_each(|path| sheet.path(path, halo));
        paths.iter().for_each(|path| sheet.path(path, look));
    }
    map.tracks.iter().for_each(|track| maneuver(sheet, view, map, track));
}

/// Outlines of corridors, of areas and of the hull.
pub(crate) fn draw_outlines(sheet: &mut Sheet, view: &View, rings: &[Vec<[f64; 2]>], look: Look) {
    let mut path = Path::default();
    rings.iter().for_each(|ring| path.ring(&view::ring(view, &view.placed(ring))));
    sheet.path(&path, look);
}

/// Lines of one look.
pub(crate) fn draw_lines(sheet: &mut Sheet, view: &View, lines: &[Vec<[f64; 2]>], look: Look) {
    let mut path = Path::default();
    for line in lines {
        let parts = view::line(view, &view.placed(line));
        parts.iter().for_each(|part| path.line(&simplified(part, TRACK_TOLERANCE)));
    }
    sheet.path(&path, look);
}

/// Depth contours; their values are drawn with the soundings.
pub(crate) fn contours(sheet: &mut Sheet, view: &View, contours: &[Contour]) {
    let mut path = Path::default();
    for contour in contours {
        let parts = view::line(view, &view.placed(&contour.line));
        parts.iter().for_each(|part| path.line(&simplified(part, COARSE)));
    }
    sheet.path(&path, input::CONTOUR);
}

/// A maneuver with its name as a title.
fn maneuver(sheet: &mut Sheet, view: &View, map: &Map, track: &PlottedTrack) {
    let TrackStyle::Maneuver(index) = track.style else { return };
    let (name, _) = &map.maneuvers[index];
    let title = track.number.map_or_else(|| name.clone(), |number| format!("{number}: {name}"));
    let (line, within) = input::maneuver(index);
    let path = path(view, track, TRACK_TOLERANCE);
    sheet.titled(&title, |sheet| {
        let looks: [Option<Look>; 3] = [Some(input::halo(input::MANEUVER + 2.0)), Some(line), within];
        looks.into_iter().flatten().for_each(|look| sheet.path(&path, look));
    });
}

fn path(view: &View, track: &PlottedTrack, tolerance: f64) -> Path {
    let mut path = Path::default();
    for part in view::line(view, &view.placed(&track.points)) {
        path.line(&simplified(&part, tolerance));
    }
    path
}

/// The tracks to draw, evenly chosen up to the maximum.
fn chosen<'a>(tracks: &[&'a PlottedTrack]) -> Vec<&'a PlottedTrack> {
    let (count, drawn) = (tracks.len(), tracks.len().min(MOST_REALIZATIONS));
    (0..drawn).map(|k| tracks[k * count / drawn]).collect()
}
