//! Bags of ROS 2 in SQLite (`.db3`): tables of topics, of messages and, in newer ones, of message definitions.
//! <https://github.com/ros2/rosbag2/tree/rolling/rosbag2_storage_sqlite3>
//!
//! SQLite reads them, and is trusted with damaged files. What it may do is limited: it writes nothing, not beside the file either,
//! runs nothing that the schema holds, and fetches rows only when those of the whole table fit into the file.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;

use refusal::{Invalid, foreign};
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error, ErrorCode, OpenFlags, Row};

use super::{BagPart, Effort};
use crate::LogError;

/// Instructions of SQLite's machine that a byte of the file pays for, those in any case, and after how many they are
/// counted. A row of a bag takes ten for its twenty bytes.
const PER_BYTE: u64 = 4;
const UNPAID: u64 = 1 << 20;
const AT_A_TIME: u64 = 1000;

/// Most tables and indices, columns of one, and bytes of its declaration.
const LIMITS: [(Limit, i32); 3] = [
    (Limit::SQLITE_LIMIT_SCHEMA, 1000),
    (Limit::SQLITE_LIMIT_COLUMN, 200),
    (Limit::SQLITE_LIMIT_SQL_LENGTH, 1 << 20),
];

/// Switches of SQLite, so that nothing in a file is run.
const SWITCHES: [(DbConfig, bool); 4] = [
    (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
    (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
    (DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW, false),
    (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
];

/// The remedy for damage.
const COPY: &str =
    "the file is truncated or damaged: copy it again, or mend it with `sqlite3 FILE '.recover'`";

const WHOLE: &str = "a whole bag of ROS 2";

/// An SQLite file that does not change while it is read.
#[derive(Clone, Debug)]
pub struct DatabaseFile {
    /// Where it is, as the part of a URI after `file:`, each byte but letters and digits as `%` and two digits.
    pub address: String,
    /// How long it is.
    pub bytes: u64,
}

/// Passes the topics of a bag and the messages of `topic`, or of all, to `each`.
pub(crate) fn each_part(
    file: &DatabaseFile,
    topic: Option<&str>,
    effort: &Effort,
    each: &mut dyn FnMut(BagPart) -> Result<(), LogError>,
) -> Result<(), LogError> {
    let database = Database { connection: connection(file, effort).map_err(damaged)?, bytes: file.bytes };
    let definitions = definitions(&database, effort)?;
    let mut wanted = BTreeSet::new();
    database.rows("topics", ["name", "type", "serialization_format"], "", |row, values| {
        let [Some(name), Some(kind), Some(encoding)] = values.map(text) else {
            return Err(wrong("topics").into());
        };
        let id = u32::try_from(row).map_err(|_| wrong("topics"))?;
        if topic.is_none_or(|topic| topic == name) {
            wanted.insert(row);
        }
        let (language, text) = definitions.get(&kind).map_or(("", ""), |(language, text)| (language, text));
        each(BagPart::Schema { id, name: &kind, encoding: language, data: text.as_bytes() })?;
        let (topic, encoding, metadata) = (name.as_str(), encoding.as_str(), Vec::new());
        each(BagPart::Channel { id, number: id, schema: id, topic, encoding, metadata })
    })?;
    let ids: Vec<String> = wanted.iter().map(i64::to_string).collect();
    let all = format!("WHERE topic_id IN ({}) OR typeof(topic_id) <> 'integer'", ids.join(", "));
    database.rows("messages", ["topic_id", "timestamp", "data"], &all, |_, values| {
        let [ValueRef::Integer(topic), ValueRef::Integer(time), ValueRef::Blob(data)] = values else {
            return Err(wrong("messages").into());
        };
        let channel = u32::try_from(topic).map_err(|_| wrong("messages"))?;
        let log_time = u64::try_from(time).map_err(|_| wrong("messages"))?;
        // Messages may be compressed one by one: plain ones begin with a zero.
        let unpacked = data.starts_with(b"\x28\xB5\x2F\xFD").then(|| unpacked(data, effort)).transpose()?;
        let data = unpacked.as_deref().unwrap_or(data);
        each(BagPart::Message { channel, log_time, publish_time: log_time, data })
    })
}

/// A message that is compressed by itself.
fn unpacked(data: &[u8], effort: &Effort) -> Result<Vec<u8>, Invalid> {
    let mut message = Vec::new();
    let read = zstd::stream::read::Decoder::new(data)
        .and_then(|all| all.take(effort.largest as u64 + 1).read_to_end(&mut message));
    if read.is_err() {
        return Err(Invalid::new("message", "bytes that cannot be unpacked", WHOLE, COPY));
    }
    effort.unpack(data.len(), message.len() as u64)?;
    Ok(message)
}

/// Encoding and text of each type's definition; older bags have none.
fn definitions(database: &Database, effort: &Effort) -> Result<BTreeMap<String, (String, String)>, LogError> {
    let (table, mut all) = ("message_definitions", BTreeMap::new());
    if !database.has(table).map_err(damaged)? {
        return Ok(all);
    }
    let columns = ["topic_type", "encoding", "encoded_message_definition"];
    database.rows(table, columns, "", |_, values| match values.map(text) {
        [Some(kind), Some(encoding), Some(text)] => {
            effort.keep(kind.len() + encoding.len() + text.len())?;
            all.insert(kind, (encoding, text));
            Ok(())
        }
        _ => Err(wrong(table).into()),
    })?;
    Ok(all)
}

/// Opens `file` without a lock, a journal or anything else beside it.
fn connection(file: &DatabaseFile, effort: &Effort) -> Result<Connection, Error> {
    let flags =
        [OpenFlags::SQLITE_OPEN_READ_ONLY, OpenFlags::SQLITE_OPEN_URI, OpenFlags::SQLITE_OPEN_NO_MUTEX];
    let address = format!("file:{}?immutable=1", file.address);
    let mut connection = Connection::open_with_flags(address, flags.into_iter().collect())?;
    SWITCHES.iter().try_for_each(|(switch, is_on)| connection.set_db_config(*switch, *is_on).map(drop))?;
    let row = [(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(effort.largest).unwrap_or(i32::MAX))];
    LIMITS.iter().chain(&row).try_for_each(|(limit, most)| connection.set_limit(*limit, *most).map(drop))?;
    let mut left = (file.bytes.saturating_mul(PER_BYTE) + UNPAID) / AT_A_TIME;
    connection.progress_handler(
        AT_A_TIME as i32,
        Some(move || {
            left = left.saturating_sub(1);
            left == 0
        }),
    )?;
    connection.pragma_update(None, "cell_size_check", true)?;
    Ok(connection)
}

/// An open file of tables.
struct Database {
    connection: Connection,
    bytes: u64,
}

impl Database {
    /// Whether there is a table `name`: no view, and no table of another module.
    fn has(&self, name: &str) -> Result<bool, Error> {
        const FIND: &str = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?1 AND rootpage > 0 \
                            AND sql LIKE 'CREATE TABLE %'";
        self.connection.query_row(FIND, [name], |row| Ok(row.get::<_, i64>(0)? > 0))
    }

    /// Passes number and `columns` of each row of `table` that is meant by `which` to `each`, in the order of their numbers.
    fn rows<const N: usize>(
        &self,
        table: &str,
        columns: [&str; N],
        which: &str,
        mut each: impl FnMut(i64, [ValueRef; N]) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        if !self.has(table).map_err(damaged)? {
            return Err(no_bag(&format!("no table `{table}`")).into());
        }
        let mut known = Vec::new();
        let name = |row: &Row| row.get("name").map(|name: String| known.push(name));
        // Generated columns are not in it.
        self.connection.pragma(None, "table_info", table, name).map_err(damaged)?;
        if let Some(column) = columns.iter().find(|column| !known.iter().any(|other| other == *column)) {
            return Err(no_bag(&format!("no `{column}` in the table `{table}`")).into());
        }
        let sizes = columns.map(|column| format!("ifnull(octet_length({column}), 0)")).join(" + ");
        let total = format!("SELECT total({sizes}) FROM {table} NOT INDEXED {which}");
        let total: f64 = self.connection.query_row(&total, [], |row| row.get(0)).map_err(damaged)?;
        // A page that several rows share, or that follows on itself, would be read again and again.
        if total > self.bytes as f64 {
            let size = format!("{total} bytes in the table `{table}` of a file of {}", self.bytes);
            return Err(Invalid::new("file", size, "a whole SQLite database", COPY).into());
        }
        let select = format!("SELECT rowid, {} FROM {table} NOT INDEXED {which}", columns.join(", "));
        let mut statement = self.connection.prepare(&select).map_err(damaged)?;
        let mut rows = statement.query([]).map_err(damaged)?;
        while let Some(row) = rows.next().map_err(damaged)? {
            let mut values = [ValueRef::Null; N];
            for (place, value) in values.iter_mut().enumerate() {
                *value = row.get_ref(place + 1).map_err(damaged)?;
            }
            each(row.get(0).map_err(damaged)?, values)?;
        }
        Ok(())
    }
}

fn text(value: ValueRef) -> Option<String> {
    value
        .as_bytes()
        .ok()
        .filter(|_| matches!(value, ValueRef::Text(_)))
        .map(|text| String::from_utf8_lossy(text).into_owned())
}

fn damaged(error: Error) -> LogError {
    let (problem, expected, remedy) = match error.sqlite_error_code() {
        Some(ErrorCode::TooBig) => (
            "a row that is too large".to_owned(),
            "rows of at most a quarter of the memory, and of 128 MiB",
            "record smaller messages, or raise --memory-mib",
        ),
        Some(ErrorCode::OperationInterrupted) => {
            ("more rows than its bytes hold".to_owned(), "a whole SQLite database", COPY)
        }
        _ => (foreign(&error.to_string()), "a whole SQLite database", COPY),
    };
    Invalid::new("file", problem, expected, remedy).into()
}

fn no_bag(found: &str) -> Invalid {
    let remedy = "export the table that you need as CSV: `sqlite3 -header -csv FILE 'SELECT * FROM TABLE'`";
    Invalid::new("database", found, "a bag of ROS 2 with `topics` and `messages`", remedy)
}

fn wrong(table: &str) -> Invalid {
    Invalid::new("file", format!("a row of `{table}` that cannot be read"), WHOLE, COPY)
}
