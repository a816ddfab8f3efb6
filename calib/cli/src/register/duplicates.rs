//! Pairs and points that occur twice. Two measurements never agree to the last digit; copied lines do.

use std::collections::HashMap;

use crate::input_files::source::Source;
use crate::register::input_error::InputError;
use crate::register::row::Row;

/// Refuses the first pair or point that is a repetition.
pub(crate) fn refuse(rows: &[Row], sources: &[(&str, Source)]) -> Result<(), InputError> {
    let path = |source: usize| {
        let source = sources.get(source).or(sources.first());
        source.map(|(_, source)| source.path.clone()).unwrap_or_default()
    };
    if let Some((first, second)) = repeated(rows, |row| (bits(row.to), bits(row.from))) {
        return Err(InputError::DuplicatePair {
            path: path(0),
            first: first.lines[0],
            second: second.lines[0],
        });
    }
    for (source, side) in ["to", "from"].into_iter().enumerate() {
        let point = |row: &Row| if source == 0 { row.to } else { row.from };
        if let Some((first, second)) = repeated(rows, |row| bits(point(row))) {
            return Err(InputError::DuplicatePoint {
                path: path(source),
                side,
                point: point(first),
                first: first.lines[source],
                second: second.lines[source],
            });
        }
    }
    Ok(())
}

/// The first row whose key was there before, behind that earlier row.
fn repeated<K: std::hash::Hash + Eq>(rows: &[Row], key: impl Fn(&Row) -> K) -> Option<(&Row, &Row)> {
    let mut seen: HashMap<K, &Row> = HashMap::with_capacity(rows.len());
    rows.iter().find_map(|row| Some((seen.insert(key(row), row)?, row)))
}

/// Equal for equal numbers: adding zero makes -0 and 0 one.
fn bits(point: [f64; 3]) -> [u64; 3] {
    point.map(|x| (x + 0.0).to_bits())
}
