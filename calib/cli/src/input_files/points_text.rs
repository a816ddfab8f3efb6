//! Points as plain text: three numbers a line, with blanks or commas between them.

use crate::input_files::fields;
use crate::input_files::source::Source;
use crate::register::input_error::{InputError, MAX_PAIRS, Place};

/// A point and the line it stands in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) line: usize,
    pub(crate) mm: [f64; 3],
}

/// Reads the points of a file.
pub(crate) fn read(source: &Source) -> Result<Vec<Point>, InputError> {
    let mut points = Vec::new();
    let mut rows = source.rows().peekable();
    let columns = rows
        .next_if(|(_, text)| is_header(text))
        .map(|(line, text)| columns(source, line, text));
    let columns = columns.transpose()?;
    for (line, text) in rows {
        if points.len() == MAX_PAIRS {
            return Err(InputError::too_many(&source.path, line));
        }
        points.push(point(source, line, text, columns.as_ref())?);
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

/// The columns of a file of touches.
struct Columns {
    at: [usize; 3],
    count: usize,
}

/// Whether a first line names columns, as that of `calib touch` does.
fn is_header(text: &str) -> bool {
    text.split(',').any(|field| field.trim() == "x")
}

fn columns(source: &Source, line: usize, text: &str) -> Result<Columns, InputError> {
    let names = fields::plain(text);
    let find = |name| names.iter().position(|field| field.text == name);
    match (find("x"), find("y"), find("z")) {
        (Some(x), Some(y), Some(z)) => Ok(Columns {
            at: [x, y, z],
            count: names.len(),
        }),
        _ => Err(InputError::Ragged {
            path: source.path.clone(),
            line,
            column: 1,
            found: names.len(),
            expected: 3,
            names: "the columns x, y and z among others".to_owned(),
        }),
    }
}

fn point(source: &Source, line: usize, text: &str, columns: Option<&Columns>) -> Result<Point, InputError> {
    let fields = fields::plain(text);
    let expected = columns.map_or(3, |columns| columns.count);
    if fields.len() != expected {
        return Err(InputError::Ragged {
            path: source.path.clone(),
            line,
            column: fields
                .get(expected)
                .map_or(text.chars().count() + 1, |field| field.column),
            found: fields.len(),
            expected,
            names: "x y z, with blanks or commas between them, or the columns of calib touch".to_owned(),
        });
    }
    let at = columns.map_or([0, 1, 2], |columns| columns.at);
    let mut mm = [0.0; 3];
    for ((value, i), name) in mm.iter_mut().zip(at).zip(["x", "y", "z"]) {
        let field = &fields[i];
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
    fn the_columns_of_touches_are_read_by_their_names() {
        let text = "# of a pointer\non,x,y,z,cxx,cxy\nbead-1,1,-2,0.5,0.1,0\nbead-2,4,5,6,0.1,0\n";
        assert_eq!(parse(text), Ok(vec![[1.0, -2.0, 0.5], [4.0, 5.0, 6.0]]));
        for (text, words) in [
            (
                "on,x,y\na,1,2\n",
                "line 1, column 1: 3 fields, expected 3 (the columns x, y and z",
            ),
            ("on,x,y,z\na,1,2\n", "line 2, column 6: 3 fields, expected 4"),
            ("on,x,y,z\na,1,b,3\n", "line 2, column 5 (y): found \"b\""),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
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
