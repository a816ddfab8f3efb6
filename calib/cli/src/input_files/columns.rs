//! Comma-separated values whose first line names the columns, some of which may be absent.

use std::path::{Path, PathBuf};

use crate::input_files::fields::{self, BadQuote, Field};
use crate::input_files::source::{Source, SourceError};
use crate::register::input_error::Place;

/// The most rows of a file.
pub(crate) const MAX_ROWS: usize = 200_000;

/// Why a file gave no rows. Lines and columns count from 1.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TableError {
    #[error(transparent)]
    Source(#[from] SourceError),
    #[error("reading {path}: there are no rows in it; the first line names the columns: {hint}")]
    NoRows { path: PathBuf, hint: &'static str },
    #[error("reading {path}: line {line}: the header has no column {missing}; expected {hint}")]
    MissingColumn {
        path: PathBuf,
        line: usize,
        missing: &'static str,
        hint: &'static str,
    },
    #[error("reading {place}: this column is not known, or is there a second time; expected {hint}")]
    BadColumn { place: Place, hint: &'static str },
    #[error("reading {path}: line {line}, column {column}: the quoted field does not end in a quote and a comma")]
    BadQuote { path: PathBuf, line: usize, column: usize },
    #[error("reading {path}: line {line}: {found} fields in a row, expected {expected}")]
    Count {
        path: PathBuf,
        line: usize,
        found: usize,
        expected: usize,
    },
    #[error("reading {place}: found {found:?}, expected {expected}")]
    Field {
        place: Place,
        found: String,
        expected: String,
    },
    #[error("reading {path}: more than {most} {what} (line {line}); cut or thin the recording")]
    TooMany {
        path: PathBuf,
        line: usize,
        most: usize,
        what: &'static str,
    },
}

/// The columns that a kind of file has.
pub(crate) struct Layout {
    pub(crate) needed: &'static [&'static str],
    /// All or none of each group.
    pub(crate) optional: &'static [&'static [&'static str]],
    /// All of them for a person.
    pub(crate) hint: &'static str,
}

/// A file with its header read.
pub(crate) struct Table<'a> {
    source: &'a Source,
    names: Vec<String>,
}

/// A row; fields are asked for by the name of their column.
pub(crate) struct Row<'a> {
    table: &'a Table<'a>,
    pub(crate) line: usize,
    fields: Vec<Field<'a>>,
}

impl<'a> Table<'a> {
    /// Reads the header.
    pub(crate) fn new(source: &'a Source, layout: &Layout) -> Result<Self, TableError> {
        let (path, hint) = (source.path.clone(), layout.hint);
        let Some((line, text)) = source.rows().next() else {
            return Err(TableError::NoRows { path, hint });
        };
        let fields = split(&source.path, line, text)?;
        for (i, field) in fields.iter().enumerate() {
            let listed = |names: &[&str]| names.contains(&field.text.as_ref());
            let known = listed(layout.needed) || layout.optional.iter().any(|group| listed(group));
            if !known || fields[..i].iter().any(|earlier| earlier.text == field.text) {
                let place = place(&source.path, line, field.column, &field.text);
                return Err(TableError::BadColumn { place, hint });
            }
        }
        let has = |name: &&'static str| fields.iter().any(|field| field.text == *name);
        let begun = layout.optional.iter().filter(|group| group.iter().any(has));
        let all = layout.needed.iter().chain(begun.copied().flatten());
        if let Some(missing) = all.copied().find(|name| !has(name)) {
            return Err(TableError::MissingColumn {
                path,
                line,
                missing,
                hint,
            });
        }
        let names = fields.iter().map(|field| field.text.clone().into_owned()).collect();
        Ok(Self { source, names })
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }

    /// The rows below the header; at least one.
    pub(crate) fn rows(&'a self, layout: &Layout) -> Result<Vec<Row<'a>>, TableError> {
        let mut rows = Vec::new();
        for (line, text) in self.source.rows().skip(1) {
            let path = || self.source.path.clone();
            if rows.len() == MAX_ROWS {
                let (most, what) = (MAX_ROWS, "rows");
                return Err(TableError::TooMany {
                    path: path(),
                    line,
                    most,
                    what,
                });
            }
            let fields = split(&self.source.path, line, text)?;
            let (found, expected) = (fields.len(), self.names.len());
            if found != expected {
                return Err(TableError::Count {
                    path: path(),
                    line,
                    found,
                    expected,
                });
            }
            rows.push(Row {
                table: self,
                line,
                fields,
            });
        }
        if rows.is_empty() {
            let (path, hint) = (self.source.path.clone(), layout.hint);
            return Err(TableError::NoRows { path, hint });
        }
        Ok(rows)
    }
}

impl Row<'_> {
    fn field(&self, name: &str) -> Option<&Field<'_>> {
        let at = self.table.names.iter().position(|known| known == name)?;
        self.fields.get(at)
    }

    /// The text of a column; nothing where the file has no such column.
    pub(crate) fn text(&self, name: &str) -> &str {
        self.field(name).map_or("", |field| field.text.as_ref())
    }

    /// What is wrong with a field.
    pub(crate) fn bad(&self, name: &str, expected: impl Into<String>) -> TableError {
        let column = self.field(name).map_or(1, |field| field.column);
        TableError::Field {
            place: place(&self.table.source.path, self.line, column, name),
            found: self.text(name).chars().take(40).collect(),
            expected: expected.into(),
        }
    }

    /// A finite number of at most 1e9.
    pub(crate) fn number(&self, name: &str) -> Result<f64, TableError> {
        let expected = "a finite number of at most 1e9, with a point for the decimals";
        fields::coordinate(self.text(name)).map_err(|_| self.bad(name, expected))
    }

    /// The coordinates of a point, mm.
    pub(crate) fn point(&self, names: [&str; 3]) -> Result<[f64; 3], TableError> {
        let [x, y, z] = names;
        Ok([self.number(x)?, self.number(y)?, self.number(z)?])
    }

    /// A whole number from 0 to `most`.
    pub(crate) fn index(&self, name: &str, most: usize) -> Result<usize, TableError> {
        let value: Option<usize> = self.text(name).parse().ok();
        let good = value.filter(|v| *v <= most);
        good.ok_or_else(|| self.bad(name, format!("a whole number from 0 to {most}")))
    }
}

fn split<'a>(path: &Path, line: usize, text: &'a str) -> Result<Vec<Field<'a>>, TableError> {
    fields::csv(text).map_err(|BadQuote(column)| TableError::BadQuote {
        path: path.to_owned(),
        line,
        column,
    })
}

fn place(path: &Path, line: usize, column: usize, name: &str) -> Place {
    Place {
        path: path.to_owned(),
        line,
        column,
        name: name.chars().take(40).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LAYOUT: Layout = Layout {
        needed: &["n", "x"],
        optional: &[&["a", "b"]],
        hint: "n,x and a,b or neither",
    };

    fn parse(text: &str) -> Result<Vec<(usize, f64)>, String> {
        let read = || -> Result<_, TableError> {
            let source = Source::from_bytes(Path::new("t.csv"), text.into())?;
            let table = Table::new(&source, &LAYOUT)?;
            let rows = table.rows(&LAYOUT)?;
            rows.iter()
                .map(|row| Ok((row.index("n", 9)?, row.number("x")?)))
                .collect()
        };
        read().map_err(|error| error.to_string())
    }

    #[test]
    fn columns_come_in_any_order() {
        assert_eq!(parse("# c\nx,b,a,n\n1.5,0,0,3\n"), Ok(vec![(3, 1.5)]));
        assert_eq!(parse("n,x\n3,1.5\n"), Ok(vec![(3, 1.5)]));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        for (text, words) in [
            ("n,x\n", "there are no rows in it"),
            ("# n\n", "there are no rows in it"),
            ("n\n1\n", "no column x; expected n,x and"),
            ("n,x,a\n1,2,3\n", "no column b"),
            ("n,x,y\n1,2,3\n", "line 1, column 5 (y): this column is not known"),
            ("n,x,n\n1,2,3\n", "a second time"),
            ("n,x\n1\n", "line 2: 1 fields in a row, expected 2"),
            ("n,x\n1,NaN\n", "line 2, column 3 (x): found \"NaN\""),
            (
                "n,x\n-1,2\n",
                "line 2, column 1 (n): found \"-1\", expected a whole number from 0 to 9",
            ),
            ("n,x\n\"1,2\n", "line 2, column 1: the quoted field"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[nxab,0-9.\n\"e-]{0,100}") {
            let _ = parse(&text);
            let _ = parse(&format!("n,x\n{text}"));
        }
    }
}
