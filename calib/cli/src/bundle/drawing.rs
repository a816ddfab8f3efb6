//! A marker that is known already: a calibration file or an NDI tool definition.

use std::path::{Path, PathBuf};

use geometry::{Marker, Point};

use crate::calibration::{CalibrationError, CalibrationFile, Kind, MarkerRecord};
use crate::commands::common::OwnError;
use crate::rom::{self, NoTool, Rom, RomError};

/// Why a drawing was not taken.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DrawingError {
    #[error(transparent)]
    Rom(#[from] RomError),
    #[error(transparent)]
    NoTool(#[from] NoTool),
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    #[error("{path}: a drawing of a marker is a calibration (.json) or an NDI tool definition (.rom)")]
    Kind { path: PathBuf },
}

impl OwnError for DrawingError {}

/// A marker by its file.
#[derive(Debug)]
pub(crate) struct Drawing {
    pub(crate) marker: MarkerRecord,
    /// The id of a calibration.
    pub(crate) id: Option<String>,
}

impl Drawing {
    /// Reads a marker of the name given.
    pub(crate) fn read(path: &Path, name: &str) -> Result<Self, DrawingError> {
        let ends = |end: &str| path.to_string_lossy().to_lowercase().ends_with(end);
        if ends(".rom") {
            let marker = rom::marker(path, &Rom::read(path)?)?;
            return Ok(Self { marker, id: None });
        }
        if !ends(".json") {
            return Err(DrawingError::Kind { path: path.to_owned() });
        }
        let file = CalibrationFile::read(path, Kind::Marker)?;
        file.of_marker(path, "command line", name)?;
        let id = Some(file.id);
        // A file that was read has the part of its kind.
        let kind = || DrawingError::Kind { path: path.to_owned() };
        file.marker_body.map(|marker| Self { marker, id }).ok_or_else(kind)
    }

    /// The places of the emitters, by number.
    pub(crate) fn places(&self) -> Vec<Option<Point<Marker>>> {
        let place = |e: &Option<crate::calibration::EmitterRecord>| {
            let [x, y, z] = e.as_ref()?.at_mm;
            Some(Point::new(x, y, z))
        };
        self.marker.emitters.iter().map(place).collect()
    }
}
