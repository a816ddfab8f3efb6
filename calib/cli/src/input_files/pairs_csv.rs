//! `pairs.csv`: one pair a line, its columns named by the first line.

use crate::input_files::fields::{self, BadNumber, BadQuote, Field};
use crate::input_files::points_text::{COVARIANCE, SHARED, StatedError};
use crate::input_files::source::Source;
use crate::register::input_error::{InputError, MAX_PAIRS, Place};
use crate::register::row::Row;

/// The columns that must be there.
const NEEDED: [&str; 6] = ["from_x", "from_y", "from_z", "to_x", "to_y", "to_z"];
/// Those that may be, and with them those of the error of `from`, as touches state it.
const OPTIONAL: [&str; 2] = ["weight", "label"];

/// The pairs of a file.
#[derive(Debug)]
pub(crate) struct Table {
    pub(crate) rows: Vec<Row>,
    pub(crate) has_weights: bool,
    pub(crate) header_line: usize,
}

/// The names of the columns, in the order of the file.
struct Header<'a> {
    names: Vec<String>,
    line: usize,
    source: &'a Source,
}

/// Reads the pairs of a file.
pub(crate) fn read(source: &Source) -> Result<Table, InputError> {
    let mut lines = source.rows();
    let no_rows = |only| InputError::NoRows {
        path: source.path.clone(),
        what: "pairs",
        only,
    };
    let (line, text) = lines.next().ok_or_else(|| no_rows("blank lines and comments"))?;
    let header = Header::read(source, line, text)?;
    let mut rows = Vec::new();
    for (line, text) in lines {
        if rows.len() == MAX_PAIRS {
            return Err(InputError::too_many(&source.path, line));
        }
        rows.push(header.row(line, text)?);
    }
    if rows.is_empty() {
        return Err(no_rows("the header"));
    }
    Ok(Table {
        rows,
        has_weights: header.names.iter().any(|name| name == "weight"),
        header_line: line,
    })
}

/// Where a name is in its group.
fn place(group: &[&str], name: &str) -> usize {
    group.iter().position(|other| *other == name).unwrap_or(0)
}

/// The fields of a line, or where its quotes go wrong.
fn split<'a>(source: &Source, line: usize, text: &'a str) -> Result<Vec<Field<'a>>, InputError> {
    fields::csv(text).map_err(|BadQuote(column)| InputError::BadQuote {
        path: source.path.clone(),
        line,
        column,
    })
}

impl<'a> Header<'a> {
    fn read(source: &'a Source, line: usize, text: &str) -> Result<Self, InputError> {
        let fields = split(source, line, text)?;
        let names: Vec<String> = fields.iter().map(|field| field.text.to_string()).collect();
        let header = Self { names, line, source };
        header.complete()?;
        for (i, field) in fields.iter().enumerate() {
            let place = header.place(line, field, i);
            let name = field.text.as_ref();
            let known = [&NEEDED[..], &OPTIONAL, &COVARIANCE, &SHARED];
            if !known.iter().any(|group| group.contains(&name)) {
                return Err(InputError::UnknownColumn { place });
            }
            if header.names[..i].iter().any(|earlier| earlier == name) {
                return Err(InputError::RepeatedColumn { place });
            }
        }
        Ok(header)
    }

    fn complete(&self) -> Result<(), InputError> {
        let has = |name: &str| self.names.iter().any(|found| found == name);
        // A part of a covariance is none; what is shared is a part of one.
        let begun = |group: &[&str]| group.iter().any(|name| has(name));
        let shared: &[&str] = if begun(&SHARED) { &SHARED } else { &[] };
        let covariance: &[&str] = if begun(&COVARIANCE) || begun(&SHARED) {
            &COVARIANCE
        } else {
            &[]
        };
        let mut needed = NEEDED.iter().chain(covariance).chain(shared);
        let missing = needed.find(|name| !has(name));
        let Some(missing) = missing else {
            return Ok(());
        };
        let found = self.names.join(",");
        Err(InputError::MissingColumn {
            path: self.source.path.clone(),
            line: self.line,
            missing: (*missing).to_owned(),
            found: format!("{:?}", found.chars().take(80).collect::<String>()),
        })
    }

    fn place(&self, line: usize, field: &Field<'_>, index: usize) -> Place {
        Place {
            path: self.source.path.clone(),
            line,
            column: field.column,
            name: self.names[index].chars().take(40).collect(),
        }
    }

    fn row(&self, line: usize, text: &str) -> Result<Row, InputError> {
        let fields = split(self.source, line, text)?;
        if fields.len() != self.names.len() {
            return Err(self.ragged(line, text, &fields));
        }
        let mut row = Row {
            lines: [line; 2],
            to: [0.0; 3],
            from: [0.0; 3],
            weight: 1.0,
            label: String::new(),
            error: None,
        };
        let (mut covariance, mut shared) = ([0.0; 6], [0.0; 9]);
        for (i, field) in fields.iter().enumerate() {
            let number = |read: fn(&str) -> Result<f64, BadNumber>| {
                read(&field.text).map_err(|bad| InputError::number(bad, self.place(line, field, i), &field.text))
            };
            match (
                self.names[i].as_str(),
                NEEDED.iter().position(|name| *name == self.names[i]),
            ) {
                (_, Some(at @ 0..3)) => row.from[at] = number(fields::coordinate)?,
                (_, Some(at)) => row.to[at - 3] = number(fields::coordinate)?,
                (name, None) if COVARIANCE.contains(&name) => {
                    covariance[place(&COVARIANCE, name)] = number(fields::coordinate)?;
                }
                (name, None) if SHARED.contains(&name) => shared[place(&SHARED, name)] = number(fields::coordinate)?,
                ("weight", None) => row.weight = number(fields::weight)?,
                _ => row.label = field.text.to_string(),
            }
        }
        let has = |name: &str| self.names.iter().any(|found| found == name);
        row.error = has(COVARIANCE[0]).then(|| StatedError::of(covariance, has(SHARED[0]).then_some(shared)));
        Ok(row)
    }

    fn ragged(&self, line: usize, text: &str, fields: &[Field<'_>]) -> InputError {
        let extra = fields.get(self.names.len());
        InputError::Ragged {
            path: self.source.path.clone(),
            line,
            column: extra.map_or(text.chars().count() + 1, |field| field.column),
            found: fields.len(),
            expected: self.names.len(),
            names: self.names.join(","),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::Path;

    fn parse(text: &str) -> Result<Table, String> {
        let source = Source::from_bytes(Path::new("p.csv"), text.into()).unwrap();
        read(&source).map_err(|error| error.to_string())
    }

    const HEADER: &str = "from_x,from_y,from_z,to_x,to_y,to_z";

    #[test]
    fn columns_come_in_any_order() {
        let table =
            parse("# mm\nlabel, to_z,to_y,to_x,weight,from_x,from_y,from_z\n\n\"a,b\",6,5,4,0.5,1,2,3\n").unwrap();
        let row = Row {
            lines: [4; 2],
            to: [4.0, 5.0, 6.0],
            from: [1.0, 2.0, 3.0],
            weight: 0.5,
            label: "a,b".to_owned(),
            error: None,
        };
        assert_eq!((table.rows, table.has_weights, table.header_line), (vec![row], true, 2));
    }

    #[test]
    fn what_is_wrong_is_said_with_line_and_column() {
        let with = |rows: &str| parse(&format!("{HEADER}\n{rows}")).unwrap_err();
        for (rows, words) in [
            ("1,2,3,4,5\n", "p.csv: line 2, column 10: 5 fields, expected 6"),
            ("1,2,3,4,5,6,7\n", "line 2, column 13: 7 fields, expected 6"),
            (
                "1,2,3,4,5,6\n\n1,2,x,4,5,6",
                "p.csv, line 4, column 5 (from_z): found \"x\", expected a number in mm",
            ),
            ("1,2,3,4,,6", "line 2, column 9 (to_y): found \"\""),
            (
                "1,2,3,nan,5,6",
                "line 2, column 7 (to_x): found \"nan\", which is not finite",
            ),
            (
                "1,2,3,4,5,1e10",
                "line 2, column 11 (to_z): found \"1e10\", at most 1e9 mm",
            ),
            ("1,2,3,4,5,\"6", "line 2, column 11: the quoted field"),
            ("", "there are no pairs in it, only the header"),
        ] {
            assert!(with(rows).contains(words), "{rows}: {}", with(rows));
        }
    }

    #[test]
    fn headers_are_checked() {
        for (text, words) in [
            (
                "1,2,3,4,5,6\n",
                "line 1: the header has no column from_x; found \"1,2,3,4,5,6\"",
            ),
            ("from_x;from_y\n", "no column from_x; found \"from_x;from_y\""),
            (
                &format!("{HEADER},wieght\n"),
                "p.csv, line 1, column 37 (wieght): this column is not known",
            ),
            (
                &format!("{HEADER},to_x\n"),
                "line 1, column 37 (to_x): this column is there a second time",
            ),
            ("# nothing\n\n", "no pairs in it, only blank lines and comments"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        let negative = parse(&format!("{HEADER},weight\n1,2,3,4,5,6,-1\n")).unwrap_err();
        assert!(
            negative.contains("line 2, column 13 (weight): found \"-1\", a weight must be at least 0"),
            "{negative}"
        );
    }

    #[test]
    fn the_number_of_pairs_is_bounded() {
        let text = format!("{HEADER}\n{}", "1,2,3,4,5,6\n".repeat(MAX_PAIRS + 1));
        let error = parse(&text).unwrap_err();
        assert!(error.contains("line 10002 begins pair 10001, at most 10000"), "{error}");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "(from_[xyz]|to_[xyz]|[0-9]|,|\n|\"|#| |é|nan){0,60}") {
            let source = Source::from_bytes(Path::new("p.csv"), format!("{HEADER}\n{text}").into_bytes()).unwrap();
            let _ = read(&source);
        }
    }
}
