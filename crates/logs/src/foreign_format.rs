//! Formats that are not read, recognized by their first bytes: their names and what converts them.

use refusal::Invalid;

use crate::Format;

/// Bytes that suffice to recognize all of them.
pub const SNIFFED: usize = 4096;

/// A format: the offset of its signature, the signature, its name, what converts it.
struct Signature(usize, &'static [u8], &'static str, &'static str);

const SHEET: &str = "save its sheet as CSV";
const UNPACK: &str = "unpack it, or compress the text with gzip instead";
const H5: &str = "write its arrays as CSV or Parquet: h5py, or xarray with `.to_dataframe().to_csv(…)`";
const MAT: &str = "convert its columns: `python3 -c \"import scipy.io, pandas; m = scipy.io.loadmat('FILE', squeeze_me=True); \
     pandas.DataFrame({k: v for k, v in m.items() if getattr(v, 'ndim', 0) == 1}).to_csv('FILE.csv', index=False)\"`";
const MAT_73: &str = "convert its columns: `python3 -c \"import h5py, pandas; f = h5py.File('FILE'); \
     pandas.DataFrame({k: v[()].ravel() for k, v in f.items() if hasattr(v, 'shape')}).to_csv('FILE.csv', index=False)\"`";
const FRAME: &str = "convert it to Parquet: pandas or pyarrow read it and have `to_parquet`";
const DECODE: &str = "decode its messages to CSV, a column per signal";
const MAVLINK: &str = "convert it: `mavlogdump.py --format csv --types TYPE FILE` of pymavlink";
const MDF: &str = "convert it: `asammdf`, or export it as CSV";
const UBX: &str = "convert its messages to CSV, or log NMEA 0183";

/// Containers and binary logs, whatever their file names.
const BYTES: &[Signature] = &[
    Signature(0, b"\xA3\x95", "a log of ArduPilot", MAVLINK),
    Signature(0, b"MATLAB 7.3 MAT-file", "a MATLAB file of version 7.3", MAT_73),
    Signature(0, b"MATLAB 5.0 MAT-file", "a MATLAB file", MAT),
    Signature(0, b"# Created by Octave", "text of Octave", "save its columns as CSV: `csvwrite`"),
    Signature(0, b"\x10\x02\x93", "messages of NMEA 2000 (Actisense)", N2K),
    Signature(0, b"\x89HDF\r\n\x1A\n", "an HDF5 file, such as NetCDF 4 or MATLAB 7.3", H5),
    Signature(0, b"CDF\x01", "a NetCDF file", H5),
    Signature(0, b"CDF\x02", "a NetCDF file", H5),
    Signature(0, b"CDF\x05", "a NetCDF file", H5),
    Signature(0, b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", "an Excel workbook (.xls)", SHEET),
    Signature(0, b"\x1F\x8B", "a file compressed with gzip", "let its name end with .gz, as in `a.csv.gz`"),
    Signature(0, b"\x28\xB5\x2F\xFD", "a file compressed with zstd", "unpack it with `zstd -d`"),
    Signature(0, b"BZh", "a file compressed with bzip2", "unpack it with `bunzip2`"),
    Signature(0, b"\xFD7zXZ\0", "a file compressed with xz", "unpack it with `unxz`"),
    Signature(0, b"\x04\x22\x4D\x18", "a file compressed with LZ4", "unpack it with `unlz4`"),
    Signature(0, b"7z\xBC\xAF\x27\x1C", "an archive of 7-Zip", UNPACK),
    Signature(0, b"Rar!\x1A\x07", "an archive of RAR", UNPACK),
    Signature(257, b"ustar", "an archive of tar", UNPACK),
    Signature(0, b"\xD4\xC3\xB2\xA1", "captured packets (pcap)", DECODE),
    Signature(0, b"\xA1\xB2\xC3\xD4", "captured packets (pcap)", DECODE),
    Signature(0, b"\x4D\x3C\xB2\xA1", "captured packets (pcap)", DECODE),
    Signature(0, b"\xA1\xB2\x3C\x4D", "captured packets (pcap)", DECODE),
    Signature(0, b"\x0A\x0D\x0D\x0A", "captured packets (pcapng)", DECODE),
    Signature(0, b"MDF     ", "a measurement file of ASAM (MDF)", MDF),
    Signature(0, b"LOGG", "a log of Vector (BLF)", DECODE),
    Signature(0, b"TDSm", "a TDMS file of LabVIEW", "convert it: nptdms in Python, or export it as CSV"),
    Signature(0, b"Obj\x01", "an Avro file", FRAME),
    Signature(0, b"ARROW1\0\0", "an Arrow file (Feather)", FRAME),
    Signature(0, b"FEA1", "a Feather file", FRAME),
    Signature(0, b"ORC", "an ORC file", FRAME),
    Signature(0, b"\x93NUMPY", "an array of NumPy", "write it as CSV with `numpy.savetxt`"),
    Signature(0, b"%PDF-", "a PDF", "export the table as CSV"),
    Signature(0, b"\xFF\xFE\0\0", "text in UTF-32", "save it as UTF-8"),
    Signature(0, b"\0\0\xFE\xFF", "text in UTF-32", "save it as UTF-8"),
    Signature(0, b"{\\rtf", "a document in rich text", "save it as plain text"),
];

/// Binary messages of receivers, which may stand between sentences.
const MESSAGES: &[Signature] = &[
    Signature(0, b"\xB5\x62", "messages of u-blox (UBX)", UBX),
    Signature(0, b"\xD3\0", "messages of RTCM 3", UBX),
    Signature(0, b"\xAA\x44", "messages of NovAtel", UBX),
    Signature(0, b"$@", "messages of Septentrio (SBF)", UBX),
];

const OTHER_FORMAT: &str = "set `format` of its [[file]], or name the file so";

/// Formats that are read, in a file that is declared or named as another.
const READ_FORMATS: &[(Format, Signature)] = &[
    (Format::Parquet, Signature(0, b"PAR1", "a Parquet file", OTHER_FORMAT)),
    (Format::Mcap, Signature(0, b"\x89MCAP0\r\n", "a bag of MCAP", OTHER_FORMAT)),
    (Format::Bag, Signature(0, b"#ROSBAG V", "a ROS 1 bag", OTHER_FORMAT)),
    (
        Format::Db3,
        Signature(0, b"SQLite format 3\0", "an SQLite database, such as bags of ROS 2 in .db3", OTHER_FORMAT),
    ),
    (Format::Ulg, Signature(0, b"ULog\x01\x12\x35", "a ULog of PX4", OTHER_FORMAT)),
];

impl Signature {
    fn is(&self, head: &[u8]) -> bool {
        head.get(self.0..).is_some_and(|rest| rest.starts_with(self.1))
    }

    fn refused(&self, format: Format) -> Invalid {
        refused(self.2, format, self.3)
    }
}

/// The refusal of a file that begins with `head` if that shows another format than `format`. Unreadable text
/// is recognized only where `is_from_top`: no lines are skipped.
pub fn foreign_format(head: &[u8], format: Format, is_from_top: bool) -> Option<Invalid> {
    let own_format = READ_FORMATS.iter().find(|(_, own_format)| own_format.is(head));
    if let Some((recognized, own_format)) = own_format {
        return (*recognized != format).then(|| own_format.refused(format));
    }
    let messages = if format == Format::Nmea { &[] } else { MESSAGES };
    if let Some(known) = BYTES.iter().chain(messages).find(|known| known.is(head)) {
        return Some(known.refused(format));
    }
    if let Some((content, remedy)) = archive(head).or_else(|| unmarked(head)) {
        return Some(refused(content, format, remedy));
    }
    match format {
        Format::Csv if is_from_top => {
            text(&readable(head)).map(|(content, remedy)| refused(content, format, remedy))
        }
        // Sentences may follow lines of another kind.
        Format::Nmea => nmea_2000(&readable(head)).map(|(content, remedy)| refused(content, format, remedy)),
        Format::Parquet | Format::Mcap | Format::Bag | Format::Db3 | Format::Ulg
            if !head.is_empty() && is_text(head) =>
        {
            Some(refused("text", format, OTHER_FORMAT))
        }
        _ => None,
    }
}

fn refused(found: &str, format: Format, remedy: &str) -> Invalid {
    let expected = match format {
        Format::Csv => "text with a row per line (CSV)",
        Format::Parquet => "a Parquet file",
        Format::Nmea => "sentences of NMEA 0183",
        Format::Mcap => "a bag of MCAP",
        Format::Bag => "a bag of ROS 1",
        Format::Db3 => "a bag of ROS 2 in SQLite",
        Format::Ulg => "a ULog of PX4",
    };
    Invalid::new("format", found, expected, remedy)
}

/// What a zip archive contains, by the names at its beginning.
fn archive(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let has = |name: &[u8]| head.windows(name.len()).any(|part| part == name);
    match head.starts_with(b"PK\x03\x04") {
        false => None,
        true if has(b"[Content_Types].xml") || has(b"xl/") => Some(("an Excel workbook (.xlsx)", SHEET)),
        true if has(b"opendocument.spreadsheet") => Some(("a workbook of OpenDocument (.ods)", SHEET)),
        true if has(b".npy") => Some(("arrays of NumPy (.npz)", "write them as CSV with `numpy.savetxt`")),
        true => Some(("an archive of zip", UNPACK)),
    }
}

/// Formats without a signature.
fn unmarked(head: &[u8]) -> Option<(&'static str, &'static str)> {
    if is_matlab_4(head) {
        return Some(("a MATLAB file of version 4", MAT));
    }
    let (fours, _) = head[..head.len().min(256)].as_chunks::<4>();
    let zeros = |places: [usize; 3]| {
        fours.len() > 1 && fours.iter().all(|four| places.iter().all(|place| four[*place] == 0))
    };
    if (zeros([0, 1, 2]) || zeros([1, 2, 3])) && head.iter().any(|byte| *byte != 0) {
        return Some(("text in UTF-32", "save it as UTF-8"));
    }
    // Microseconds since 1970 before each message, from 2000 to 2100.
    let stamp = head.first_chunk().map(|stamp| u64::from_be_bytes(*stamp));
    let dated = stamp.is_some_and(|us| (946_684_800_000_000..4_102_444_800_000_000).contains(&us));
    if dated && matches!(head.get(8), Some(0xFD | 0xFE)) {
        let remedy = "convert it: `mavlogdump.py --format csv --types TYPE FILE` of pymavlink";
        return Some(("a telemetry log of MAVLink (tlog)", remedy));
    }
    let is_pickle = matches!(head, [0x80, 2..=5, ..]) && !is_text(head);
    is_pickle.then_some(("a pickle of Python", "write the data as CSV or Parquet"))
}

/// A header of five numbers, least or most significant byte first, then the name of an array.
fn is_matlab_4(head: &[u8]) -> bool {
    let Some((numbers, name)) = head.split_first_chunk::<20>() else { return false };
    let is_header = |from: fn([u8; 4]) -> u32, order: u32| {
        let [kind, _, _, imaginary, length] = [0, 1, 2, 3, 4].map(|i| from(numbers.as_chunks::<4>().0[i]));
        let name = name.iter().take(length as usize).take_while(|c| c.is_ascii_alphanumeric() || **c == b'_');
        let (is_named, is_kind) =
            (length > 1 && name.count() + 1 == length as usize, kind.wrapping_sub(order) < 60);
        is_kind && kind % 10 < 3 && imaginary < 2 && is_named
    };
    is_header(u32::from_le_bytes, 0) || is_header(u32::from_be_bytes, 1000)
}

/// The beginning of a text, also in UTF-16.
fn readable(head: &[u8]) -> String {
    let head: Vec<u8> = head.iter().copied().filter(|byte| *byte != 0).collect();
    let text = String::from_utf8_lossy(&head);
    text.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{feff}' || c == '\u{fffd}').to_owned()
}

/// Whether nothing in it occurs only in other files.
fn is_text(head: &[u8]) -> bool {
    let is_odd = |byte: &u8| *byte < 0x20 && !b"\t\r\n\x0c\x1b".contains(byte) || *byte == 0x7F;
    let odd = head.iter().filter(|byte| is_odd(byte)).count();
    let after = head.len().saturating_sub(4);
    let is_utf8 = match std::str::from_utf8(head) {
        Ok(_) => true,
        Err(wrong) => wrong.valid_up_to() >= after,
    };
    odd == 0 && is_utf8
}

/// What converts frames of a CAN bus.
const CANDUMP: &str = "decode a PGN by canboat, here headings: `candump2analyzer < FILE | analyzer -json | \
     jq -r 'select(.pgn == 127250) | [.timestamp, .fields.Heading] | @csv' > FILE.csv`, or others by `cantools decode`";
/// What converts messages of NMEA 2000.
const N2K: &str = "decode a PGN by canboat, here headings: `analyzer -json < FILE | jq -r 'select(.pgn == 127250) | \
     [.timestamp, .fields.Heading] | @csv' > FILE.csv`";

/// What converts messages of canboat.
const CANBOAT: &str = "take the fields of a PGN, here headings: `jq -r 'select(.pgn == 127250) | [.timestamp, .fields.Heading] | @csv' \
     FILE > FILE.csv`, or all: `python3 -c \"import pandas; pandas.read_json('FILE', lines=True).to_csv('FILE.csv', index=False)\"`";
const JSON_LINES: &str = "convert it to CSV, a row per time: `python3 -c \"import pandas; pandas.read_json('FILE', \
     lines=True).to_csv('FILE.csv', index=False)\"`";
const JSON: &str = "convert it to CSV, a row per time: `python3 -c \"import pandas; pandas.read_json('FILE').to_csv('FILE.csv', \
     index=False)\"`";

/// Text that is not a table.
fn text(head: &str) -> Option<(&'static str, &'static str)> {
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
fn nmea_2000(head: &str) -> Option<(&'static str, &'static str)> {
    let mut lines = head.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let line = lines.next()?;
    if line.starts_with('{')
        && [line, lines.next().unwrap_or_default()].iter().any(|message| message.contains("\"pgn\":"))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn content(head: &[u8], format: Format) -> String {
        foreign_format(head, format, true).map_or_else(String::new, |invalid| invalid.to_string())
    }

    #[test]
    fn formats_are_known_by_their_first_bytes_in_one_short_line_each() {
        for known in BYTES.iter().chain(MESSAGES) {
            let head = [&vec![b'x'; known.0], known.1, &[0; 40]].concat();
            let said = content(&head, Format::Csv);
            assert!(said.contains(known.2) && said.len() < 400, "{said}");
        }
        for (head, said) in [
            (&b"PK\x03\x04..[Content_Types].xml"[..], "Excel"),
            (b"PK\x03\x04..a.csv", "zip"),
            (b"a\0\0\0,\0\0\0b\0\0\0\n\0\0\0", "UTF-32"),
            (b"\0\x05\x18\x40\x10\0\0\0\xFE..", "MAVLink"),
            (b"\n {\"t\": [0, 1]}", "JSON"),
            (b"\xEF\xBB\xBF<?xml version='1.0'?>", "XML"),
            (b"(1436509052.249713) vcan0 044#2A366C2BBA\n", "candump"),
            (b"  can0  123   [2]  01 02\n", "candump"),
            (b"A173321.107 23FF7 1F513 012F3070002F30709F\n", "NMEA 2000"),
            (b"2011-11-24-22:42:04.388,2,127251,36,255,8,7d,0b,7d,02,00,ff,ff,ff\n", "NMEA 2000"),
            (b"# format=FAST\n2016-02-28T19:57:02.364Z,2,127250,67,255,3,00,05,7d\n", "NMEA 2000"),
            (b" (010.000042)  can0  TX - -  09F11207   [2]  00 E0\n", "candump"),
            (b"(1744362500.000000) n2k 09F11207#00E02EFF7FFF7FFC R\n", "candump"),
            (b"17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70\n", "NMEA 2000"),
            (b"{\"timestamp\":\"2016-02-28\",\"prio\":2,\"pgn\":127250,\"fields\":{}}\n", "canboat"),
            (b"{\"version\":\"4.2\",\"units\":\"si\"}\n{\"prio\":2,\"pgn\":127250}\n", "canboat"),
            (b"{\"t\":0}\n{\"t\":1}\n", "lines=True"),
            (b"\0\0\0\0\x3d\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0t\0\0\0", "MATLAB"),
            (b"\0\0\x03\xE8\0\0\0\x3d\0\0\0\x01\0\0\0\0\0\0\0\x02t\0\0\0", "MATLAB"),
            (b"PAR1....", "Parquet"),
            (b"\x89MCAP0\r\n", "MCAP"),
            (b"#ROSBAG V2.0\n", "ROS 1"),
            (b"SQLite format 3\0", "SQLite"),
            (b"ULog\x01\x12\x35\x01", "ULog"),
        ] {
            assert!(content(head, Format::Csv).contains(said), "{said}: {}", content(head, Format::Csv));
        }
        assert!(content(b"t,u\n0,1\n", Format::Mcap).contains("text"));
    }

    #[test]
    fn tables_and_sentences_are_none_of_them() {
        for text in [
            "",
            "t,u\n",
            "(a) b,c\n",
            "can0,1\n",
            "{a},b\n",
            "[s],[m]\n",
            "MATLAB,1\n",
            "time;\0\0",
            "A1 2 3 4\n",
            "# t,u\nt,u\n0,1\n",
            "12:00:01.5 R 1 2\n",
        ] {
            assert_eq!(content(text.as_bytes(), Format::Csv), "", "{text}");
        }
        for text in ["{\"class\":\"VERSION\"}\n$GPRMC,\n", "\u{b5}b$GPGGA", "$GPRMC,1\n"] {
            assert_eq!(content(text.as_bytes(), Format::Nmea), "", "{text}");
        }
        assert_eq!(content(b"PAR1", Format::Parquet), "");
    }
}
