//! Types of ROS 2 messages from their definitions in bags and MCAP files.
//!
//! A definition is a list of fields, `type name`; after a line of `=` and `MSG: package/Type` follow the types that
//! it uses. Bags of older ROS 2 have none; common ones are defined here.

use std::collections::HashMap;

/// Definitions of common types in recordings of motors, for bags without any.
const COMMON: &[(&str, &str)] = &[
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec"),
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec"),
    (
        "std_msgs/Header",
        "builtin_interfaces/Time stamp\nstring frame_id",
    ),
    (
        "sensor_msgs/JointState",
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    ),
    ("std_msgs/Bool", "bool data"),
    ("std_msgs/Float32", "float32 data"),
    ("std_msgs/Float64", "float64 data"),
    ("std_msgs/Int8", "int8 data"),
    ("std_msgs/Int16", "int16 data"),
    ("std_msgs/Int32", "int32 data"),
    ("std_msgs/Int64", "int64 data"),
    ("std_msgs/UInt8", "uint8 data"),
    ("std_msgs/UInt16", "uint16 data"),
    ("std_msgs/UInt32", "uint32 data"),
    ("std_msgs/UInt64", "uint64 data"),
    (
        "std_msgs/MultiArrayDimension",
        "string label\nuint32 size\nuint32 stride",
    ),
    (
        "std_msgs/MultiArrayLayout",
        "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset",
    ),
    (
        "std_msgs/Float32MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat32[] data",
    ),
    (
        "std_msgs/Float64MultiArray",
        "std_msgs/MultiArrayLayout layout\nfloat64[] data",
    ),
    (
        "std_msgs/Int32MultiArray",
        "std_msgs/MultiArrayLayout layout\nint32[] data",
    ),
    (
        "sensor_msgs/BatteryState",
        "std_msgs/Header header\nfloat32 voltage\nfloat32 temperature\nfloat32 current\nfloat32 charge\nfloat32 capacity\n\
         float32 design_capacity\nfloat32 percentage\nuint8 power_supply_status\nuint8 power_supply_health\n\
         uint8 power_supply_technology\nbool present\nfloat32[] cell_voltage\nfloat32[] cell_temperature\nstring location\n\
         string serial_number",
    ),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z"),
    (
        "geometry_msgs/Twist",
        "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    ),
    (
        "geometry_msgs/TwistStamped",
        "std_msgs/Header header\ngeometry_msgs/Twist twist",
    ),
];

/// One value of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    Signed(u8),
    Unsigned(u8),
    Float(u8),
    Text,
    /// Text of 16-bit characters, whose encoding differs between vendors.
    WideText,
    Nested(String),
}

/// Multiplicity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Many {
    One,
    Fixed(usize),
    /// The number is in the message.
    Counted,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub many: Many,
}

/// Types by name without `msg/`.
#[derive(Debug, Clone, Default)]
pub(super) struct Types(HashMap<String, Vec<Field>>);

impl Types {
    /// The common types alone.
    pub fn common() -> Self {
        let mut types = Self::default();
        for (name, definition) in COMMON {
            types.take(name, definition);
        }
        types
    }

    /// A type with its definition and the following ones.
    pub fn defined(name: &str, definition: &str) -> Self {
        let mut types = Self::common();
        let mut name = short(name);
        let mut lines = String::new();
        for line in definition.lines() {
            if line.trim_start().starts_with("====") {
                continue;
            }
            if let Some(next) = line.trim().strip_prefix("MSG:") {
                types.take(&name, &lines);
                lines.clear();
                name = short(next);
                continue;
            }
            lines.push_str(line);
            lines.push('\n');
        }
        types.take(&name, &lines);
        types
    }

    /// The fields of a type.
    pub fn fields(&self, name: &str) -> Option<&[Field]> {
        self.0.get(&short(name)).map(Vec::as_slice)
    }

    fn take(&mut self, name: &str, definition: &str) {
        let package = name.split('/').next().unwrap_or_default().to_owned();
        let fields = definition
            .lines()
            .filter_map(|line| field(line, &package))
            .collect();
        self.0.insert(name.to_owned(), fields);
    }
}

/// `sensor_msgs/msg/JointState` and `sensor_msgs/JointState` are the same.
fn short(name: &str) -> String {
    name.trim().replace("/msg/", "/")
}

/// A field of a definition; `None` for comments, constants and empty lines.
fn field(line: &str, package: &str) -> Option<Field> {
    let line = line.split('#').next()?.trim();
    let (kind, rest) = line.split_once(char::is_whitespace)?;
    let rest = rest.trim();
    let name = rest.split(|c: char| c.is_whitespace() || c == '=').next()?;
    let after = rest[name.len()..].trim_start();
    // `int8 ON=1` and `int8 ON = 1` are constants.
    if name.is_empty() || after.starts_with('=') {
        return None;
    }
    let (kind, many) = match kind.split_once('[') {
        None => (kind, Many::One),
        Some((kind, count)) => {
            let count = count.trim_end_matches(']');
            (kind, count.parse().map_or(Many::Counted, Many::Fixed))
        }
    };
    let base = kind.split('<').next()?;
    let kind = match base {
        "bool" => Kind::Bool,
        "byte" | "char" | "uint8" => Kind::Unsigned(1),
        "int8" => Kind::Signed(1),
        "int16" => Kind::Signed(2),
        "uint16" => Kind::Unsigned(2),
        "int32" => Kind::Signed(4),
        "uint32" => Kind::Unsigned(4),
        "int64" => Kind::Signed(8),
        "uint64" => Kind::Unsigned(8),
        "float32" => Kind::Float(4),
        "float64" => Kind::Float(8),
        "string" => Kind::Text,
        "wstring" => Kind::WideText,
        "Header" => Kind::Nested("std_msgs/Header".to_owned()),
        "time" => Kind::Nested("builtin_interfaces/Time".to_owned()),
        "duration" => Kind::Nested("builtin_interfaces/Duration".to_owned()),
        nested if nested.contains('/') => Kind::Nested(short(nested)),
        nested => Kind::Nested(format!("{package}/{nested}")),
    };
    Some(Field {
        name: name.to_owned(),
        kind,
        many,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_read_with_those_that_follow_them() {
        let types = Types::defined(
            "my_msgs/msg/Motor",
            "# a motor\nint8 ON=1\nHeader header\nfloat32[3] pwm # of three\nfloat64[<=4] angle\nstring<=10 name \"x\"\nPart part\n\
             ================\nMSG: my_msgs/Part\nuint16 counts 7\n",
        );
        let names = |name: &str| -> Vec<(String, Many)> {
            let fields = types.fields(name).expect("there");
            fields
                .iter()
                .map(|field| (field.name.clone(), field.many))
                .collect()
        };
        assert_eq!(
            names("my_msgs/Motor"),
            [
                ("header".to_owned(), Many::One),
                ("pwm".to_owned(), Many::Fixed(3)),
                ("angle".to_owned(), Many::Counted),
                ("name".to_owned(), Many::One),
                ("part".to_owned(), Many::One),
            ]
        );
        assert_eq!(
            names("my_msgs/msg/Part"),
            [("counts".to_owned(), Many::One)]
        );
        assert!(types.fields("std_msgs/msg/Header").is_some());
    }
}
