//! Where poses come from when the localizer is not simulated, the files that the chain's constants come from, and smoothing.
//!
//! Lengths are in mm, angles in radians.

mod check;
mod links;
pub mod raw;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use geometry::{Ct, Marker, Reference, Rigid, Tool};

use super::operating_room::{Deviations, Gates, ReferenceMarker, Shape};

pub(super) use check::{emitters, markers, sequence, smoothing};
pub(super) use links::link_files;

/// `source = "emitters"`: another program publishes what a localizer sees, and the tracker makes poses of it.
#[derive(Debug, Clone, PartialEq)]
pub struct EmitterSource {
    /// The marker on the tool.
    pub marker: Shape<Marker>,
    /// Where it sits on the tool, unless a calibration says.
    pub marker_from_tool: Rigid<Marker, Tool>,
    /// The marker on the patient, if there is one.
    pub reference: Option<ReferenceMarker>,
    /// How the localizer errs.
    pub noise: Noise,
    /// When a pose of the tool's marker is refused.
    pub gates: Gates,
    /// When one of the patient's is.
    pub reference_gates: Gates,
}

/// Standard deviations of a place, which grow as powers of its distance from the localizer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Across the line of sight, mm.
    pub across_mm: f64,
    /// Along it, mm.
    pub depth_mm: f64,
    /// The distance for which these hold, mm.
    pub at_mm: f64,
    /// The power of the one across.
    pub growth_across: f64,
    /// The power of the one along.
    pub growth_depth: f64,
    /// Coordinates are rounded to multiples of this, mm; 0: they are not.
    pub quantisation_mm: f64,
}

/// Markers whose poses somebody else makes: a file, or a localizer.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedMarkers {
    /// The name of the tool's marker; `None`: the only one.
    pub marker: Option<String>,
    /// Where it sits on the tool, unless a calibration says.
    pub marker_from_tool: Rigid<Marker, Tool>,
    /// The name of the marker on the patient, and where that sits unless a registration says.
    pub reference: Option<(String, Rigid<Ct, Reference>)>,
    /// How a pose errs, about the marker's origin; `None`: not known.
    pub noise: Option<Deviations>,
}

/// `source = "markers"`: a localizer that makes the poses of its markers itself.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerSource {
    /// The markers.
    pub markers: PosedMarkers,
    /// A pose whose localizer states a larger error of fit is refused, mm; `None`: not tested.
    pub max_error_mm: Option<f64>,
}

/// `source = "sequence"`: poses of markers from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SequenceSource {
    /// A sequence of the PLUS toolkit.
    pub file: PathBuf,
    /// The markers; their names are those of transforms.
    pub markers: PosedMarkers,
}

/// A file that a constant of the chain comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkFile {
    /// The file.
    pub path: PathBuf,
    /// The marker that it must be of; `None`: any.
    pub marker: Option<String>,
}

/// `[tracker.calibration]`
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationLink {
    /// Of `calib tool`.
    pub file: LinkFile,
    /// When it is refused.
    pub gates: CalibrationGates,
}

/// When a calibration is refused; `None` is not tested.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CalibrationGates {
    /// Largest root mean square residual, mm.
    pub max_rms_mm: Option<f64>,
    /// Largest root mean square error of the tip by its covariance, mm.
    pub max_tip_error_mm: Option<f64>,
    /// Largest condition of the equations.
    pub max_condition: Option<f64>,
    /// Least half opening of the cone that the motion filled, radians.
    pub min_cone_rad: Option<f64>,
}

/// `[tracker.registration]`
#[derive(Debug, Clone, PartialEq)]
pub struct RegistrationLink {
    /// Of `calib register` or `calib match`.
    pub file: LinkFile,
    /// A file that names no CT is taken.
    pub unchecked_ct: bool,
    /// When it is refused.
    pub gates: RegistrationGates,
}

/// When a registration is refused; `None` is not tested.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RegistrationGates {
    /// Largest root mean square residual of the points, mm.
    pub max_fre_mm: Option<f64>,
    /// Largest condition of the points' layout.
    pub max_condition: Option<f64>,
    /// Largest error predicted at the target, 95 %, mm.
    pub max_tre_mm: Option<f64>,
}

/// The files of the chain's constants; `None`: the scene's own numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LinkFiles {
    /// The tool's calibration.
    pub calibration: Option<CalibrationLink>,
    /// The patient's registration.
    pub registration: Option<RegistrationLink>,
}
