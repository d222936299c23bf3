//! The part of JSON Schema that `docs/schema` uses, and no more: a word that is not known here
//! fails. Published schemas leave room for fields to come; here an object has those of its schema
//! alone.

use serde_json::Value;
use std::path::Path;

/// Words that say something to people alone, or that are read where another word is.
const SILENT: [&str; 6] =
    ["$schema", "$id", "$defs", "title", "description", "additionalProperties"];

/// Schemas of the repository, by name.
pub(crate) fn all() -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/schema");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        files.filter(|file| file.extension() == Some("json".as_ref())).collect();
    files.sort();
    let read = |file| serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    files.iter().map(read).collect()
}

/// Panics at what is not as the schema that it names has it, in it and in what it holds.
pub(crate) fn validate(value: &Value) {
    let found = faults(value);
    assert!(found.is_empty(), "{}\n{value}", found.join("\n"));
}

/// Places that are not as the schema that the value names has them.
pub(crate) fn faults(value: &Value) -> Vec<String> {
    let named = value.get("schema").or_else(|| value.pointer("/otherData/schema"));
    let schemas = all();
    let Some(schema) = schemas.iter().find(|schema| Some(&schema["title"]) == named) else {
        return vec![format!("no schema is called {named:?}")];
    };
    let mut found = Vec::new();
    Check { root: schema }.check(value, schema, "", &mut found);
    // A certificate inside a report has a schema of its own.
    for (field, inner) in value.as_object().into_iter().flatten() {
        if inner.get("schema").is_some() && field != "otherData" {
            found.extend(faults(inner).into_iter().map(|fault| format!("/{field}{fault}")));
        }
    }
    found
}

struct Check<'a> {
    root: &'a Value,
}

impl Check<'_> {
    fn check(&self, value: &Value, schema: &Value, at: &str, found: &mut Vec<String>) {
        for (word, rule) in schema.as_object().unwrap() {
            let holds = match word.as_str() {
                "type" => types(rule).any(|name| is_of(value, name)),
                "const" => value == rule,
                "enum" => rule.as_array().unwrap().contains(value),
                "minimum" => value.as_f64().is_none_or(|v| v >= rule.as_f64().unwrap()),
                "minItems" => value.as_array().is_none_or(|v| v.len() >= count(rule)),
                "maxItems" => value.as_array().is_none_or(|v| v.len() <= count(rule)),
                "minProperties" => value.as_object().is_none_or(|v| v.len() >= count(rule)),
                "pattern" => value.as_str().is_none_or(|text| matches(rule, text)),
                "required" => {
                    let has = |field: &Value| value.get(field.as_str().unwrap()).is_some();
                    value.is_null() || rule.as_array().unwrap().iter().all(has)
                }
                "$ref" => {
                    let place = rule.as_str().unwrap().strip_prefix('#').unwrap();
                    self.check(value, self.root.pointer(place).unwrap(), at, found);
                    true
                }
                "oneOf" => {
                    let fits = |schema: &&Value| {
                        let mut found = Vec::new();
                        self.check(value, schema, at, &mut found);
                        found.is_empty()
                    };
                    rule.as_array().unwrap().iter().filter(fits).count() == 1
                }
                "items" => {
                    for (place, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(item, rule, &format!("{at}/{place}"), found);
                    }
                    true
                }
                "properties" => {
                    self.fields(value, schema, at, found);
                    true
                }
                word => SILENT.contains(&word),
            };
            if !holds {
                found.push(format!("{at}: {word} {rule}: {value}"));
            }
        }
        if schema.get("properties").is_none() {
            self.fields(value, schema, at, found);
        }
    }

    /// The fields of an object, of which each is in its schema.
    fn fields(&self, value: &Value, schema: &Value, at: &str, found: &mut Vec<String>) {
        let others = &schema["additionalProperties"];
        for (field, inner) in value.as_object().into_iter().flatten() {
            let at = format!("{at}/{field}");
            match (schema.pointer(&format!("/properties/{field}")), others) {
                (Some(schema), _) => self.check(inner, schema, &at, found),
                (None, Value::Object(_)) => self.check(inner, others, &at, found),
                (None, Value::Bool(true)) => {}
                // A reference or an alternative has the fields.
                (None, _) if schema.get("type").is_none() => {}
                (None, _) => found.push(format!("{at}: not in the schema")),
            }
        }
    }
}

fn count(rule: &Value) -> usize {
    rule.as_u64().unwrap() as usize
}

fn types(rule: &Value) -> impl Iterator<Item = &str> {
    let list = rule.as_array().map_or(std::slice::from_ref(rule), Vec::as_slice);
    list.iter().map(|name| name.as_str().unwrap())
}

fn is_of(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("type {other}"),
    }
}

/// The patterns that the schemas use.
fn matches(rule: &Value, text: &str) -> bool {
    match rule.as_str().unwrap() {
        "^[0-9a-f]{64}$" => {
            text.len() == 64 && text.bytes().all(|c| b"0123456789abcdef".contains(&c))
        }
        "^(NaN|-?inf)$" => ["NaN", "inf", "-inf"].contains(&text),
        "^domain[.]" => text.starts_with("domain."),
        other => panic!("pattern {other}"),
    }
}
