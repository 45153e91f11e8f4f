//! Message definitions as bags hold them: the message's own fields, then those of each type that it uses,
//! with a line of `=` and `MSG: package/Type` before each.
//! <https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html>

use std::cell::Cell;
use std::collections::BTreeMap;

use refusal::{Invalid, foreign};

use super::Effort;

/// Depth of nested types beyond which a definition is taken to be recursive.
const DEEPEST: usize = 32;

/// Most fields of a message, including those of nested types wherever they are used.
const MOST_FIELDS: usize = 20_000;

/// Most types of a definition.
const MOST_TYPES: usize = 2000;

/// Most bytes of a definition.
pub(crate) const LONGEST: usize = 1 << 20;

/// Most elements of a list whose length the definition states.
const MOST_ELEMENTS: usize = 1 << 27;

/// Names of the numeric types.
const NUMBERS: [(&str, Primitive); 13] = [
    ("bool", Primitive::U8),
    ("byte", Primitive::U8),
    ("char", Primitive::U8),
    ("uint8", Primitive::U8),
    ("int8", Primitive::I8),
    ("uint16", Primitive::U16),
    ("int16", Primitive::I16),
    ("uint32", Primitive::U32),
    ("int32", Primitive::I32),
    ("uint64", Primitive::U64),
    ("int64", Primitive::I64),
    ("float32", Primitive::F32),
    ("float64", Primitive::F64),
];

/// Whose definitions they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// Times are numbers of the language.
    Ros1,
    /// Times are messages.
    Ros2,
}

/// The types of a definition.
struct Types<'a> {
    dialect: Dialect,
    effort: &'a Effort,
    /// The lines of each `package/Type`.
    lines: BTreeMap<String, Vec<&'a str>>,
    /// How many more fields are allowed.
    left: Cell<usize>,
}

/// The shape of messages of type `name` by the definition in `text`.
pub(crate) fn definition(name: &str, text: &str, dialect: Dialect, effort: &Effort) -> Result<Shape, String> {
    if text.len() > LONGEST {
        return Err(format!("{} bytes, which are more than {LONGEST}", text.len()));
    }
    let mut all = vec![(short(name), Vec::new())];
    for line in text.lines().map(str::trim) {
        if let Some(next) = line.strip_prefix("MSG:") {
            all.push((short(next.trim()), Vec::new()));
        } else if let Some((_, lines)) = all.last_mut().filter(|_| !line.starts_with("==")) {
            lines.push(line);
        }
    }
    if all.len() > MOST_TYPES {
        return Err(format!("{} types, which are more than {MOST_TYPES}", all.len()));
    }
    // The first of several with one name counts.
    let lines = all.into_iter().rev().collect();
    let types = Types { dialect, effort, lines, left: Cell::new(MOST_FIELDS) };
    types.shape(&short(name), DEEPEST)
}

/// Seconds and nanoseconds, called as in ROS 2.
fn time(kind: Primitive) -> Shape {
    Shape::Fields(["sec", "nanosec"].map(|name| (name.to_owned(), Shape::Number(kind))).to_vec())
}

/// `package/Type` of `package/msg/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

impl Types<'_> {
    fn shape(&self, name: &str, deep: usize) -> Result<Shape, String> {
        let lines = self.lines.get(name);
        let lines = lines.ok_or_else(|| format!("no definition of `{}`", foreign(name)))?;
        if deep == 0 {
            return Err(format!("`{}` within itself, or types more than {DEEPEST} deep", foreign(name)));
        }
        let package = name.split_once('/').map_or("", |(package, _)| package);
        let fields = lines.iter().filter_map(|line| self.field(line, package, deep).transpose());
        Ok(Shape::Fields(fields.collect::<Result<_, _>>()?))
    }

    /// The field on a line: `None` for blank lines, comments, and constants, which messages do not contain.
    fn field(&self, line: &str, package: &str, deep: usize) -> Result<Option<(String, Shape)>, String> {
        self.effort.text(line.len()).map_err(|_| "lines without end, types within types".to_owned())?;
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        let (Some(kind), Some(name)) = (words.next(), words.next()) else {
            return if line.trim().is_empty() { Ok(None) } else { Err(format!("`{}`", foreign(line))) };
        };
        if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
            return Ok(None);
        }
        let left = self.left.get().checked_sub(1);
        self.left.set(left.ok_or_else(|| format!("more than {MOST_FIELDS} fields, types within types"))?);
        Ok(Some((name.to_owned(), self.kind(kind, package, deep)?)))
    }

    fn kind(&self, kind: &str, package: &str, deep: usize) -> Result<Shape, String> {
        if let Some((of, len)) = kind.strip_suffix(']').and_then(|kind| kind.rsplit_once('[')) {
            let fixed = !(len.is_empty() || len.starts_with("<="));
            let len = fixed.then(|| len.parse().map_err(|_| format!("`{}`", foreign(kind)))).transpose()?;
            if of.ends_with(']') || len.is_some_and(|len| !(1..=MOST_ELEMENTS).contains(&len)) {
                let lists = "lists have one length, from 1 on";
                return Err(format!("`{}`: {lists}", foreign(kind)));
            }
            return Ok(Shape::List(Box::new(self.kind(of, package, deep)?), len));
        }
        let kind = kind.split("<=").next().unwrap_or(kind);
        // A byte of ROS 1 has a sign.
        if self.dialect == Dialect::Ros1 && kind == "byte" {
            return Ok(Shape::Number(Primitive::I8));
        }
        if let Some((_, number)) = NUMBERS.iter().find(|(known, _)| *known == kind) {
            return Ok(Shape::Number(*number));
        }
        match kind {
            "string" => Ok(Shape::Text),
            "time" if self.dialect == Dialect::Ros1 => Ok(time(Primitive::U32)),
            "duration" if self.dialect == Dialect::Ros1 => Ok(time(Primitive::I32)),
            // Its length in bytes depends on the implementation.
            "wstring" => Err("a field of type `wstring`".to_owned()),
            kind if kind.contains('/') => self.shape(&short(kind), deep - 1),
            "Header" => self.shape("std_msgs/Header", deep - 1),
            kind => self.shape(&format!("{package}/{kind}"), deep - 1),
        }
    }
}

/// What is wrong with a message: found, expected.
pub(crate) type Wrong = (String, String);

/// A step of a path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathStep {
    /// To a field.
    Name(String),
    /// To an element of a list.
    Index(usize),
}

/// The steps of a path such as `position[2].x`; `None` where it is not a path.
pub(crate) fn steps(path: &str) -> Option<Vec<PathStep>> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() {
            return None;
        }
        steps.push(PathStep::Name(name.to_owned()));
        while !rest.is_empty() {
            let (index, after) = rest.strip_prefix('[')?.split_once(']')?;
            steps.push(PathStep::Index(index.parse().ok()?));
            rest = after;
        }
    }
    Some(steps)
}

/// The shape of a value of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    Number(Primitive),
    Text,
    /// Bytes without a meaning, which the end of a message may lack.
    Padding(usize),
    Fields(Vec<(String, Shape)>),
    /// Elements of one shape: a fixed number, or as many as a count before them states.
    List(Box<Shape>, Option<usize>),
}

/// A number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Primitive {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// Most names to search for the one that was meant.
const MOST_NAMES: usize = 1000;

impl Shape {
    /// How many fields and lists it has.
    pub(crate) fn fields(&self) -> usize {
        1 + match self {
            Self::Fields(fields) => fields.iter().map(|(_, shape)| shape.fields()).sum(),
            Self::List(of, _) => of.fields(),
            Self::Number(_) | Self::Text | Self::Padding(_) => 0,
        }
    }
}

/// The paths to the numbers of `shape`; of a list all elements if they are `few` at most, of one of any length the first
/// few numbers, else the first element.
pub(crate) fn leaves(shape: &Shape, few: usize, effort: &Effort) -> Result<Vec<String>, Invalid> {
    let mut leaves = Vec::new();
    collect(shape, "", few, effort, &mut leaves)?;
    Ok(leaves)
}

fn collect(
    shape: &Shape,
    path: &str,
    few: usize,
    effort: &Effort,
    found: &mut Vec<String>,
) -> Result<(), Invalid> {
    effort.text(path.len())?;
    match shape {
        _ if found.len() >= MOST_NAMES => Ok(()),
        Shape::Number(_) => {
            effort.keep(path.len())?;
            found.push(path.to_owned());
            Ok(())
        }
        Shape::Text | Shape::Padding(_) => Ok(()),
        Shape::Fields(fields) => fields.iter().try_for_each(|(name, shape)| {
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            collect(shape, &path, few, effort, found)
        }),
        Shape::List(of, len) => {
            let is_plain = matches!(**of, Shape::Number(_));
            let listed = len.or(is_plain.then_some(few)).filter(|len| *len <= few).unwrap_or(1);
            (0..listed).try_for_each(|i| collect(of, &format!("{path}[{i}]"), few, effort, found))
        }
    }
}

// Definitions of common messages of ROS 2, for bags without any: fields as packages `std_msgs`, `geometry_msgs`,
// `nav_msgs` and `sensor_msgs` have them.

/// Types with their fields, which are those of every release of ROS 2 so far.
const KNOWN: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Int8", "int8 data"),
    ("std_msgs/Int16", "int16 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/Int64", "int64 data"),
    ("std_msgs/UInt8", "uint8 data"),
    ("std_msgs/UInt16", "uint16 data"),
    ("std_msgs/UInt32", "uint32 data"),
    ("std_msgs/UInt64", "uint64 data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/MultiArrayDimension", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/MultiArrayLayout", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/Float32MultiArray", "MultiArrayLayout layout\nfloat32[] data"),
    ("std_msgs/Float64MultiArray", "MultiArrayLayout layout\nfloat64[] data"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"),
    ("geometry_msgs/Pose", "Point position\nQuaternion orientation"),
    ("geometry_msgs/PoseWithCovariance", "Pose pose\nfloat64[36] covariance"),
    ("geometry_msgs/Twist", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/TwistWithCovariance", "Twist twist\nfloat64[36] covariance"),
    ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque"),
    ("geometry_msgs/Accel", "Vector3 linear\nVector3 angular"),
    ("geometry_msgs/PointStamped", "std_msgs/Header header\nPoint point"),
    ("geometry_msgs/Vector3Stamped", "std_msgs/Header header\nVector3 vector"),
    ("geometry_msgs/QuaternionStamped", "std_msgs/Header header\nQuaternion quaternion"),
    ("geometry_msgs/PoseStamped", "std_msgs/Header header\nPose pose"),
    ("geometry_msgs/PoseWithCovarianceStamped", "std_msgs/Header header\nPoseWithCovariance pose"),
    ("geometry_msgs/TwistStamped", "std_msgs/Header header\nTwist twist"),
    ("geometry_msgs/TwistWithCovarianceStamped", "std_msgs/Header header\nTwistWithCovariance twist"),
    ("geometry_msgs/WrenchStamped", "std_msgs/Header header\nWrench wrench"),
    ("geometry_msgs/AccelStamped", "std_msgs/Header header\nAccel accel"),
    (
        "nav_msgs/Odometry",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
         geometry_msgs/TwistWithCovariance twist",
    ),
    (
        "sensor_msgs/Imu",
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n\
         geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n\
         geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance",
    ),
    ("sensor_msgs/NavSatStatus", "int8 status\nuint16 service"),
    (
        "sensor_msgs/NavSatFix",
        "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n\
         float64[9] position_covariance\nuint8 position_covariance_type",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
    (
        "sensor_msgs/MagneticField",
        "std_msgs/Header header\ngeometry_msgs/Vector3 magnetic_field\nfloat64[9] magnetic_field_covariance",
    ),
];

/// The definition of the type `name`, as bags have them; `None` if it is not known.
pub(crate) fn known(name: &str) -> Option<String> {
    let short = name.replace("/msg/", "/");
    let (_, fields) = KNOWN.iter().find(|(known, _)| *known == short)?;
    let others = KNOWN.iter().map(|(name, fields)| format!("\n====\nMSG: {name}\n{fields}"));
    Some(others.fold((*fields).to_owned(), |all, other| all + &other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn definition(name: &str, text: &str, dialect: Dialect) -> Result<Shape, String> {
        super::definition(name, text, dialect, &Effort::new(0.0))
    }

    #[test]
    fn comments_constants_defaults_and_types_of_other_packages_are_read() {
        let text = "# A pose\nstd_msgs/Header header\nuint8 OK=0\nint32 NONE = -1\nPoint[2] corners # two\nstring<=5 name \"x\"\n\
            float64[] weights\n================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n=====\n\
            MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n====\nMSG: geometry_msgs/Point\nfloat64 x\nfloat32 y 1.5\n";
        let shape = definition("geometry_msgs/msg/Thing", text, Dialect::Ros2).unwrap();
        let paths =
            ["header.stamp.sec", "header.stamp.nanosec", "corners[0].x", "corners[0].y", "weights[0]"];
        assert_eq!(super::leaves(&shape, 1, &Effort::new(0.0)).unwrap(), paths);
        let circle = definition("a/A", "A next\n", Dialect::Ros2).unwrap_err();
        assert!(circle.contains("within itself"), "{circle}");
        assert!(definition("a/A", "B next\n", Dialect::Ros2).unwrap_err().contains("no definition of `a/B`"));
    }

    #[test]
    fn definitions_that_never_end_are_refused_by_what_they_exceed() {
        let twice = |deep: usize| {
            let of = |i: usize| format!("====\nMSG: a/T{i}\nT{} x\nT{} y\n", i + 1, i + 1);
            "T0 x\n".to_owned()
                + &(0..deep).map(of).collect::<String>()
                + &format!("====\nMSG: a/T{deep}\nint8 x\n")
        };
        assert!(definition("a/A", &twice(10), Dialect::Ros2).is_ok());
        for (text, said) in [
            (twice(28), "more than 20000 fields"),
            ("uint8".to_owned() + &"[2]".repeat(200_000) + " x\n", "one length"),
            ("uint8[0][4294967295] x\n".to_owned(), "one length"),
            ("uint8[0] x\n".to_owned(), "one length"),
            ("====\nMSG: a/B\n".repeat(3000), "3001 types"),
            ("#".repeat(LONGEST + 1), "more than 1048576"),
            ("B x\n".repeat(19_000) + "=\nMSG: a/B\n" + &"int8 A=1\n".repeat(50_000), "lines without end"),
        ] {
            let refused = definition("a/A", &text, Dialect::Ros2).unwrap_err();
            assert!(refused.contains(said) && refused.len() < 200, "{refused}");
        }
    }

    #[test]
    fn all_that_are_known_have_a_shape() {
        for (name, _) in KNOWN {
            let text = known(name).unwrap();
            assert!(definition(name, &text, Dialect::Ros2).is_ok(), "{name}");
        }
        assert!(known("nav_msgs/msg/Odometry").is_some() && known("nav_msgs/msg/Other").is_none());
    }
}
