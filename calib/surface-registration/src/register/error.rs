//! Why there is no registration at all.

/// Why there is no registration at all. What is found and not good enough is refused by [`crate::Limits::judge`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RegisterError {
    /// An option is out of its range.
    #[error("{what} is {found}; allowed is {allowed}")]
    Option {
        /// Which.
        what: &'static str,
        /// What was given.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The points are spread wider than the bone is: another bone, or another unit.
    #[error(
        "the points are {points_mm:.0} mm across, the surface is {surface_mm:.0} mm: they are not of this bone, or not in mm"
    )]
    TooWide {
        /// Diameter of the points, without the widest tenth, mm.
        points_mm: f64,
        /// Diagonal of the surface's box, mm.
        surface_mm: f64,
    },
    /// Fewer than three landmarks, or such as do not determine a pose.
    #[error("landmarks: {0}")]
    Landmarks(#[from] calib::registration::Refused),
    /// A landmark's deviation is not above 0 mm.
    #[error("landmark {landmark}: its deviation is {found} mm; above 0 is allowed")]
    LandmarkSigma {
        /// The first such landmark, from 0.
        landmark: usize,
        /// What was given, mm.
        found: f64,
    },
    /// No start led to a minimum.
    #[error("none of {seeds} starts led to a pose: the points lie nowhere near the surface from any of them")]
    Nowhere {
        /// Starts that were scored.
        seeds: usize,
    },
}
