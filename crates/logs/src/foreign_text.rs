//! Texts that are no tables, recognized by their first line.

/// What converts frames of a CAN bus.
const CANDUMP: &str = "decode a PGN by canboat, here headings: `candump2analyzer < FILE | analyzer -json | \
     jq -r 'select(.pgn == 127250) | [.timestamp, .fields.Heading] | @csv' > FILE.csv`, or others by `cantools decode`";
/// What converts messages of NMEA 2000.
pub(crate) const N2K: &str = "decode a PGN by canboat, here headings: `analyzer -json < FILE | jq -r 'select(.pgn == 127250) | \
     [.timestamp, .fields.Heading] | @csv' > FILE.csv`";

/// Text that is not a table.
pub(crate) fn text(head: &str) -> Option<(&'static str, &'static str)> {
    let small = head.get(..15).unwrap_or(head).to_ascii_lowercase();
    if small.starts_with("<!doctype html") || small.starts_with("<html") {
        return Some(("a page in HTML", "download the file itself, or save the table as CSV"));
    }
    if small.starts_with("<?xml") {
        return Some(("a file in XML, such as GPX or KML", "export it as CSV, a row per time"));
    }
    let mut signs = head.chars().filter(|c| !c.is_whitespace());
    if matches!((signs.next(), signs.next()), (Some('{'), Some('"')) | (Some('['), Some('{' | '['))) {
        return Some((
            "a file in JSON",
            "convert it to CSV, a row per time: `pandas.read_json(…).to_csv(…)`",
        ));
    }
    if is_actisense(head) {
        return Some(("messages of NMEA 2000 as text (Actisense)", N2K));
    }
    is_candump(head).then_some(("frames of a CAN bus (candump), such as NMEA 2000", CANDUMP))
}

/// `A173321.107 23FF7 1F513 012F3070002F30709F`: time, addresses, number, data; or the same with commas after a date.
fn is_actisense(head: &str) -> bool {
    let line = head.lines().next().unwrap_or_default();
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

/// `(1436509052.249713) can0 044#2A36`, or `can0  044   [2]  2A 36`.
fn is_candump(head: &str) -> bool {
    let mut words = head.lines().next().unwrap_or_default().split_ascii_whitespace();
    let mut first = words.next().unwrap_or_default();
    let is_stamped = first.starts_with('(') && first.ends_with(')');
    if is_stamped {
        first = words.next().unwrap_or_default();
    }
    let is_bus = ["can", "vcan", "slcan"].iter().any(|bus| {
        first.strip_prefix(bus).is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    });
    let (frame, length) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    is_bus && (frame.contains('#') || length.starts_with('[') && length.ends_with(']'))
}
