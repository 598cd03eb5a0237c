//! Messages of topics in any encoding: each number is a signal, `/joint_states.position[0]`.

use std::collections::HashMap;

use serde_json::Value;

use super::super::table::Table;
use super::ros_types::Types;
use super::signals::Signals;
use super::{Form, FormatError, cdr};

/// Most elements of an array that become separate signals.
pub(super) const MOST_ELEMENTS: usize = 64;
/// Deepest nesting of JSON objects.
const MOST_DEPTH: usize = 16;
/// Earlier stamps are unset: 1971 in ns.
const LEAST_STAMP_NS: i64 = 31_536_000_000_000_000;

/// One value of a message.
#[derive(Debug, Clone, Copy)]
pub(super) enum Leaf<'a> {
    Number(f64),
    /// Nanoseconds since 1970.
    Time(i64),
    Text(&'a str),
}

/// Receiver of a message's values by their paths.
pub(super) type Sink<'s> = dyn FnMut(&str, Leaf) + 's;

/// Encoding of the messages of a topic.
#[derive(Debug)]
enum Coding {
    Cdr {
        types: Types,
        name: String,
    },
    Json,
    /// An unsupported one: its name.
    Other(String),
}

/// A topic.
#[derive(Debug)]
struct Topic {
    name: String,
    coding: Coding,
    is_joint_state: bool,
    /// Names of the joints are known.
    is_named: bool,
    read: u64,
    unread: u64,
}

/// The messages of a recording.
#[derive(Debug)]
pub(super) struct Messages {
    pub form: Form,
    pub signals: Signals,
    topics: HashMap<u64, Topic>,
    /// Recording time of the first message in ns.
    first_ns: Option<i64>,
}

impl Messages {
    pub fn new(form: Form) -> Self {
        Self {
            form,
            signals: Signals::new(form),
            topics: HashMap::new(),
            first_ns: None,
        }
    }

    pub fn has_topic(&self, id: u64) -> bool {
        self.topics.contains_key(&id)
    }

    /// Adds a topic: `encoding` of its messages, and their type with its definition, if there is one.
    pub fn topic(
        &mut self,
        id: u64,
        topic: &str,
        encoding: &str,
        kind: &str,
        definition: Option<&str>,
    ) {
        let coding = match encoding {
            "cdr" => Coding::Cdr {
                types: match definition {
                    Some(definition) => Types::defined(kind, definition),
                    None => Types::common(),
                },
                name: kind.to_owned(),
            },
            "json" => Coding::Json,
            other => Coding::Other(other.to_owned()),
        };
        let topic = Topic {
            name: topic.to_owned(),
            coding,
            is_joint_state: kind.ends_with("/JointState"),
            is_named: false,
            read: 0,
            unread: 0,
        };
        self.topics.insert(id, topic);
    }

    /// One message.
    pub fn message(&mut self, id: u64, time_ns: i64, data: &[u8]) -> Result<(), FormatError> {
        let Some(topic) = self.topics.get_mut(&id) else {
            return Ok(());
        };
        let first_ns = *self.first_ns.get_or_insert(time_ns);
        let mut leaves: Vec<(String, Option<f64>, Option<String>)> = Vec::new();
        let mut sink = |path: &str, leaf: Leaf| {
            leaves.push(match leaf {
                Leaf::Number(number) => (path.to_owned(), Some(number), None),
                Leaf::Time(ns) if ns < LEAST_STAMP_NS => return,
                Leaf::Time(ns) => (
                    path.to_owned(),
                    Some(ns.wrapping_sub(first_ns) as f64 / 1e9),
                    None,
                ),
                Leaf::Text(text) => (path.to_owned(), None, Some(text.to_owned())),
            });
        };
        let mut path = topic.name.clone();
        let read = match &topic.coding {
            Coding::Cdr { types, name } => cdr::read(types, name, data, &mut path, &mut sink),
            Coding::Json => serde_json::from_slice(data)
                .ok()
                .and_then(|value| json(&value, &mut path, &mut sink, 0)),
            Coding::Other(_) => None,
        };
        if read.is_none() {
            topic.unread += 1;
            return Ok(());
        }
        topic.read += 1;
        if topic.is_joint_state && !topic.is_named {
            topic.is_named = true;
            let names: Vec<String> = leaves
                .iter()
                .filter(|(path, _, _)| path[topic.name.len()..].starts_with(".name["))
                .filter_map(|(_, _, text)| text.clone())
                .enumerate()
                .map(|(at, name)| format!("[{at}] {name}"))
                .collect();
            if names.len() > 1 {
                self.signals
                    .notes
                    .push(format!("joints of {}: {}", topic.name, names.join(", ")));
            }
        }
        for (path, number, _) in &leaves {
            let Some(number) = number else { continue };
            let field = &path[topic.name.len()..];
            let unit = match field.split('[').next() {
                Some(".position") if topic.is_joint_state => Some("rad"),
                Some(".velocity") if topic.is_joint_state => Some("rad/s"),
                _ if field.ends_with(".stamp") => Some("s"),
                _ => None,
            };
            let signal = self.signals.signal(path, unit)?;
            self.signals.push(time_ns, signal, *number)?;
        }
        Ok(())
    }

    /// The table, with the unreadable parts by topic.
    pub fn table(mut self) -> Result<Table, FormatError> {
        let mut topics: Vec<&Topic> = self
            .topics
            .values()
            .filter(|topic| topic.unread > 0)
            .collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        let unread: Vec<String> = topics
            .iter()
            .map(|topic| {
                let why = match &topic.coding {
                    Coding::Other(encoding) => {
                        format!("encoded as `{encoding}`; cdr and json are read")
                    }
                    Coding::Cdr { name, types } if types.fields(name).is_none() => {
                        format!("of type {name}, whose definition is not in the file")
                    }
                    Coding::Cdr { name, .. } => format!("that do not fit their type {name}"),
                    Coding::Json => "that are no JSON".to_owned(),
                };
                format!("{} messages of {} {why}", topic.unread, topic.name)
            })
            .collect();
        if self.signals.is_empty() {
            return Err(self.form.nothing(&unread.join("; ")));
        }
        self.signals
            .notes
            .extend(unread.iter().map(|unread| format!("not read: {unread}")));
        Ok(self.signals.table())
    }
}

/// The numbers of a JSON value. `{sec, nanosec}` is a time.
fn json(value: &Value, path: &mut String, sink: &mut Sink, depth: usize) -> Option<()> {
    if depth > MOST_DEPTH {
        return Some(());
    }
    let whole = path.len();
    match value {
        Value::Number(number) => sink(path, Leaf::Number(number.as_f64()?)),
        Value::Bool(is_on) => sink(path, Leaf::Number(f64::from(u8::from(*is_on)))),
        Value::String(text) => sink(path, Leaf::Text(text)),
        Value::Null => {}
        Value::Array(values) => {
            for (at, value) in values.iter().enumerate().take(MOST_ELEMENTS) {
                path.push_str(&format!("[{at}]"));
                json(value, path, sink, depth + 1)?;
                path.truncate(whole);
            }
        }
        Value::Object(fields) => {
            let part = |name: &str| fields.get(name).and_then(Value::as_i64);
            let ns = part("nanosec").or_else(|| part("nsec"));
            if let (Some(seconds), Some(ns), 2) = (part("sec"), ns, fields.len()) {
                sink(
                    path,
                    Leaf::Time(seconds.checked_mul(1_000_000_000)?.checked_add(ns)?),
                );
                return Some(());
            }
            for (name, value) in fields {
                path.push('.');
                path.push_str(name);
                json(value, path, sink, depth + 1)?;
                path.truncate(whole);
            }
        }
    }
    Some(())
}
