//! Tables and bags with one fault at random: none of it is silent.

use crate::known::{csv, table_config};
use crate::silent::{Faulty, none_is_silent};

/// A faulty table, with these keys of its clock and before its files.
fn faulty(time: &str, top: &str, log: impl Into<Vec<u8>>, rows: usize) -> Faulty {
    Faulty::new(&table_config("*.csv", time, top), "a.csv", log, rows)
}

const POLICIES: [&str; 3] = ["", "non_monotonic = \"drop\"", "non_monotonic = \"sort\""];

/// `hh:mm:ss` of a second of the day.
fn of_day(second: usize) -> String {
    let second = second % 86_400;
    format!("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60)
}

#[test]
fn law_encodings_and_ends_of_lines_are_never_silent() {
    let tally = none_is_silent(100, |draw| {
        let table = csv(60, |k| k.to_string());
        let ends = [&["\n"][..], &["\r\n"], &["\r"], &["\r", "\n"], &["\r\n", "\r"]][draw.below(5)];
        let text: String =
            table.lines().zip(ends.iter().cycle()).flat_map(|(line, end)| [line, end]).collect();
        let marked = ["", "\u{feff}"][draw.below(2)].to_owned() + &text;
        let units = marked.encode_utf16();
        let bytes: Vec<u8> = match draw.below(4) {
            0 => units.flat_map(u16::to_le_bytes).collect(),
            1 => units.flat_map(u16::to_be_bytes).collect(),
            2 => marked.chars().flat_map(|c| (c as u32).to_le_bytes()).collect(),
            _ => marked.into_bytes(),
        };
        faulty("unit = \"s\"", "", bytes, 61).what(format!("{ends:?}"))
    });
    assert_eq!(tally.counted, 0);
}

#[test]
fn law_cells_that_are_none_or_too_many_are_never_silent() {
    none_is_silent(101, |draw| {
        let words =
            ["", "NaN", "n/a", "-9999x", "null", "1,5", "0,5", "#N/A", "\"\"", "12:00", "-", "1e", "O.5"];
        let (word, line, column) = (words[draw.below(words.len())], draw.between(2, 60), draw.below(8));
        let table = csv(60, |k| k.to_string());
        let with = |text: &str| {
            let mut cells: Vec<&str> = text.split(',').collect();
            match cells.get_mut(column) {
                Some(cell) => *cell = word,
                None => cells.push(word),
            }
            cells.join(",")
        };
        let lines = table.lines().enumerate();
        let table: String =
            lines.map(|(k, text)| if k == line { with(text) } else { text.to_owned() } + "\n").collect();
        // Values missing from the first or last row are at the ends of the log and cannot be detected.
        faulty("unit = \"s\"", "", table, 61)
            .named(&["splits", "without_time", "no value"])
            .what(format!("`{word}` in line {line}, column {column}"))
    });
}

#[test]
fn law_files_that_are_cut_are_never_silent() {
    none_is_silent(102, |draw| {
        let table = csv(60, |k| k.to_string());
        let from = table.find("\n30,").unwrap();
        let at = draw.between(from, table.len());
        let whole = |end: &usize| *end <= at;
        let rows = table.match_indices('\n').map(|(end, _)| end).filter(whole).count() - 1;
        faulty("unit = \"s\"", "", &table[..at], rows).named(&["cut"]).what(format!("cut at {at}"))
    });
}

#[test]
fn law_clocks_that_begin_anew_are_never_silent() {
    none_is_silent(103, |draw| {
        let ticks = [("s", 1_u64), ("ms", 1000), ("us", 1_000_000)];
        let (unit, per_second) = ticks[draw.below(3)];
        let periods = [1 << 16, 1 << 24, 1 << 31, 1 << 32, 86_400 * per_second, 604_800 * per_second];
        let period = periods[draw.below(6)];
        let start = draw.below(period.min(1 << 40) as usize) as u64;
        let start = if draw.below(2) == 0 {
            start
        } else {
            period - draw.between(1, 59) as u64 * per_second % period
        };
        let half = if draw.below(3) == 0 { period / 2 } else { 0 };
        let now = |k: usize| ((start + k as u64 * per_second + half) % period) as i64 - half as i64;
        faulty(&format!("unit = \"{unit}\""), POLICIES[draw.below(3)], csv(60, |k| now(k).to_string()), 61)
            .named(&["backwards", "splits"])
            .what(format!("{period} {unit} from {start}"))
    });
    let tally = none_is_silent(104, |draw| {
        let start = 86_400 - draw.between(1, 59);
        let swapped = if draw.below(4) == 0 { 99 } else { draw.below(60) };
        let row = |k: usize| {
            if k == swapped {
                k + 1
            } else if k == swapped + 1 {
                k - 1
            } else {
                k
            }
        };
        let table = csv(60, |k| of_day(start + row(k)));
        faulty("format = \"%H:%M:%S\"", POLICIES[draw.below(3)], table, 61)
            .named(&["backwards", "sorted"])
            .what(format!("midnight after {start}, {swapped} late"))
    });
    assert!(tally.healthy > 0);
}

#[test]
fn law_seconds_60_are_never_silent() {
    none_is_silent(105, |draw| {
        let leap = draw.below(61);
        let keys = ["unit = \"iso8601\"", "format = \"%Y-%m-%d %H:%M:%S\"", "format = \"%H:%M:%S\""];
        let key = keys[draw.below(3)];
        let stamp = |k: usize| {
            let time = match k.cmp(&leap) {
                std::cmp::Ordering::Less => of_day(86_400 - leap + k),
                std::cmp::Ordering::Equal => "23:59:60".to_owned(),
                std::cmp::Ordering::Greater => of_day(k - leap - 1),
            };
            let day = if k <= leap { "2016-12-31" } else { "2017-01-01" };
            if key.contains("%Y") || key.contains("iso") { format!("{day} {time}") } else { time }
        };
        faulty(key, POLICIES[draw.below(3)], csv(60, stamp), 61)
            .named(&["leap"])
            .what(format!("in row {leap}"))
    });
}

#[test]
fn law_times_without_leading_zeros_are_never_silent() {
    none_is_silent(106, |draw| {
        let unit = [1000_u64, 1_000_000, 1_000_000_000][draw.below(3)];
        let (jitter, from) = (draw.between(1, 40) as u64, draw.below(1000) as u64);
        let now = |k: usize| {
            (50_000 + k as u64) * unit + from * unit / 1000 + (k as u64 * 7 % 13) * jitter * unit / 20_000
        };
        let (time, text): (_, fn(u64) -> String) = match draw.below(2) {
            0 => ("unit = \"s\"", |second| second.to_string()),
            _ => ("format = \"%H:%M:%S.%f\"", |second| of_day(second as usize)),
        };
        let table = csv(60, |k| format!("{}.{}", text(now(k) / unit), now(k) % unit));
        faulty(time, POLICIES[draw.below(3)], table, 61)
            .named(&["unpadded", "backwards", "splits"])
            .what(format!("1/{unit} s, {from} ms, jitter {jitter}"))
    });
}

#[test]
fn law_clocks_that_are_set_are_never_silent() {
    none_is_silent(107, |draw| {
        let (row, by) = (draw.between(2, 58), [3, 30, 3600, 86_400, 300_000, 1_400_000_000][draw.below(6)]);
        let start = [0, 400_000_000, 1_744_373_300][draw.below(3)] + 1;
        let forward = draw.below(2) == 0;
        let lasting = draw.below(3) > 0;
        let is_off = |k: usize| if lasting { k >= row } else { k == row };
        let now = |k: usize| start + k as i64 + i64::from(is_off(k)) * if forward { by } else { -by };
        faulty("unit = \"s\"", POLICIES[draw.below(3)], csv(60, |k| now(k).to_string()), 61)
            .named(&["unset", "backwards", "splits", "rollovers"])
            .what(format!("by {by} s at row {row} from {start}, {forward}, {lasting}"))
    });
}

#[test]
fn law_times_in_another_unit_are_never_silent() {
    none_is_silent(108, |draw| {
        let units = [("s", 1_i64), ("ms", 1000), ("us", 1_000_000), ("ns", 1_000_000_000)];
        let ((said, _), (_, per_second)) = (units[draw.below(4)], units[draw.below(4)]);
        let start = draw.below(2) as i64 * 1_744_373_300;
        let table = csv(60, |k| ((start + k as i64) * per_second).to_string());
        faulty(&format!("unit = \"{said}\""), POLICIES[draw.below(3)], table, 61)
            .what(format!("{per_second} as {said}"))
    });
}

#[test]
fn law_recordings_in_parts_are_never_silent() {
    none_is_silent(109, |draw| {
        let table = csv(60, |k| k.to_string());
        let (header, body) = table.split_once('\n').unwrap();
        let body: Vec<&str> = body.lines().collect();
        let (middle, overlap) = (draw.between(1, 60), [0, 0, 1, 2, 5, 60][draw.below(6)]);
        let first = format!("{header}\n{}\n", body[..middle].join("\n"));
        let second = format!("{header}\n{}\n", body[middle.saturating_sub(overlap)..].join("\n"));
        let config = table_config("*.csv", "unit = \"s\"", POLICIES[draw.below(3)])
            .replace("time =", "run_from_file = \"{run}_*.csv\"\ntime =");
        let names = [["a_0.csv", "a_1.csv"], ["a_9.csv", "a_10.csv"], ["a_b.csv", "a_a.csv"]][draw.below(3)];
        let mut faulty = Faulty::new(&config, names[0], first, 61);
        faulty.files.push((names[1].to_owned(), second.into_bytes()));
        faulty
            .named(&["repeated", "backwards", "sorted"])
            .what(format!("at {middle}, {overlap} twice, {names:?}"))
    });
}

#[test]
fn law_another_separator_or_decimal_is_never_silent() {
    none_is_silent(110, |draw| {
        let table = csv(60, |k| format!("{k}.0"));
        let decimal = ['.', ',', '\''][draw.below(3)];
        let separator = [',', ';', '\t', '|', ' '][draw.below(5)];
        let text: String = table
            .chars()
            .map(|c| match c {
                '.' => decimal,
                ',' => separator,
                c => c,
            })
            .collect();
        faulty("unit = \"s\"", "", text, 61).what(format!("{decimal:?} and {separator:?}"))
    });
}
