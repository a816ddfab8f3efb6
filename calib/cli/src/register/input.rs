//! The pairs of a registration, wherever they come from.

use std::path::{Path, PathBuf};

use crate::input_files::source::Source;
use crate::input_files::{pairs_csv, points_text};
use crate::live::says_frame;
use crate::register::duplicates;
use crate::register::input_error::InputError;
use crate::register::row::Row;

/// All pairs, and where they came from.
#[derive(Debug)]
pub(crate) struct Input {
    pub(crate) rows: Vec<Row>,
    /// With the role of each: `pairs`, or `to` and `from`.
    pub(crate) sources: Vec<(&'static str, Source)>,
    /// The file has a column of weights.
    pub(crate) has_weights: bool,
}

/// Where pairs are to be read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum From {
    /// One file of comma-separated values.
    Csv(PathBuf),
    /// Two files of points, line by line.
    Points { to: PathBuf, from: PathBuf },
}

impl Input {
    /// Reads pairs. Weights are checked where they are there, and needed where `weighted`.
    pub(crate) fn read(from: &From, weighted: bool, allow_duplicates: bool) -> Result<Self, InputError> {
        let input = match from {
            From::Csv(path) => Self::from_csv(Source::read(path)?, weighted)?,
            From::Points { to, from } => Self::from_points(Source::read(to)?, Source::read(from)?)?,
        };
        if weighted && input.rows.iter().all(|row| row.weight == 0.0) {
            return Err(InputError::NoWeight {
                path: input.path().to_owned(),
                pairs: input.rows.len(),
            });
        }
        if !allow_duplicates {
            duplicates::refuse(&input.rows, &input.sources)?;
        }
        Ok(input)
    }

    pub(crate) fn from_csv(source: Source, weighted: bool) -> Result<Self, InputError> {
        let table = pairs_csv::read(&source)?;
        if weighted && !table.has_weights {
            return Err(InputError::NoWeightColumn {
                path: source.path,
                line: table.header_line,
            });
        }
        Ok(Self {
            rows: table.rows,
            sources: vec![("pairs", source)],
            has_weights: table.has_weights,
        })
    }

    pub(crate) fn from_points(to: Source, from: Source) -> Result<Self, InputError> {
        let (a, b) = (points_text::read(&to)?, points_text::read(&from)?);
        if a.len() != b.len() {
            return Err(InputError::Unpaired {
                to_path: to.path,
                from_path: from.path,
                to: a.len(),
                from: b.len(),
            });
        }
        if a.iter().any(|point| point.error.is_some()) && !says_frame(&to.text) {
            return Err(InputError::TouchesAsTo { path: to.path });
        }
        let row = |(a, b): (points_text::Point, points_text::Point)| Row {
            lines: [a.line, b.line],
            to: a.mm,
            from: b.mm,
            weight: 1.0,
            label: String::new(),
            error: b.error,
        };
        Ok(Self {
            rows: a.into_iter().zip(b).map(row).collect(),
            sources: vec![("to", to), ("from", from)],
            has_weights: false,
        })
    }

    /// The file to be named where one is.
    pub(crate) fn path(&self) -> &Path {
        self.sources.first().map_or(Path::new(""), |(_, source)| &source.path)
    }

    /// The files in words.
    pub(crate) fn names(&self) -> String {
        let names = self.sources.iter().map(|(_, source)| source.path.display().to_string());
        names.collect::<Vec<_>>().join(" and ")
    }
}
