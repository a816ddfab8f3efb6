//! From a key to its place in the text of a TOML file, and back.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Line and column, both from 1, of a byte position; the column counts characters.
pub fn line_and_column(text: &str, at: usize) -> (usize, usize) {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    let before = &text[..at];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

/// Where the value of the dotted `key` stands; where it is absent, its nearest parent that is there.
pub fn position_of(text: &str, key: &str) -> Option<usize> {
    let table = DeTable::parse(text).ok()?;
    let mut at = None;
    let mut value = None;
    for (depth, part) in key.split('.').enumerate() {
        let next = match (depth, value) {
            (0, _) => table.get_ref().get(part),
            (_, Some(value)) => child(value, part),
            _ => None,
        };
        let Some(next) = next else { break };
        at = Some(next.span().start);
        value = Some(next.get_ref());
    }
    at
}

fn child<'a, 'i>(value: &'a DeValue<'i>, part: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    match value {
        DeValue::Table(table) => table.get(part),
        DeValue::Array(items) => items.get(part.parse::<usize>().ok()?),
        _ => None,
    }
}

/// The dotted key whose name or value stands at a byte position.
pub fn key_at(text: &str, at: usize) -> Option<String> {
    let table = DeTable::parse(text).ok()?;
    let mut path = Vec::new();
    walk_table(table.get_ref(), at, &mut path);
    (!path.is_empty()).then(|| path.join("."))
}

fn walk_table(table: &DeTable<'_>, at: usize, path: &mut Vec<String>) {
    for (key, value) in table {
        if key.span().contains(&at) || holds(value, at) {
            path.push(key.get_ref().to_string());
            walk_value(value.get_ref(), at, path);
            return;
        }
    }
}

fn walk_value(value: &DeValue<'_>, at: usize, path: &mut Vec<String>) {
    match value {
        DeValue::Table(table) => walk_table(table, at, path),
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                if holds(item, at) {
                    path.push(index.to_string());
                    walk_value(item.get_ref(), at, path);
                    return;
                }
            }
        }
        _ => {}
    }
}

/// The span of a `[table]` is its header only, so its content is searched as well.
fn holds(value: &Spanned<DeValue<'_>>, at: usize) -> bool {
    value.span().contains(&at)
        || match value.get_ref() {
            DeValue::Table(table) => table.iter().any(|(k, v)| k.span().contains(&at) || holds(v, at)),
            DeValue::Array(items) => items.iter().any(|item| holds(item, at)),
            _ => false,
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "seed = 1\n[tracker]\nrate_hz = -4\n[[views]]\nname = \"é\"\n[[views]]\nname = \"b\"\n";

    #[test]
    fn finds_values_by_key_and_keys_by_value() {
        for (key, line) in [
            ("seed", 1),
            ("tracker.rate_hz", 3),
            ("views.0.name", 5),
            ("views.1.name", 7),
        ] {
            let at = position_of(TEXT, key).unwrap();
            assert_eq!(line_and_column(TEXT, at).0, line, "{key}");
            assert_eq!(key_at(TEXT, at).as_deref(), Some(key));
        }
    }

    #[test]
    fn an_absent_key_is_placed_at_its_parent() {
        let at = position_of(TEXT, "tracker.noise_mm").unwrap();
        assert_eq!(line_and_column(TEXT, at).0, 2);
        assert_eq!(position_of(TEXT, "tool.length_mm"), None);
    }

    #[test]
    fn columns_count_characters() {
        assert_eq!(line_and_column("é = 1", 3), (1, 3));
        assert_eq!(line_and_column("ab", 99), (1, 3));
    }
}
