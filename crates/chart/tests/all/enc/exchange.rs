//! Catalogues of exchange sets, and their checksums of files.

use chart::enc::{Listed, Purpose, crc, identify, listed};

use crate::enc::damaged::{base, file, refused};
use crate::enc::made::catalogue;

#[test]
fn a_catalogue_lists_files_with_their_checksums() {
    // The check value of CRC-32 (IEEE 802.3).
    assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    let all = listed(&catalogue(&[
        ("CATALOG.031", ""),
        ("ENC_ROOT\\US\\zz5bay01\\2\\0\\ZZ5BAY01.000", "cbf43926"),
        ("ZZ5BAY01/ZZ5BAY01.001", " 0000ABCD "),
    ]))
    .unwrap();
    let place = |parts: &[&str]| parts.iter().map(|part| (*part).to_owned()).collect::<Vec<_>>();
    let expected = [
        Listed { place: place(&["CATALOG.031"]), crc: None },
        Listed { place: place(&["US", "ZZ5BAY01", "2", "0", "ZZ5BAY01.000"]), crc: Some(0xCBF4_3926) },
        Listed { place: place(&["ZZ5BAY01", "ZZ5BAY01.001"]), crc: Some(0xABCD) },
    ];
    assert_eq!(all, expected);
    assert!(all[1].agrees(b"123456789") && !all[1].agrees(b"123456788") && all[0].agrees(b"anything"));
    assert_eq!(all[1].name(), "ZZ5BAY01.000");
}

#[test]
fn what_is_no_catalogue_is_refused() {
    refused(listed(&base()), &["catalogue", "CATD"]);
    refused(listed(b"xx"), &["leader"]);
    refused(listed(&catalogue(&[("A.000", "not hex")])), &["A.000", "CRCS", "not hex"]);
    let whole = catalogue(&[("A.000", "ABCD"), ("A.001", "ABCD")]);
    refused(listed(&whole[..whole.len() - 5]), &["record 2", "cut off"]);
}

#[test]
fn a_file_is_identified_by_its_first_records_alone() {
    let whole = base();
    let own = identify(&whole[..2000]).unwrap();
    assert_eq!((own.purpose, own.edition.as_str(), own.update), (Purpose::Base, "2", 0));
    let update = identify(&file("002")).unwrap();
    assert_eq!((update.purpose, update.update, update.name.as_str()), (Purpose::Update, 2, "ZZ5BAY01.002"));
    refused(identify(&whole[..500]), &["cut off"]);
}
