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
    fn bytes(self, value: f64) -> Vec<u8> {
        match self {
            Self::I16 => (value as i16).to_le_bytes().to_vec(),
            Self::U16 => (value as u16).to_le_bytes().to_vec(),
            Self::I32 => (value as i32).to_le_bytes().to_vec(),
            Self::F32 => (value as f32).to_le_bytes().to_vec(),
        }
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
    let size = [basin.rows(), basin.columns];
    let [start, end] = tiff_around(basin, size, packed, no_data, metadata, keys);
    let numbers = basin.depths_m.iter().flat_map(|depth| packed.numbers.bytes(packed.number(*depth)));
    [start, numbers.collect(), end].concat()
}

/// What stands before and after the numbers of such a file, of `rows` and `columns`.
pub fn tiff_around(
    basin: &Basin,
    [rows, columns]: [usize; 2],
    packed: &Packed,
    no_data: Option<&str>,
    metadata: Option<&str>,
    keys: &[[u16; 4]],
) -> [Vec<u8>; 2] {
    const ROWS: usize = 7;
    let mut start = b"II\x2a\x00\0\0\0\0".to_vec();
    let row = columns * packed.numbers.size();
    let first = start.len() + rows * row;
    let strips = || (0..rows).step_by(ROWS);
    let starts: Vec<u32> = strips().map(|k| (start.len() + k * row) as u32).collect();
    let lengths: Vec<u32> = strips().map(|k| (ROWS.min(rows - k) * row) as u32).collect();
    let mut out = Vec::new();
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
    let north_deg = basin.south_deg + basin.cell_deg * rows as f64;
    let mut tags: Vec<(u16, u16, Vec<u8>)> = vec![
        (256, 4, words(&[columns as u32])),
        (257, 4, words(&[rows as u32])),
        (258, 3, halves(&[8 * packed.numbers.size() as u16])),
        (259, 3, halves(&[1])),
        (262, 3, halves(&[1])),
        (273, 4, words(&starts)),
        (277, 3, halves(&[1])),
        (278, 4, words(&[ROWS as u32])),
        (279, 4, words(&lengths)),
        (339, 3, halves(&[format])),
        (33550, 12, doubles(&[basin.cell_deg, basin.cell_deg, 0.0])),
        (33922, 12, doubles(&[0.0, 0.0, 0.0, basin.west_deg, north_deg, 0.0])),
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
            own = ((first + out.len()) as u32).to_le_bytes().to_vec();
            out.extend(value);
            out.resize(out.len().next_multiple_of(4), 0);
        }
        own.resize(4, 0);
        entries.extend(own);
    }
    entries.extend([0; 4]);
    start[4..].copy_from_slice(&((first + out.len()) as u32).to_le_bytes());
    out.extend(entries);
    [start, out]
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
