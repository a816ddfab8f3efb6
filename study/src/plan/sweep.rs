//! `[sweep]`: lists of values for some dials, of which every combination is a stratum.

use std::path::Path;

use toml::{Table, Value};

use super::error::PlanError;
use super::raw::RawDials;

/// The most combinations of one file: what a page can show.
const MOST_CELLS: usize = 512;
/// The most dials, and the most values of one.
const MOST_FACTORS: usize = 6;
const MOST_LEVELS: usize = 16;
/// What strata are called before the numbers of their values, if the table does not say it.
const NAME: &str = "sweep";

/// A factorial sweep: its strata stand in the plan one after the other, the last dial's values following one another fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// What its strata's names begin with.
    pub name: String,
    /// The first of its strata, by number in the plan.
    pub first: usize,
    /// The dials that are turned.
    pub factors: Vec<Factor>,
}

/// A dial that is turned.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    /// Its key, as `marker.radius_mm`.
    pub key: String,
    /// Its values, as they stand in the file.
    pub levels: Vec<String>,
    /// The same as numbers, where all of them are.
    pub numbers: Option<Vec<f64>>,
}

impl Sweep {
    /// How many strata.
    pub fn cells(&self) -> usize {
        self.factors.iter().map(|factor| factor.levels.len()).product()
    }

    /// The level of each dial in the `cell`-th of its strata.
    pub fn levels(&self, cell: usize) -> Vec<usize> {
        let mut left = cell;
        let mut levels: Vec<usize> = self
            .factors
            .iter()
            .rev()
            .map(|factor| {
                let level = left % factor.levels.len();
                left /= factor.levels.len();
                level
            })
            .collect();
        levels.reverse();
        levels
    }
}

/// A dial with its values of the file.
struct Listed {
    key: String,
    values: Vec<Value>,
}

/// The sweep of a file, and what its strata set.
///
/// # Errors
/// [`PlanError::Value`] with the key.
pub(super) fn strata(path: &Path, table: &Table, first: usize) -> Result<(Sweep, Vec<RawDials>), PlanError> {
    let wrong = |key: &str, found: String, expected: String| PlanError::Value {
        path: path.to_owned(),
        place: format!("sweep: {key}"),
        found: found.chars().take(80).collect(),
        expected,
    };
    let name = match table.get("name") {
        None => NAME,
        Some(Value::String(name)) => name,
        Some(other) => return Err(wrong("name", other.to_string(), "a text".to_owned())),
    };
    let listed = listed(table).map_err(|(key, found, expected)| wrong(&key, found, expected))?;
    if !(1..=MOST_FACTORS).contains(&listed.len()) {
        let expected = format!("1 to {MOST_FACTORS} dials are allowed");
        return Err(wrong("dials", listed.len().to_string(), expected));
    }
    let sweep = Sweep {
        name: name.to_owned(),
        first,
        factors: listed.iter().map(factor).collect(),
    };
    if sweep.cells() > MOST_CELLS {
        let expected = format!("at most {MOST_CELLS} combinations are allowed: leave values out, or make two studies");
        return Err(wrong("all values", sweep.cells().to_string(), expected));
    }
    let mut strata = Vec::new();
    for cell in 0..sweep.cells() {
        let levels = sweep.levels(cell);
        let ordinals: Vec<String> = levels.iter().map(|level| (level + 1).to_string()).collect();
        let name = format!("{name}-{}", ordinals.join("-"));
        let chosen = listed
            .iter()
            .zip(&levels)
            .map(|(dial, level)| (dial, &dial.values[*level]));
        let dials = dials(chosen).map_err(|why| wrong("dials", name.clone(), why))?;
        strata.push(RawDials {
            name: Some(name),
            ..dials
        });
    }
    Ok((sweep, strata))
}

/// The lists of the table: of keys, and of keys in tables. Else the key, what was found there and what is expected.
fn listed(table: &Table) -> Result<Vec<Listed>, (String, String, String)> {
    let mut all = Vec::new();
    for (key, value) in table.iter().filter(|(key, _)| *key != "name") {
        match value {
            Value::Table(inside) => {
                for (inner, value) in inside {
                    all.push(list(format!("{key}.{inner}"), value)?);
                }
            }
            value => all.push(list(key.clone(), value)?),
        }
    }
    Ok(all)
}

fn list(key: String, value: &Value) -> Result<Listed, (String, String, String)> {
    let refused = |key, found: String, expected: &str| Err((key, found, expected.to_owned()));
    if key == "operations" {
        return refused(key, value.to_string(), "operations stand at the top of the file");
    }
    let Value::Array(values) = value else {
        return refused(
            key,
            value.to_string(),
            "a list of values is needed; what is the same for all stands under [all]",
        );
    };
    if !(2..=MOST_LEVELS).contains(&values.len()) {
        return refused(key, value.to_string(), "2 to 16 values are allowed");
    }
    let is_again = |at: usize| values.iter().take(at).any(|other| *other == values[at]);
    match (0..values.len()).find(|at| is_again(*at)) {
        Some(at) => refused(key, values[at].to_string(), "each value at most once"),
        None => Ok(Listed {
            key,
            values: values.clone(),
        }),
    }
}

fn factor(dial: &Listed) -> Factor {
    let number = |value: &Value| match value {
        Value::Integer(value) => Some(*value as f64),
        Value::Float(value) => Some(*value),
        _ => None,
    };
    Factor {
        key: dial.key.clone(),
        levels: dial.values.iter().map(Value::to_string).collect(),
        numbers: dial.values.iter().map(number).collect(),
    }
}

/// What one combination sets; the words of the grammar where there is no such key, or its value is of another kind.
fn dials<'a>(chosen: impl Iterator<Item = (&'a Listed, &'a Value)>) -> Result<RawDials, String> {
    let mut table = Table::new();
    for (dial, value) in chosen {
        match dial.key.split_once('.') {
            None => {
                table.insert(dial.key.clone(), value.clone());
            }
            Some((outer, inner)) => {
                let inside = table.entry(outer).or_insert_with(|| Value::Table(Table::new()));
                if let Value::Table(inside) = inside {
                    inside.insert(inner.to_owned(), value.clone());
                }
            }
        }
    }
    table
        .try_into()
        .map_err(|error: toml::de::Error| error.message().to_owned())
}
