//! Numbers, texts and comments in the syntax of the languages.

use seatrial::export::text::{comment, number, quoted, single};

#[test]
fn what_a_user_wrote_ends_no_text_and_no_comment() {
    assert_eq!(quoted("a\"b\\c\nd??/"), "\"a\\\"b\\\\c d?\\077/\"");
    assert_eq!(single("it's\r%"), "'it''s %'");
    assert_eq!(comment("*/ x \\\n/* ??/"), "* / x / / * ? ?/");
}

#[test]
fn numbers_read_back() {
    for value in [0.1, -1e-300, 1.0 / 3.0, 12_345_678.9, 1e22, 5e-324] {
        assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
    }
}
