//! Synthetic ISO 8211 files for tests: records, and catalogues of exchange sets.
#![allow(dead_code)]

/// Ends of a field and of a subfield.
const FE: u8 = 0x1e;
const UE: u8 = 0x1f;

/// A record of fields; one that is too long for a length of its own has none.
pub fn record(kind: u8, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let (mut directory, mut area) = (Vec::new(), Vec::new());
    for (tag, data) in fields {
        directory.extend(format!("{tag}{:09}{:09}", data.len() + 1, area.len()).bytes());
        area.extend([&data[..], &[FE]].concat());
    }
    let base = 24 + directory.len() + 1;
    let length = if base + area.len() < 100_000 { base + area.len() } else { 0 };
    let (first, second) = if kind == b'L' { ("3LE1 09", " ! ") } else { (" D     ", "   ") };
    let leader = format!("{length:05}{first}{base:05}{second}9904");
    [leader.into_bytes(), directory, vec![FE], area].concat()
}

/// A catalogue that lists files with their checksums.
pub fn catalogue(files: &[(&str, &str)]) -> Vec<u8> {
    let labels = "RCNM!RCID!FILE!LFIL!VOLM!IMPL!SLAT!WLON!NLAT!ELON!CRCS!COMT";
    let parts = ["1600;&   Catalogue Directory field", labels, "(A(2),I(10),3A,A(3),4R,2A)"];
    let described = parts.map(|part| part.as_bytes().to_vec()).join(&UE);
    let fields = [("0000", b"0000;&   \x1f0001CATD".to_vec()), ("0001", b"0100;&   \x1f\x1f(I(5))".to_vec())];
    let mut all = record(b'L', &[&fields[..], &[("CATD", described)]].concat());
    for (number, (file, crc)) in (1..).zip(files) {
        let entry = format!(
            "CD{number:010}{file}\x1f\x1fV01X01\x1fBIN59.95\x1f24.9\x1f60.05\x1f25.1\x1f{crc}\x1f\x1f"
        );
        all.extend(record(
            b'D',
            &[("0001", format!("{number:05}").into_bytes()), ("CATD", entry.into_bytes())],
        ));
    }
    all
}

/// An edge with places between two nodes (1 and 2).
pub fn edge(number: u32, places: usize) -> Vec<u8> {
    let name = [&[130][..], &number.to_le_bytes(), &[1, 0, 1]].concat();
    let end =
        |node: u32, topology: u8| [&[120][..], &node.to_le_bytes(), &[255, 255, topology, 255]].concat();
    let place = |k: usize| [600_000_000_i32 + k as i32, 249_000_000].map(i32::to_le_bytes).concat();
    let places = (0..places).flat_map(place).collect();
    record(b'D', &[("VRID", name), ("VRPT", [end(1, 1), end(2, 2)].concat()), ("SG2D", places)])
}

/// A node on a circle of 40,000.
pub fn node_at(number: u32, k: u32) -> Vec<u8> {
    let (sin, cos) = (f64::from(k) / 40_000.0 * std::f64::consts::TAU).sin_cos();
    let place = [600_000_000.0 + 1e5 * sin, 250_000_000.0 + 1e5 * cos];
    let name = [&[120][..], &number.to_le_bytes(), &[1, 0, 1]].concat();
    record(b'D', &[("VRID", name), ("SG2D", place.map(|v| (v as i32).to_le_bytes()).concat())])
}

/// A straight edge between two nodes.
pub fn edge_between(number: u32, from: u32, to: u32) -> Vec<u8> {
    let name = [&[130][..], &number.to_le_bytes(), &[1, 0, 1]].concat();
    let end =
        |node: u32, topology: u8| [&[120][..], &node.to_le_bytes(), &[255, 255, topology, 255]].concat();
    record(b'D', &[("VRID", name), ("VRPT", [end(from, 1), end(to, 2)].concat())])
}

/// A line of a class along edges, each as often as it is named.
pub fn line(number: u32, class: u16, edges: impl Iterator<Item = u32>) -> Vec<u8> {
    along(2, number, class, edges)
}

/// An area of a class within edges, in any order.
pub fn area(number: u32, class: u16, edges: impl Iterator<Item = u32>) -> Vec<u8> {
    along(3, number, class, edges)
}

fn along(primitive: u8, number: u32, class: u16, edges: impl Iterator<Item = u32>) -> Vec<u8> {
    let [low, high] = class.to_le_bytes();
    let name = [&[100][..], &number.to_le_bytes(), &[primitive, 2, low, high, 1, 0, 1]].concat();
    let id = [&[255, 255][..], &(number + 5000).to_le_bytes(), &[1, 0]].concat();
    let pointers = edges.flat_map(|edge| [&[130][..], &edge.to_le_bytes(), &[1, 1, 255]].concat()).collect();
    record(b'D', &[("FRID", name), ("FOID", id), ("FSPT", pointers)])
}
