//! The pairs of a registration, wherever they come from.

use std::path::{Path, PathBuf};

use geometry::VolumeGrid;

use crate::input_files::source::Source;
use crate::input_files::{pairs_csv, points_text};
use crate::live::says_frame;
use crate::register::duplicates;
use crate::register::input_error::{InputError, LEAST_EXTENT_MM};
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

    /// Refuses points that are too near to one another to be a patient's in mm.
    pub(crate) fn refuse_small(&self) -> Result<(), InputError> {
        for side in ["to", "from"] {
            let along = |i: usize| {
                let values = || {
                    self.rows
                        .iter()
                        .map(|row| if side == "to" { row.to[i] } else { row.from[i] })
                };
                values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
            };
            let extent_mm = along(0).hypot(along(1)).hypot(along(2));
            // Points that coincide are of no unit: the method says what they lack.
            if extent_mm > 0.0 && extent_mm < LEAST_EXTENT_MM {
                return Err(InputError::TooSmall {
                    files: self.names(),
                    side,
                    extent_mm,
                });
            }
        }
        Ok(())
    }

    /// Refuses points of `to` that lie in no voxel of the CT that they are of.
    pub(crate) fn refuse_outside(&self, grid: &VolumeGrid) -> Result<(), InputError> {
        let is_outside = |row: &&Row| {
            let [x, y, z] = row.to;
            !grid.holds(geometry::Point::new(x, y, z))
        };
        let Some(row) = self.rows.iter().find(is_outside) else {
            return Ok(());
        };
        let (low, high) = grid.bounds();
        Err(InputError::OutsideCt {
            path: self.path().to_owned(),
            line: row.lines[0],
            found: row.to,
            low: low.mm(),
            high: high.mm(),
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
