//! Validation of a document by a JSON Schema, for the keywords that docs/json uses; any other keyword is a failure.
//!
//! Stricter than JSON Schema: a key that the schema does not list is an error. The Python package `jsonschema` checks
//! the schemas and this validator in tests/json/run.

use serde_json::Value;

/// Violations, each with its place; empty if there are none.
pub fn faults(schema: &Value, document: &Value) -> Vec<String> {
    let mut checked = Checked {
        root: schema,
        faults: Vec::new(),
    };
    checked.check(schema, document, "");
    checked.faults
}

struct Checked<'a> {
    root: &'a Value,
    faults: Vec<String>,
}

impl Checked<'_> {
    fn check(&mut self, schema: &Value, value: &Value, at: &str) {
        let schema = schema.as_object().expect("a schema is an object");
        for (keyword, says) in schema {
            let fits = match keyword.as_str() {
                "$schema" | "$id" | "$defs" | "title" | "description" | "format" | "required" => {
                    true
                }
                "$ref" => {
                    let name = says.as_str().and_then(|name| name.strip_prefix("#/$defs/"));
                    let target = &self.root["$defs"][name.expect("a local reference")];
                    self.check(target, value, at);
                    true
                }
                "type" => {
                    let types = says
                        .as_array()
                        .cloned()
                        .unwrap_or_else(|| vec![says.clone()]);
                    types
                        .iter()
                        .any(|name| is_of_type(value, name.as_str().expect("a name")))
                }
                "const" => value == says,
                "enum" => says.as_array().expect("a list").contains(value),
                "oneOf" => self.fitting(says, value) == 1,
                "anyOf" => self.fitting(says, value) > 0,
                "minimum" => value
                    .as_f64()
                    .is_none_or(|number| Some(number) >= says.as_f64()),
                "maximum" => value
                    .as_f64()
                    .is_none_or(|number| Some(number) <= says.as_f64()),
                "minItems" => value
                    .as_array()
                    .is_none_or(|items| Some(items.len() as u64) >= says.as_u64()),
                "maxItems" => value
                    .as_array()
                    .is_none_or(|items| Some(items.len() as u64) <= says.as_u64()),
                "items" => {
                    for (k, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(says, item, &format!("{at}/{k}"));
                    }
                    true
                }
                "prefixItems" => {
                    let pairs = says.as_array().expect("a list").iter();
                    for (k, (says, item)) in pairs
                        .zip(value.as_array().into_iter().flatten())
                        .enumerate()
                    {
                        self.check(says, item, &format!("{at}/{k}"));
                    }
                    true
                }
                "properties" => {
                    self.keys(schema, value, at);
                    true
                }
                "additionalProperties" => {
                    for (key, value) in value.as_object().into_iter().flatten() {
                        if schema
                            .get("properties")
                            .is_none_or(|known| known.get(key).is_none())
                        {
                            self.check(says, value, &format!("{at}/{key}"));
                        }
                    }
                    true
                }
                other => panic!("the keyword {other} is not known here"),
            };
            if !fits {
                let text: String = value.to_string().chars().take(60).collect();
                self.faults
                    .push(format!("{at}: {text} is not {keyword} {says}"));
            }
        }
    }

    /// The keys of an object: required ones are present, and none is unknown.
    fn keys(&mut self, schema: &serde_json::Map<String, Value>, value: &Value, at: &str) {
        let Some(object) = value.as_object() else {
            return;
        };
        let known = &schema["properties"];
        for (key, value) in object {
            match known.get(key) {
                Some(says) => self.check(says, value, &format!("{at}/{key}")),
                None if schema.contains_key("additionalProperties") => {}
                None => self.faults.push(format!("{at}/{key} is not in the schema")),
            }
        }
        for key in schema
            .get("required")
            .and_then(Value::as_array)
            .into_iter()
            .flatten()
        {
            if !object.contains_key(key.as_str().expect("a name")) {
                self.faults.push(format!("{at}: {key} is missing"));
            }
        }
    }

    /// How many of several schemas fit.
    fn fitting(&self, schemas: &Value, value: &Value) -> usize {
        let fits = |schema: &&Value| {
            let mut apart = Checked {
                root: self.root,
                faults: Vec::new(),
            };
            apart.check(schema, value, "");
            apart.faults.is_empty()
        };
        schemas
            .as_array()
            .expect("a list")
            .iter()
            .filter(fits)
            .count()
    }
}

fn is_of_type(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("the type {other} is not known"),
    }
}
