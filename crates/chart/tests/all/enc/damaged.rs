//! Files that are not a cell, or not a whole one: refused in one line, never read in part.

use std::path::Path;

use chart::enc::{Cell, Invalid};
use proptest::prelude::*;

pub fn file(suffix: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/charts/enc");
    std::fs::read(folder.join(format!("ZZ5BAY01.{suffix}"))).unwrap()
}

pub fn base() -> Vec<u8> {
    file("000")
}

/// The file with the first place of `from` changed into `to`, of the same length.
fn changed(file: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = file.windows(from.len()).position(|w| w == from).expect("the text to change");
    let mut own = file.to_vec();
    own[at..at + to.len()].copy_from_slice(to);
    own
}

#[track_caller]
pub fn refused<T: std::fmt::Debug>(result: Result<T, Invalid>, texts: &[&str]) {
    let message = result.expect_err("refused").to_string();
    assert!(texts.iter().all(|text| message.contains(text)), "{message}");
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn what_is_encrypted_or_no_chart_at_all_is_refused() {
    let scrambled: Vec<u8> = base().iter().enumerate().map(|(k, b)| b ^ (k * 151 % 251) as u8).collect();
    refused(Cell::read(&scrambled), &["leader", "S-63"]);
    refused(Cell::read(b""), &["an empty file"]);
    refused(Cell::read(b"{\"type\": \"FeatureCollection\", \"features\": []}"), &["leader of ISO 8211"]);
}

#[test]
fn other_products_are_refused_by_name() {
    refused(Cell::read(&changed(&base(), b"FSPC00", b"CATD00")), &["product", "catalogue"]);
    refused(Cell::read(&changed(&base(), b"FSPC00", b"CSID00")), &["product", "S-101"]);
    // The product stands behind the edition of the standard.
    refused(Cell::read(&changed(&base(), b"03.1\x01", b"03.1\x02")), &["product 2 of S-57 03.1"]);
    refused(Cell::read(&changed(&base(), b"(b12,b14,b12)", b"(A,A(5),A(3))")), &["FOID", "A(5)", "binary"]);
}

#[test]
fn other_datums_units_and_topologies_are_refused() {
    let parameters = [20, 1, 0, 0, 0, 2, 3, 23, 0x20, 0x4e, 0, 0, 1, 1, 1, 1];
    let with = |at: usize, value: u8| {
        let mut own = parameters;
        own[at] = value;
        Cell::read(&changed(&base(), &parameters, &own))
    };
    refused(with(5, 1), &["HDAT", "WGS84"]);
    refused(with(12, 3), &["DUNI", "metres"]);
    refused(with(15, 2), &["COUN", "longitude and latitude"]);
    let datums = with(7, 12).unwrap().datums();
    assert_eq!(chart::enc::vertical_datum(datums.depths), Some("mean lower low water"));
    refused(Cell::read(&changed(&base(), &[2, 1, 2, 1, 0, 0, 0], &[3])), &["DSTR", "chain-node"]);
}

#[test]
fn updates_come_one_after_the_other() {
    let updated = |all: &[&str]| {
        let mut cell = Cell::read(&base()).unwrap();
        all.iter().try_for_each(|suffix| cell.update(&file(suffix))).map(|()| cell.identity().update)
    };
    assert_eq!(updated(&["001", "002"]), Ok(2));
    refused(updated(&["002"]), &["update 2 of edition 2", "update 1 of edition 2"]);
    // A repeated update, as in a new issue of the base cell, changes nothing.
    assert_eq!(updated(&["001", "001", "002", "001"]), Ok(2));
    refused(updated(&["000"]), &["a base cell of edition 2"]);
    refused(Cell::read(&file("001")), &["update 1 of edition 2", ".000"]);
    let mut cell = Cell::read(&base()).unwrap();
    let other = changed(&file("001"), b".001\x1f2\x1f", b".001\x1f3\x1f");
    refused(cell.update(&other), &["update 1 of edition 3"]);
}

#[test]
fn updates_of_another_cell_or_in_other_units_are_refused() {
    let mut cell = Cell::read(&base()).unwrap();
    let other = changed(&file("001"), b"ZZ5BAY01.001", b"ZZ5BAY02.001");
    refused(cell.update(&other), &["update 1 of edition 2 of the cell `ZZ5BAY02.001`"]);
    let lower = changed(&file("001"), b"ZZ5BAY01.001", b"zz5bay01.001");
    assert_eq!(Cell::read(&base()).unwrap().update(&lower), Ok(()));
}

#[test]
fn updates_of_what_is_not_there_are_refused() {
    let mut cell = Cell::read(&base()).unwrap();
    // Feature 11 is changed in its second version.
    let of = |number: u8, version: u8| [100, number, 0, 0, 0, 1, 2, 159, 0, version, 0, 3];
    let change = changed(&file("001"), &of(11, 2), &of(99, 2));
    refused(cell.update(&change), &["feature record 99", "a missing record"]);
    let mut cell = Cell::read(&base()).unwrap();
    refused(cell.update(&changed(&file("001"), &of(11, 2), &of(11, 3))), &["version 3", "version 2"]);
}

#[test]
fn missing_nodes_and_open_rings_are_refused_by_object() {
    let edge = |number: u8, end: u8| [130, number, 0, 0, 0, 1, 0, 1, 0x1e, 120, end];
    let lost = Cell::read(&changed(&base(), &edge(1, 1), &edge(1, 77))).unwrap();
    refused(lost.features(), &["M_COVR 65535-1001-1", "120-77"]);
    let open = Cell::read(&changed(&base(), &edge(1, 1), &edge(1, 9))).unwrap();
    refused(open.features(), &["M_COVR 65535-1001-1", "a boundary that ends at"]);
}

#[test]
fn a_cell_that_is_cut_off_is_refused_wherever_that_is() {
    let whole = base();
    for end in 1..whole.len() {
        assert!(Cell::read(&whole[..end]).is_err(), "{end}");
    }
    let last =
        whole.windows(5).rposition(|w| w[0] == 0x1e && w[1..].iter().all(u8::is_ascii_digit)).unwrap() + 1;
    refused(Cell::read(&whole[..last]), &["17 objects", "18", "cut off"]);
    refused(Cell::read(&whole[..whole.len() - 1]), &["record", "cut off"]);
}

proptest! {
    #[test]
    fn law_damaged_bytes_never_panic(at in prop::collection::vec((0usize..7571, any::<u8>()), 1..6)) {
        let mut own = base();
        for (place, byte) in at {
            own[place] = byte;
        }
        if let Ok(mut cell) = Cell::read(&own) {
            let _ = cell.features();
            let _ = cell.update(&file("001"));
            let _ = cell.features();
        }
    }
}
