//! Bags of robots: files with topics, each of which has messages. [`each_message`] passes the messages of a topic on with
//! the numbers at the wanted paths, [`census`] says what is in a file. Each kind of file has a reader that passes
//! parts on: MCAP, bags of ROS 1, those of ROS 2 in SQLite, ULog.
//!
//! The crate `mcap` finds the records of MCAP, SQLite the rows of a `.db3`; all others are parsed and chunks decompressed
//! here, where their lengths are not trusted. What a bag may cost is counted in one place, [`effort`]. Messages are decoded by the definition in the bag, or they are JSON.

mod bag_error;
mod binary;
mod census;
mod channels;
mod chunks;
mod database;
mod decoder;
mod definition;
mod effort;
mod fields;
mod formats;
mod json;
mod known;
mod parts;
mod reading;
mod records;
mod rest;
mod rosbag;
mod stream;
mod ulog;

pub use bag_error::BagError;
pub use census::{Topic, census, census_of_database};
pub use database::DatabaseFile;
pub use reading::{Message, Wanted, each_message, each_message_of_database};
pub use stream::Format;
