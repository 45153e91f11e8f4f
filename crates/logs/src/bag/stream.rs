//! Files that are read from beginning to end.

use std::io::Read;

use crate::bag::effort::Effort;
use crate::bag::parts::Part;
use crate::bag::{BagError, records, rosbag, ulog};

/// What a file is that is read from beginning to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MCAP.
    Mcap,
    /// A bag of ROS 1.
    Ros1,
    /// A ULog of PX4.
    ULog,
}

/// Passes every part of `bytes` that is read to `each`.
///
/// # Errors
/// Bytes that cannot be read or are not of the format; refusals of `each`.
pub(crate) fn each_part(
    bytes: &mut dyn Read,
    format: Format,
    effort: &Effort,
    each: &mut dyn FnMut(Part) -> Result<(), BagError>,
) -> Result<(), BagError> {
    match format {
        Format::Mcap => records::each_part(bytes, effort, each),
        Format::Ros1 => rosbag::each_part(bytes, effort, each),
        Format::ULog => ulog::each_part(bytes, each),
    }
}
