//! What has been changed in a problem since its journal began.

use serde_json::Value;

/// Every place at which two values differ: path, then and now.
pub(crate) fn changes(then: &Value, now: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect("", then, now, &mut found);
    found
}

fn collect(path: &str, then: &Value, now: &Value, found: &mut Vec<String>) {
    match (then, now) {
        (Value::Object(a), Value::Object(b)) => {
            let mut keys: Vec<&String> = a.keys().chain(b.keys()).collect();
            keys.sort_unstable();
            keys.dedup();
            for key in keys {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                collect(&path, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null), found);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                let named = name(a).filter(|named| name(b) == Some(*named));
                let which = named.map_or_else(|| (index + 1).to_string(), str::to_owned);
                collect(&format!("{path}[{which}]"), a, b, found);
            }
        }
        (a, b) if a == b => {}
        (a, b) => found.push(format!("`{path}` was {} and is {}", set(a), set(b))),
    }
}

/// What an entry of a list is called.
fn name(entry: &Value) -> Option<&str> {
    entry.get("name")?.as_str()
}

/// A list of what has names by these.
fn set(value: &Value) -> String {
    let names =
        value.as_array().filter(|all| !all.is_empty()).map(|all| all.iter().map(name).collect::<Option<Vec<_>>>());
    match (value, names.flatten()) {
        (Value::Null, _) => "not set".to_owned(),
        (_, Some(names)) => names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        (value, None) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn changes_are_named_by_their_place() {
        let then = json!({"parameter": [{"name": "a", "upper": 1.0}, {"name": "b"}], "loop": {"seed": 1}});
        let now = json!({"parameter": [{"name": "a", "upper": 2.0}, {"name": "c"}], "loop": {"seed": 1, "gain": 0.5},
            "held": [{"name": "heat", "upper": 3.0}, {"name": "force"}]});
        let found = changes(&then, &now);
        let expected = [
            "`held` was not set and is `heat`, `force`",
            "`loop.gain` was not set and is 0.5",
            "`parameter[a].upper` was 1.0 and is 2.0",
            "`parameter[2].name` was \"b\" and is \"c\"",
        ];
        assert_eq!(found, expected);
        assert!(changes(&then, &then).is_empty());
    }
}
