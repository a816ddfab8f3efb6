//! What `calib check` knows of the tip's error in registration and touch.

use std::path::Path;

use bead::check::TipParts;
use geometry::{Point, Tracker, UncertainPoint};
use nalgebra::{Matrix3, Matrix6, Matrix6x3};

use super::error::{BeadsError, unusable};
use crate::input_files::points_text;
use crate::input_files::source::Source;
use crate::live::{calibration_of, touched_in};
use crate::register::file::RegistrationFile;
use crate::values::Name;

/// The touch of the known point.
pub(super) struct Touch {
    /// With the hand's error, and the tip's.
    pub(super) place: UncertainPoint<Tracker>,
    /// What the tip's calibration moves it by, as `u1x` to `u3z`, where it is told.
    pub(super) shared: Option<Matrix3<f64>>,
    /// Which calibration that is.
    pub(super) calibration: Option<String>,
}

impl Touch {
    /// A place of which no more is known.
    pub(super) const fn plain(place: UncertainPoint<Tracker>) -> Self {
        Self {
            place,
            shared: None,
            calibration: None,
        }
    }

    /// The only touch of a file, in the frame `from`, of a hand of this deviation.
    pub(super) fn read(path: &Path, from: &str, hand_mm: f64) -> Result<Self, BeadsError> {
        touched_in(path, Some(&Name::told(from)))?;
        let source = Source::read(path)?;
        let points = points_text::read(&source)?;
        let [point] = &points[..] else {
            let found = format!("it has {} touches; expected the one of the known point", points.len());
            return Err(unusable(path, found));
        };
        let error = point.error.filter(points_text::StatedError::is_good);
        let error = error.ok_or_else(|| {
            unusable(
                path,
                format!(
                    "line {}: it states no covariance of the touch; give --touched",
                    point.line
                ),
            )
        })?;
        let [x, y, z] = point.mm;
        let hand = Matrix3::identity() * (hand_mm * hand_mm);
        let place = UncertainPoint::new(Point::new(x, y, z), error.covariance + hand);
        Ok(Self {
            place: place.map_err(|error| unusable(path, error.to_string()))?,
            shared: error.shared,
            calibration: calibration_of(&source.text).map(str::to_owned),
        })
    }
}

/// The tip's parts of a registration and a touch.
pub(super) fn parts(path: &Path, file: &RegistrationFile, touch: &Touch) -> Result<TipParts, BeadsError> {
    let told = file.shared.as_ref();
    let columns = told.and_then(|shared| shared.columns);
    let registration = columns.map(|rows| Matrix6x3::from_fn(|i, j| rows[i][j]));
    if let (Some(shared), Some(rows)) = (&registration, file.covariance) {
        let covariance = Matrix6::from_fn(|i, j| rows[i][j]);
        // In units in which each variance is 1: turns are small numbers beside shifts.
        let unit = covariance
            .diagonal()
            .map(|variance| 1.0 / variance.max(f64::MIN_POSITIVE).sqrt());
        let unit = Matrix6::from_diagonal(&unit);
        let own = unit * (covariance - shared * shared.transpose()) * unit;
        let is_good = own.iter().all(|x| x.is_finite()) && own.symmetric_eigenvalues().min() >= -1e-6;
        if !is_good {
            return Err(unusable(
                path,
                "its shared.columns are more than its covariance; register again",
            ));
        }
    }
    let calibration = told.and_then(|shared| shared.calibration.as_deref());
    Ok(TipParts {
        registration,
        touch: touch.shared,
        same: calibration.is_some() && calibration == touch.calibration.as_deref(),
    })
}

/// What is known of the tip's error, in words.
pub(super) fn words(file: &RegistrationFile, touch: &Touch, parts: &TipParts) -> String {
    let calibration = file.shared.as_ref().and_then(|shared| shared.calibration.as_deref());
    let why = match (parts.registration, parts.touch) {
        _ if parts.is_known() => {
            return "the same calibration in registration and touch: it cancels, and what is left of it counts"
                .to_owned();
        }
        (None, _) if file.shared.is_some() => "the registration is without it",
        // Nothing can be taken off a covariance that may have it or not.
        (None, _) => {
            return "the registration does not tell it apart: what its covariance has of it is counted, and the check is as much the \
                    looser; the touch's counts for nothing"
                .to_owned();
        }
        (_, None) => "the touch does not tell it apart",
        _ if calibration.is_some() && touch.calibration.is_some() => {
            "registration and touch are with different calibrations"
        }
        _ => "registration or touch does not name its calibration",
    };
    format!("{why}: as far as it is told it counts for nothing, and the check is the stricter for it")
}
