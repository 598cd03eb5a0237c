//! ROS 2 bags in SQLite (`.db3`): tables `topics`, `messages` and, since ROS 2 Iron, `message_definitions`.
//!
//! Only tables are read: a view of the same name could run for ever.

use std::collections::HashMap;
use std::io::Cursor;

use rusqlite::{Connection, MAIN_DB};

use super::super::table::Table;
use super::messages::Messages;
use super::{Form, FormatError};

const FORM: Form = Form::Rosbag;

pub(super) fn read(bytes: &[u8]) -> Result<Table, FormatError> {
    let broken = |error: rusqlite::Error| FORM.broken(error);
    let mut database = Connection::open_in_memory().map_err(broken)?;
    database
        .deserialize_read_exact(MAIN_DB, Cursor::new(bytes), bytes.len(), true)
        .map_err(broken)?;
    if !is_table(&database, "topics")? || !is_table(&database, "messages")? {
        return Err(
            FORM.nothing("it is an SQLite database, and has no tables `topics` and `messages`")
        );
    }
    let mut definitions: HashMap<String, String> = HashMap::new();
    if is_table(&database, "message_definitions")? {
        let sql = "SELECT topic_type, encoded_message_definition FROM message_definitions WHERE encoding = 'ros2msg'";
        let mut query = database.prepare(sql).map_err(broken)?;
        let mut rows = query.query([]).map_err(broken)?;
        while let Some(row) = rows.next().map_err(broken)? {
            definitions.insert(row.get(0).map_err(broken)?, row.get(1).map_err(broken)?);
        }
    }
    let mut messages = Messages::new(FORM);
    let sql = "SELECT id, name, type, serialization_format FROM topics";
    let mut query = database.prepare(sql).map_err(broken)?;
    let mut rows = query.query([]).map_err(broken)?;
    while let Some(row) = rows.next().map_err(broken)? {
        let text = |at: usize| row.get::<_, String>(at).map_err(broken);
        let id: i64 = row.get(0).map_err(broken)?;
        let kind = text(2)?;
        let definition = definitions.get(&kind).map(String::as_str);
        messages.topic(id as u64, &text(1)?, &text(3)?, &kind, definition);
    }
    drop(rows);
    let sql = "SELECT topic_id, timestamp, data FROM messages NOT INDEXED";
    let mut query = database.prepare(sql).map_err(broken)?;
    let mut rows = query.query([]).map_err(broken)?;
    loop {
        let row = match rows.next() {
            Ok(Some(row)) => row,
            Ok(None) => break,
            // Records before a damaged page are complete.
            Err(error) if !messages.signals.is_empty() => {
                messages
                    .signals
                    .notes
                    .push(format!("it is read up to where it breaks off ({error})"));
                break;
            }
            Err(error) => return Err(broken(error)),
        };
        let (Ok(id), Ok(time_ns), Ok(data)) = (row.get::<_, i64>(0), row.get(1), row.get_ref(2))
        else {
            return Err(FORM.broken("a message without topic, time or data"));
        };
        let data = data
            .as_blob()
            .map_err(|_| FORM.broken("a message whose data are no bytes"))?;
        messages.message(id as u64, time_ns, data)?;
    }
    drop(rows);
    messages.table()
}

/// Whether a name is that of a plain table.
fn is_table(database: &Connection, name: &str) -> Result<bool, FormatError> {
    let sql = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?1 AND sql NOT LIKE 'CREATE VIRTUAL%' \
               AND sql NOT LIKE '%GENERATED%'";
    database
        .query_row(sql, [name], |row| row.get::<_, i64>(0))
        .map(|count| count == 1)
        .map_err(|error| FORM.broken(error))
}
