//! Text files in practice: without header, with other decimals, blanks or lines before the header.

use crate::runner::*;

const CONFIG: [&str; 2] = ["--config", "ingest.toml"];

/// [`config`] for columns by number, with more keys of the file.
fn numbered(keys: &str) -> String {
    let mut text = config("");
    for (number, column) in ["t", "u", "v", "r", "n"].into_iter().enumerate() {
        text = text.replace(&format!("column = \"{column}\""), &format!("column = \"{}\"", number + 1));
    }
    text.replace("time =", &format!("{keys}\ntime ="))
}

fn rows(rows: usize) -> String {
    log(rows).split_once('\n').unwrap().1.to_owned()
}

#[test]
fn files_without_a_header_are_read_by_number() {
    let text = numbered("header = false\ncolumns = 5");
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &rows(8))]).path(), &CONFIG);
    assert_eq!((made.rows, made.f64("y_u")[3]), (8, 0.13));
}

#[test]
fn files_with_another_number_of_columns_are_refused() {
    let of = |columns: u32| numbered(&format!("header = false\ncolumns = {columns}"));
    let four = of(4).replace("column = \"5\"", "column = \"4\"");
    refused(&four, &rows(8), &["a.csv: line 1", "found 5 cells", "expected 4, as `columns` says"]);
    let pieces =
        ["a.csv: line 1", "found 5 cells", "expected 6, as `columns` says", "`columns` in ingest.toml"];
    refused(&of(6), &rows(8), &pieces);
    refused(&of(4), &rows(8), &["a.csv: column: found no `5`"]);
    refused(&numbered("header = false"), &rows(8), &["ingest.toml: `header`", "`columns`"]);
    refused(&numbered("columns = 5"), &rows(8), &["ingest.toml: `columns`", "beside a header"]);
}

#[test]
fn decimal_commas_are_read_where_they_are_stated() {
    let text = config("").replace("time =", "separator = \";\"\ndecimal = \",\"\ntime =");
    let csv = log(8).replace(',', ";").replace('.', ",");
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
    assert_eq!(made.f64("y_u")[3], 0.13);
    let thousands = csv.replace("3;0,13", "3;1.000,13");
    refused(&text, &thousands, &["a.csv: line 5, column `u`", "`1.000,13`", "a decimal comma"]);
    refused(&text.replace("separator = \";\"\n", ""), &csv, &["ingest.toml: `decimal`", "another separator"]);
}

#[test]
fn blanks_in_any_number_and_lines_before_the_header_are_passed_over() {
    let text = config("").replace("time =", "separator = \" \"\nskip_lines = 2\ntime =");
    let csv = "Logger 7\nof the pilot boat, spring\n".to_owned()
        + &log(8).replace(',', "   ").replace("\n3", "\n  3");
    let made = ingest(folder(&[("ingest.toml", &text), ("a.csv", &csv)]).path(), &CONFIG);
    assert_eq!((made.rows, made.f64("y_u")[3]), (8, 0.13));
}
