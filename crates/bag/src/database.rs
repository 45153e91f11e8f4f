//! Bags of ROS 2 in SQLite (`.db3`): tables of topics, of messages and, in newer ones, of message definitions.
//! <https://github.com/ros2/rosbag2/tree/rolling/rosbag2_storage_sqlite3>

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};

use refusal::Invalid;

use crate::BagError;
use crate::chunks::LARGEST;
use crate::parts::Part;
use crate::sqlite::{COPY, Database, Value};

/// Passes the topics of a bag and the messages of `topic`, or of all, to `each`.
///
/// # Errors
/// Bytes that cannot be read, are not a bag, or end early; refusals of `each`.
pub(crate) fn each_part(
    file: &mut (impl Read + Seek),
    topic: Option<&str>,
    each: &mut dyn FnMut(Part) -> Result<(), BagError>,
) -> Result<(), BagError> {
    let mut database = Database::open(file)?;
    let tables = tables(&mut database)?;
    let definitions = match tables.get("message_definitions") {
        Some(table) => definitions(&mut database, table)?,
        None => BTreeMap::new(),
    };
    let table = named(&tables, "topics")?;
    let places = table.places(["name", "type", "serialization_format"])?;
    let mut wanted = BTreeSet::new();
    database.rows(table.root, &|_| true, &mut |row, values| {
        let [Value::Text(name), Value::Text(kind), Value::Text(encoding)] = table.of(&values, places)? else {
            return Err(wrong("topics").into());
        };
        let id = u32::try_from(row).map_err(|_| wrong("topics"))?;
        if topic.is_none_or(|topic| topic == name) {
            wanted.insert(row);
        }
        let (own, text) = definitions.get(kind).map_or(("", ""), |(own, text)| (own, text));
        each(Part::Schema { id, name: kind, encoding: own, data: text.as_bytes() })?;
        each(Part::Channel { id, number: id, schema: id, topic: name, encoding, metadata: Vec::new() })
    })?;
    messages(&mut database, named(&tables, "messages")?, &wanted, each)
}

fn messages(
    database: &mut Database<impl Read + Seek>,
    table: &Table,
    wanted: &BTreeSet<i64>,
    each: &mut dyn FnMut(Part) -> Result<(), BagError>,
) -> Result<(), BagError> {
    let places = table.places(["topic_id", "timestamp", "data"])?;
    let is_wanted = |values: &[Value]| match values.get(places[0]) {
        Some(Value::Integer(topic)) => wanted.contains(topic),
        _ => true,
    };
    database.rows(table.root, &is_wanted, &mut |_, values| {
        let [Value::Integer(topic), Value::Integer(time), Value::Bytes(data)] = table.of(&values, places)?
        else {
            return Err(wrong("messages").into());
        };
        if !wanted.contains(topic) {
            return Ok(());
        }
        let channel = u32::try_from(*topic).map_err(|_| wrong("messages"))?;
        let log_time = u64::try_from(*time).map_err(|_| wrong("messages"))?;
        // Messages may be compressed one by one: plain ones begin with a zero.
        let unpacked = data.starts_with(b"\x28\xB5\x2F\xFD").then(|| unpacked(data)).transpose()?;
        let data = unpacked.as_ref().unwrap_or(data);
        each(Part::Message { channel, log_time, publish_time: log_time, data })
    })
}

/// A message that is compressed by itself.
fn unpacked(data: &[u8]) -> Result<Vec<u8>, Invalid> {
    let mut message = Vec::new();
    let read = zstd::stream::read::Decoder::new(data)
        .and_then(|all| all.take(LARGEST as u64 + 1).read_to_end(&mut message));
    if read.is_err() || message.len() > LARGEST {
        return Err(Invalid::new("message", "bytes that cannot be unpacked", "a whole bag of ROS 2", COPY));
    }
    Ok(message)
}

/// Encoding and text of each type's definition.
fn definitions(
    database: &mut Database<impl Read + Seek>,
    table: &Table,
) -> Result<BTreeMap<String, (String, String)>, BagError> {
    let places = table.places(["topic_type", "encoding", "encoded_message_definition"])?;
    let mut all = BTreeMap::new();
    database.rows(table.root, &|_| true, &mut |_, values| match table.of(&values, places)? {
        [Value::Text(kind), Value::Text(encoding), Value::Text(text)] => {
            all.insert(kind.clone(), (encoding.clone(), text.clone()));
            Ok(())
        }
        _ => Err(wrong("message_definitions").into()),
    })?;
    Ok(all)
}

/// A table: the page that its tree begins at, and its columns.
struct Table {
    name: String,
    root: u32,
    columns: Vec<String>,
}

impl Table {
    fn places<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N], Invalid> {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            let found = self.columns.iter().position(|own| own == name);
            *place = found.ok_or_else(|| no_bag(&format!("no `{name}` in the table `{}`", self.name)))?;
        }
        Ok(places)
    }

    fn of<'a, const N: usize>(
        &self,
        values: &'a [Value],
        places: [usize; N],
    ) -> Result<[&'a Value; N], Invalid> {
        match places.iter().all(|place| *place < values.len()) {
            true => Ok(places.map(|place| &values[place])),
            false => Err(wrong(&self.name)),
        }
    }
}

/// The tables by name.
fn tables(database: &mut Database<impl Read + Seek>) -> Result<BTreeMap<String, Table>, BagError> {
    let mut tables = BTreeMap::new();
    database.rows(1, &|_| true, &mut |_, values| {
        if let [Value::Text(kind), Value::Text(name), _, Value::Integer(root), Value::Text(sql)] =
            values.as_slice()
            && kind == "table"
        {
            let inside = sql.split_once('(').map_or("", |(_, inside)| inside);
            let column = |part: &str| part.split_whitespace().next().unwrap_or_default().to_owned();
            let columns = inside.split(',').map(|part| column(part).trim_matches('"').to_owned()).collect();
            let root = u32::try_from(*root).map_err(|_| wrong(name))?;
            tables.insert(name.clone(), Table { name: name.clone(), root, columns });
        }
        Ok(())
    })?;
    Ok(tables)
}

fn named<'a>(tables: &'a BTreeMap<String, Table>, name: &str) -> Result<&'a Table, Invalid> {
    tables.get(name).ok_or_else(|| no_bag(&format!("no table `{name}`")))
}

fn no_bag(found: &str) -> Invalid {
    let remedy = "export the table that you need as CSV: `sqlite3 -header -csv FILE 'SELECT * FROM TABLE'`";
    Invalid::new("database", found, "a bag of ROS 2 with `topics` and `messages`", remedy)
}

fn wrong(table: &str) -> Invalid {
    Invalid::new("file", format!("a row of `{table}` that cannot be read"), "a whole bag of ROS 2", COPY)
}
