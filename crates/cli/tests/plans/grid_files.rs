//! Grids and depth areas as programs write them, of any unit, scale and spelling: bytes made by hand.

use std::fmt::Write;

/// Numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    I16,
    U16,
    I32,
    F32,
}

impl Numbers {
    fn is_whole(self) -> bool {
        self != Self::F32
    }

    fn size(self) -> usize {
        if matches!(self, Self::I16 | Self::U16) { 2 } else { 4 }
    }

    /// The bytes of a number.
    fn bytes(self, value: f64, big: bool) -> Vec<u8> {
        let mut bytes = match self {
            Self::I16 => (value as i16).to_be_bytes().to_vec(),
            Self::U16 => (value as u16).to_be_bytes().to_vec(),
            Self::I32 => (value as i32).to_be_bytes().to_vec(),
            Self::F32 => (value as f32).to_be_bytes().to_vec(),
        };
        if !big {
            bytes.reverse();
        }
        bytes
    }
}

/// A grid of depths \[m\], from north to south, without data where there is none.
pub struct Basin {
    pub columns: usize,
    pub west_deg: f64,
    pub south_deg: f64,
    pub cell_deg: f64,
    pub depths_m: Vec<Option<f64>>,
}

impl Basin {
    /// 60 × 60 cells of 0.001 degrees from 24.88 E 60.08 N: 20 m deep, 3 m near the centre, one cell without data.
    pub fn with_a_shoal() -> Self {
        let cell = |k: usize| {
            let (row, column) = (k / 60, k % 60);
            let is_middle = (20..40).contains(&row) && (20..40).contains(&column);
            (k != 0).then_some(if is_middle { 3.0 } else { 20.0 })
        };
        let depths_m = (0..3600).map(cell).collect();
        Self { columns: 60, west_deg: 24.88, south_deg: 60.08, cell_deg: 0.001, depths_m }
    }

    fn rows(&self) -> usize {
        self.depths_m.len() / self.columns
    }

    fn north_deg(&self) -> f64 {
        self.south_deg + self.cell_deg * self.rows() as f64
    }
}

/// The encoding of depths as numbers of a file.
#[derive(Clone, Debug)]
pub struct Packed {
    pub numbers: Numbers,
    /// Metres of its unit.
    pub metres: f64,
    /// Up for heights.
    pub up: bool,
    pub scale: f64,
    pub offset: f64,
    /// The value for no data.
    pub missing: f64,
}

impl Packed {
    /// The number that stands for a depth.
    pub fn number(&self, depth_m: Option<f64>) -> f64 {
        let Some(depth_m) = depth_m else { return self.missing };
        let depth = if self.up { -depth_m } else { depth_m };
        let raw = (depth / self.metres - self.offset) / self.scale;
        if self.numbers.is_whole() { raw.round() } else { raw }
    }
}

/// An ESRI ASCII grid; `no_data` as the header and the rows have it.
pub fn ascii(basin: &Basin, packed: &Packed, no_data: &str) -> Vec<u8> {
    let Basin { columns, west_deg, south_deg, cell_deg, .. } = basin;
    let mut text = format!(
        "ncols {columns}\nnrows {}\nxllcorner {west_deg}\nyllcorner {south_deg}\ncellsize {cell_deg}\nNODATA_value {no_data}\n",
        basin.rows()
    );
    for row in basin.depths_m.chunks(*columns) {
        let word = |depth: &Option<f64>| match depth {
            None => no_data.to_owned(),
            some => packed.number(*some).to_string(),
        };
        text += &(row.iter().map(word).collect::<Vec<_>>().join(" ") + "\n");
    }
    text.into_bytes()
}

/// A GeoTIFF in strips of seven rows; `metadata` as GDAL writes it, `keys` in addition to those of WGS84.
pub fn tiff(
    basin: &Basin,
    packed: &Packed,
    no_data: Option<&str>,
    metadata: Option<&str>,
    keys: &[[u16; 4]],
) -> Vec<u8> {
    const ROWS: usize = 7;
    let mut out = b"II\x2a\x00\0\0\0\0".to_vec();
    let (mut starts, mut lengths) = (Vec::new(), Vec::new());
    for strip in basin.depths_m.chunks(ROWS * basin.columns) {
        starts.push(out.len() as u32);
        out.extend(strip.iter().flat_map(|depth| packed.numbers.bytes(packed.number(*depth), false)));
        lengths.push(out.len() as u32 - starts[starts.len() - 1]);
    }
    let words = |all: &[u32]| all.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let halves = |all: &[u16]| all.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let doubles = |all: &[f64]| all.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let texts = |text: &str| [text.as_bytes(), b"\0"].concat();
    let mut directory = vec![1, 1, 0, 2 + keys.len() as u16, 1024, 0, 1, 2, 2048, 0, 1, 4326];
    directory.extend(keys.iter().flatten());
    let format = match packed.numbers {
        Numbers::U16 => 1,
        Numbers::I16 | Numbers::I32 => 2,
        Numbers::F32 => 3,
    };
    let mut tags: Vec<(u16, u16, Vec<u8>)> = vec![
        (256, 4, words(&[basin.columns as u32])),
        (257, 4, words(&[basin.rows() as u32])),
        (258, 3, halves(&[8 * packed.numbers.size() as u16])),
        (259, 3, halves(&[1])),
        (262, 3, halves(&[1])),
        (273, 4, words(&starts)),
        (277, 3, halves(&[1])),
        (278, 4, words(&[ROWS as u32])),
        (279, 4, words(&lengths)),
        (339, 3, halves(&[format])),
        (33550, 12, doubles(&[basin.cell_deg, basin.cell_deg, 0.0])),
        (33922, 12, doubles(&[0.0, 0.0, 0.0, basin.west_deg, basin.north_deg(), 0.0])),
        (34735, 3, halves(&directory)),
    ];
    tags.extend(metadata.map(|text| (42112, 2, texts(text))));
    tags.extend(no_data.map(|text| (42113, 2, texts(text))));
    let size = |kind: u16| [0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8][usize::from(kind)];
    let mut entries = (tags.len() as u16).to_le_bytes().to_vec();
    for (tag, kind, value) in &tags {
        entries.extend(halves(&[*tag, *kind]));
        entries.extend(((value.len() / size(*kind)) as u32).to_le_bytes());
        let mut own = value.clone();
        if own.len() > 4 {
            own = (out.len() as u32).to_le_bytes().to_vec();
            out.extend(value);
            out.resize(out.len().next_multiple_of(4), 0);
        }
        own.resize(4, 0);
        entries.extend(own);
    }
    entries.extend([0; 4]);
    let at = (out.len() as u32).to_le_bytes();
    out[4..8].copy_from_slice(&at);
    out.extend(entries);
    out
}

/// An attribute of a NetCDF variable.
pub enum Said<'a> {
    Text(&'a str),
    /// A number of the variable's own type.
    Own(f64),
    Double(f64),
}

/// A classic NetCDF file with the variable `z` over `lat` and `lon`, northward unless `southward`.
pub fn netcdf(basin: &Basin, packed: &Packed, said: &[(&str, Said)], southward: bool) -> Vec<u8> {
    let mut lines: Vec<&[Option<f64>]> = basin.depths_m.chunks(basin.columns).rev().collect();
    if southward {
        lines.reverse();
    }
    let mut out = netcdf_before(basin, [basin.rows(), basin.columns], packed, said, southward);
    let numbers =
        lines.concat().into_iter().flat_map(|depth| packed.numbers.bytes(packed.number(depth), true));
    out.extend(numbers);
    out.resize(out.len().next_multiple_of(4), 0);
    out
}

/// The header of such a file, of `rows` and `columns`.
pub fn netcdf_before(
    basin: &Basin,
    [rows, columns]: [usize; 2],
    packed: &Packed,
    said: &[(&str, Said)],
    southward: bool,
) -> Vec<u8> {
    let middle = |start: f64, k: usize| start + basin.cell_deg * (k as f64 + 0.5);
    let mut lat: Vec<f64> = (0..rows).map(|k| middle(basin.south_deg, k)).collect();
    let lon: Vec<f64> = (0..columns).map(|k| middle(basin.west_deg, k)).collect();
    if southward {
        lat.reverse();
    }
    let own_type = match packed.numbers {
        Numbers::I16 => 3,
        Numbers::I32 => 4,
        Numbers::F32 => 5,
        Numbers::U16 => panic!("classic files have no such numbers"),
    };
    let own = (own_type, packed.numbers);
    let axis = |units| attributes(&[("units", Said::Text(units))], own);
    let size = (rows * columns * packed.numbers.size()).next_multiple_of(4);
    let variables = [
        Variable { name: "lat", dimensions: vec![0], said: axis("degrees_north"), kind: 6, size: 8 * rows },
        Variable { name: "lon", dimensions: vec![1], said: axis("degrees_east"), kind: 6, size: 8 * columns },
        Variable { name: "z", dimensions: vec![0, 1], said: attributes(said, own), kind: own_type, size },
    ];
    let header = |mut start: usize| {
        let mut out = b"CDF\x01\0\0\0\0".to_vec();
        out.extend([word(10), word(2), name("lat"), word(rows), name("lon"), word(columns)].concat());
        out.extend([word(0), word(0), word(11), word(3)].concat());
        for own in &variables {
            out.extend(own.header(start));
            start += own.size;
        }
        out
    };
    let mut out = header(header(0).len());
    out.extend(lat.iter().chain(&lon).flat_map(|v| v.to_be_bytes()));
    out
}

/// A variable of a classic file, with its attributes as bytes.
struct Variable {
    name: &'static str,
    dimensions: Vec<usize>,
    said: Vec<u8>,
    kind: usize,
    size: usize,
}

impl Variable {
    fn header(&self, start: usize) -> Vec<u8> {
        let dimensions = self.dimensions.iter().flat_map(|d| word(*d)).collect::<Vec<u8>>();
        let ends = [word(self.kind), word(self.size), word(start)].concat();
        [name(self.name), word(self.dimensions.len()), dimensions, self.said.clone(), ends].concat()
    }
}

fn word(value: usize) -> Vec<u8> {
    (value as u32).to_be_bytes().to_vec()
}

fn padded(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

fn name(text: &str) -> Vec<u8> {
    [word(text.len()), padded(text.as_bytes().to_vec())].concat()
}

/// The attributes of a variable of numbers `own`.
fn attributes(all: &[(&str, Said)], (own_type, numbers): (usize, Numbers)) -> Vec<u8> {
    if all.is_empty() {
        return word(0).repeat(2);
    }
    let attribute = |(key, value): &(&str, Said)| {
        let (kind, count, bytes) = match value {
            Said::Text(text) => (2, text.len(), text.as_bytes().to_vec()),
            Said::Own(number) => (own_type, 1, numbers.bytes(*number, true)),
            Said::Double(number) => (6, 1, number.to_be_bytes().to_vec()),
        };
        [name(key), word(kind), word(count), padded(bytes)].concat()
    };
    [word(12), word(all.len()), all.iter().flat_map(attribute).collect()].concat()
}

/// Depth areas: the shoal, and the deeper water around it; `least` is the property of the depth.
pub fn geojson(basin: &Basin, packed: &Packed, least: &str) -> Vec<u8> {
    let ring = |west: f64, south: f64, east: f64, north: f64| {
        format!(
            "[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], [{west}, {south}]]"
        )
    };
    let side = basin.cell_deg * basin.columns as f64;
    let part = |k: f64| [basin.west_deg + k * side, basin.south_deg + k * side];
    let [[w0, s0], [w1, s1], [w2, s2], [w3, s3]] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(part);
    let (outer, inner) = (ring(w0, s0, w3, s3), ring(w1, s1, w2, s2));
    let mut text = String::from("{\"type\": \"FeatureCollection\", \"features\": [");
    for (k, (depth_m, rings)) in
        [(20.0, format!("{outer}, {inner}")), (3.0, inner.clone())].iter().enumerate()
    {
        let depth = packed.number(Some(*depth_m));
        let comma = if k > 0 { ", " } else { "" };
        write!(text, "{comma}{{\"type\": \"Feature\", \"properties\": {{\"{least}\": {depth}}}, ").unwrap();
        write!(text, "\"geometry\": {{\"type\": \"Polygon\", \"coordinates\": [{rings}]}}}}").unwrap();
    }
    (text + "]}").into_bytes()
}
