//! Text in practice: encodings, line ends, missing values, too many cells.

use std::fs;

use crate::known::*;
use crate::runner::*;

/// `text` with other ends of lines.
fn ended(text: &str, ends: &[&str]) -> String {
    let lines = text.lines().zip(ends.iter().cycle());
    lines.flat_map(|(line, end)| [line, end]).collect()
}

/// `text` in all encodings that are read.
fn encoded(text: &str) -> Vec<(&'static str, Vec<u8>)> {
    let marked = "\u{feff}".to_owned() + text;
    let wide = |text: &str, order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect();
    vec![
        ("UTF-8", text.as_bytes().to_vec()),
        ("UTF-8, marked", marked.as_bytes().to_vec()),
        ("UTF-16 LE", wide(&marked, u16::to_le_bytes)),
        ("UTF-16 BE", wide(&marked, u16::to_be_bytes)),
        ("UTF-16 LE, unmarked", wide(text, u16::to_le_bytes)),
        ("UTF-16 BE, unmarked", wide(text, u16::to_be_bytes)),
    ]
}

#[test]
fn tables_and_sentences_are_read_in_any_encoding_and_with_any_ends_of_lines() {
    let table = table_config("*.csv", "unit = \"s\"", "");
    let sentences = nmea_config("RMC", "HDT.heading", "");
    let folder = folder(&[]);
    for (name, config, text) in
        [("a.csv", &table, csv(60, |k| format!("{k}"))), ("a.nmea", &sentences, nmea(&epochs(60)))]
    {
        fs::write(folder.path().join("ingest.toml"), config).unwrap();
        for ends in [&["\n"][..], &["\r\n"], &["\r"], &["\r\r\n"], &["\r", "\n", "\r\n"]] {
            for (encoding, bytes) in encoded(&ended(&text, ends)) {
                fs::write(folder.path().join(name), bytes).unwrap();
                println!("{name} in {encoding}, {ends:?}");
                healthy(&read(folder.path()), 61);
            }
        }
        fs::remove_file(folder.path().join(name)).unwrap();
    }
}

/// The healthy table with `line` instead of each of its lines.
fn changed(line: impl Fn(usize, &str) -> String) -> String {
    let table = csv(60, |k| format!("{k}"));
    table.lines().enumerate().map(|(number, text)| line(number, text) + "\n").collect()
}

fn read_table(table: &str) -> Made {
    let config = table_config("*.csv", "unit = \"s\"", "");
    read(folder(&[("ingest.toml", &config), ("a.csv", table)]).path())
}

#[test]
fn commas_at_the_end_of_lines_are_no_cells() {
    healthy(&read_table(&changed(|k, line| if k == 0 { line.into() } else { format!("{line},") })), 61);
    healthy(&read_table(&changed(|_, line| format!("{line},,"))), 61);
    healthy(&read_table(&changed(|k, line| if k == 0 { format!("{line},") } else { line.into() })), 61);
    healthy(
        &read_table(&changed(|k, line| if k % 7 == 3 { format!("{line} , ,") } else { line.into() })),
        61,
    );
    let more = changed(|k, line| if k == 9 { format!("{line},7") } else { line.into() });
    let config = table_config("*.csv", "unit = \"s\"", "");
    let pieces = ["a.csv: line 10", "found 8 cells", "expected 7", "in quotes"];
    refused(&config, &more, &pieces);
    let commas =
        changed(|k, line| if k == 0 { line.into() } else { line.replace('.', ",").replace(',', ",0,") });
    refused(&config, &commas, &["a.csv: line 2", "expected 7"]);
    let commas = changed(|k, line| if k == 0 { line.into() } else { line.replace('.', ",") });
    refused(&config, &commas, &["a.csv: line 2: found 13 cells", "decimal commas"]);
}

#[test]
fn whatever_says_that_there_is_no_value_is_missing() {
    let words = [
        "",
        "nan",
        "NaN",
        "NAN",
        "-nan",
        "nan(ind)",
        "-1.#IND",
        "n/a",
        "NA",
        "#N/A",
        "null",
        "NULL",
        "None",
        "inf",
        "-Infinity",
        "#DIV/0!",
        "-",
        "<NA>",
        " NaN ",
    ];
    let table = changed(|k, line| match words.get((k / 3).wrapping_sub(1)).filter(|_| k % 3 == 0) {
        Some(word) => format!("{},{word}", line.rsplit_once(',').unwrap().0),
        None => line.to_owned(),
    });
    let config = table_config("*.csv", "unit = \"s\"", "").replace("max_gap_s = 1.5", "max_gap_s = 2.5");
    let made = read(folder(&[("ingest.toml", &config), ("a.csv", &table)]).path());
    healthy(&made, 61);
    let channels = &made.summary.recordings[0].channels;
    let missing = channels.iter().find(|channel| channel.name == "n").map(|channel| channel.missing);
    assert_eq!(missing, Some(words.len() as u64));
    let other = table.replace(",n/a\n", ",n.a.\n");
    refused(&config, &other, &["column `n`", "`n.a.`", "a number"]);
}

#[test]
fn quotes_and_blanks_around_cells_are_none_of_them() {
    healthy(&read_table(&changed(|_, line| format!(" \"{}\" ", line.replace(',', "\" ,\t\"")))), 61);
}

#[test]
fn a_column_that_is_there_twice_is_refused_where_it_is_wanted() {
    let config = table_config("*.csv", "unit = \"s\"", "");
    let twice = changed(|k, line| format!("{line},{}", if k == 0 { "r" } else { "0.5" }));
    refused(&config, &twice, &["a.csv: column `r`", "found 2 of this name", "rename"]);
    healthy(&read_table(&changed(|k, line| format!("{line},{0},{0}", if k == 0 { "w" } else { "0.5" }))), 61);
}
