//! Digests of files and bytes, and their text form.

use std::io::Read;

use files::{Digest, Digesting};

/// BLAKE3 of the empty input, from the BLAKE3 test vectors.
const EMPTY: &str = "blake3:af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";

#[test]
fn oracle_digest_of_nothing() {
    assert_eq!(Digest::of_bytes(b"").to_string(), EMPTY);
}

#[test]
fn file_and_bytes_agree() {
    let folder = tempfile::tempdir().unwrap();
    let bytes: Vec<u8> = (0..300_000_u32).map(|i| (i % 251) as u8).collect();
    std::fs::write(folder.path().join("f"), &bytes).unwrap();
    assert_eq!(Digest::of_file(folder.path().join("f")).unwrap(), Digest::of_bytes(&bytes));
}

#[test]
fn what_is_read_has_the_digest_of_the_whole_file() {
    let bytes: Vec<u8> = (0..300_000_u32).map(|i| (i % 251) as u8).collect();
    for read in [0, 1, 200_000, bytes.len()] {
        let mut source = Digesting::new(bytes.as_slice());
        source.read_exact(&mut vec![0; read]).unwrap();
        assert_eq!(source.digest().unwrap(), Digest::of_bytes(&bytes), "{read} bytes read");
    }
}

#[test]
fn text_form_is_strict() {
    assert_eq!(EMPTY.parse::<Digest>().unwrap().to_string(), EMPTY);
    for wrong in ["", "blake3:", &EMPTY[7..], &EMPTY[..70], &EMPTY.to_uppercase(), &EMPTY.replace('a', "A")] {
        assert!(wrong.parse::<Digest>().is_err(), "{wrong}");
    }
}
