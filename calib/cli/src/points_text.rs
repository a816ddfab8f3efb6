//! Points as plain text: three numbers a line, with blanks or commas between them.

use crate::fields;
use crate::input_error::{InputError, MAX_PAIRS, Place};
use crate::source::Source;

/// A point and the line it stands in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) line: usize,
    pub(crate) mm: [f64; 3],
}

/// Reads the points of a file.
pub(crate) fn read(source: &Source) -> Result<Vec<Point>, InputError> {
    let mut points = Vec::new();
    for (line, text) in source.rows() {
        if points.len() == MAX_PAIRS {
            return Err(InputError::too_many(&source.path, line));
        }
        points.push(point(source, line, text)?);
    }
    if points.is_empty() {
        return Err(InputError::NoRows {
            path: source.path.clone(),
            what: "points",
            only: "blank lines and comments",
        });
    }
    Ok(points)
}

fn point(source: &Source, line: usize, text: &str) -> Result<Point, InputError> {
    let fields = fields::plain(text);
    if fields.len() != 3 {
        return Err(InputError::Ragged {
            path: source.path.clone(),
            line,
            column: fields.get(3).map_or(text.chars().count() + 1, |field| field.column),
            found: fields.len(),
            expected: 3,
            names: "x y z, with blanks or commas between them".to_owned(),
        });
    }
    let mut mm = [0.0; 3];
    for ((value, field), name) in mm.iter_mut().zip(&fields).zip(["x", "y", "z"]) {
        *value = fields::coordinate(&field.text).map_err(|bad| {
            let place = Place {
                path: source.path.clone(),
                line,
                column: field.column,
                name: name.to_owned(),
            };
            InputError::number(bad, place, &field.text)
        })?;
    }
    Ok(Point { line, mm })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parse(text: &str) -> Result<Vec<[f64; 3]>, String> {
        let source = Source::from_bytes(Path::new("p.txt"), text.into()).unwrap();
        let points = read(&source).map_err(|error| error.to_string())?;
        Ok(points.iter().map(|point| point.mm).collect())
    }

    #[test]
    fn blanks_and_commas_separate() {
        let expected = vec![[1.0, -2.0, 0.5]; 3];
        assert_eq!(parse("1 -2 0.5\n# x\n1,-2,.5\n 1\t-2  5e-1\r\n"), Ok(expected));
    }

    #[test]
    fn what_is_wrong_is_said_with_line_and_column() {
        for (text, words) in [
            ("1 2 3\n1 2\n", "p.txt: line 2, column 4: 2 fields, expected 3 (x y z"),
            ("1 2 3 4", "line 1, column 7: 4 fields, expected 3"),
            (
                "1 2 3\n\n1 b 3",
                "p.txt, line 3, column 3 (y): found \"b\", expected a number in mm",
            ),
            ("1 2 inf", "line 1, column 5 (z): found \"inf\", which is not finite"),
            ("# only\n", "there are no points in it"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
