//! Texts that are no tables, recognized by their first line.

/// What converts frames of a CAN bus.
const CANDUMP: &str = "decode a PGN by canboat, here headings: `candump2analyzer < FILE | analyzer -json | \
     jq -r 'select(.pgn == 127250) | [.timestamp, .fields.Heading] | @csv' > FILE.csv`, or others by `cantools decode`";
/// What converts messages of NMEA 2000.
pub(crate) const N2K: &str = "decode a PGN by canboat, here headings: `analyzer -json < FILE | jq -r 'select(.pgn == 127250) | \
     [.timestamp, .fields.Heading] | @csv' > FILE.csv`";

/// What converts messages of canboat.
const CANBOAT: &str = "take the fields of a PGN, here headings: `jq -r 'select(.pgn == 127250) | [.timestamp, .fields.Heading] | @csv' \
     FILE > FILE.csv`, or all: `python3 -c \"import pandas; pandas.read_json('FILE', lines=True).to_csv('FILE.csv', index=False)\"`";
const JSON_LINES: &str = "convert it to CSV, a row per time: `python3 -c \"import pandas; pandas.read_json('FILE', \
     lines=True).to_csv('FILE.csv', index=False)\"`";
const JSON: &str = "convert it to CSV, a row per time: `python3 -c \"import pandas; pandas.read_json('FILE').to_csv('FILE.csv', \
     index=False)\"`";

/// Text that is not a table.
pub(crate) fn text(head: &str) -> Option<(&'static str, &'static str)> {
    let small = head.get(..15).unwrap_or(head).to_ascii_lowercase();
    if small.starts_with("<!doctype html") || small.starts_with("<html") {
        return Some(("a page in HTML", "download the file itself, or save the table as CSV"));
    }
    if small.starts_with("<?xml") {
        return Some(("a file in XML, such as GPX or KML", "export it as CSV, a row per time"));
    }
    nmea_2000(head).or_else(|| json(head))
}

/// Messages of NMEA 2000; lines that begin with # come before them.
pub(crate) fn nmea_2000(head: &str) -> Option<(&'static str, &'static str)> {
    let mut lines = head.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let line = lines.next()?;
    if line.starts_with('{')
        && [line, lines.next().unwrap_or_default()].iter().any(|own| own.contains("\"pgn\":"))
    {
        return Some(("messages of NMEA 2000 as JSON (canboat)", CANBOAT));
    }
    if is_actisense(line) || is_yacht_devices(line) {
        return Some(("messages of NMEA 2000 as text", N2K));
    }
    is_candump(line).then_some(("frames of a CAN bus (candump), such as NMEA 2000", CANDUMP))
}

/// JSON, whole or line by line.
fn json(head: &str) -> Option<(&'static str, &'static str)> {
    let mut signs = head.chars().filter(|c| !c.is_whitespace());
    if !matches!((signs.next(), signs.next()), (Some('{'), Some('"')) | (Some('['), Some('{' | '['))) {
        return None;
    }
    let mut lines = head.lines().map(str::trim).filter(|line| !line.is_empty());
    let is_by_line = lines.next().is_some_and(|line| line.ends_with(['}', ']'])) && lines.next().is_some();
    Some(match is_by_line {
        true => ("a file in JSON, line by line", JSON_LINES),
        false => ("a file in JSON", JSON),
    })
}

/// `A173321.107 23FF7 1F513 012F3070002F30709F`: time, addresses, number, data; or the same with commas after a date.
fn is_actisense(line: &str) -> bool {
    let is_hex = |word: &&str| word.bytes().all(|b| b.is_ascii_hexdigit());
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let is_time = |word: &str| {
        let time = word.strip_prefix('A').unwrap_or_default();
        time.len() > 6 && time.bytes().all(|b| b.is_ascii_digit() || b == b'.')
    };
    if let [time, rest @ ..] = words.as_slice()
        && rest.len() == 3
        && is_time(time)
    {
        return rest.iter().all(is_hex);
    }
    let cells: Vec<&str> = line.split(',').collect();
    let is_number = |cell: &&str| cell.parse::<u32>().is_ok();
    match cells.as_slice() {
        [time, numbers @ ..] if numbers.len() > 5 && time.contains('-') => {
            let (head, data) = numbers.split_at(5);
            let count = head[4].parse::<usize>().ok();
            // Numbers of parameter groups begin there.
            let is_group = head[1].parse::<u32>().is_ok_and(|number| number >= 59_392);
            is_group
                && head.iter().all(is_number)
                && count == Some(data.len())
                && data.iter().all(|byte| byte.len() == 2 && is_hex(byte))
        }
        _ => false,
    }
}

/// `17:33:21.107 R 19F51323 01 2F 30 70`: time, direction, address, data.
fn is_yacht_devices(line: &str) -> bool {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let is_hex =
        |word: &str, digits: usize| word.len() == digits && word.bytes().all(|b| b.is_ascii_hexdigit());
    match words.as_slice() {
        [time, "R" | "T", address, data @ ..] => {
            time.contains(':') && is_hex(address, 8) && data.iter().all(|byte| is_hex(byte, 2))
        }
        _ => false,
    }
}

/// `(1436509052.249713) can0 044#2A36`, or `can0  044   [2]  2A 36`.
fn is_candump(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace().peekable();
    let is_stamped = words.next_if(|word| word.starts_with('(') && word.ends_with(')')).is_some();
    let bus = words.next().unwrap_or_default().trim_end_matches(|c: char| c.is_ascii_digit());
    let is_frame = |word: &str| {
        let is_hex = |part: &str| part.bytes().all(|b| b.is_ascii_hexdigit());
        word.split_once('#')
            .is_some_and(|(id, data)| id.len() >= 3 && is_hex(id) && is_hex(data.trim_matches('#')))
    };
    // Without a stamp the bus must be called so, and have a number.
    let is_bus =
        ["can", "vcan", "slcan"].contains(&bus) && !line.trim_start().starts_with(&format!("{bus} "));
    let mut rest = words.take(6);
    (is_stamped || is_bus)
        && rest.any(|word| is_frame(word) || is_bus && word.starts_with('[') && word.ends_with(']'))
}
