//! The reasons of the numerics, with what a person can do about each.

use calib::registration::Refused;

/// Why pairs that were read well have no registration.
#[derive(Debug, thiserror::Error)]
#[error("registering the {pairs} pairs of {files} by {method}: {refused}. {}", advice(.refused))]
pub(crate) struct NoRegistration {
    pub(crate) pairs: usize,
    pub(crate) files: String,
    pub(crate) method: &'static str,
    pub(crate) refused: Refused,
}

fn advice(refused: &Refused) -> &'static str {
    match refused {
        Refused::TooFew { .. } | Refused::NoWeight { .. } => "Measure at least 3 points that are not on a line",
        Refused::Coincident { .. } => {
            "Check that the columns hold different points, spread over the volume of interest"
        }
        Refused::Collinear(_) => "Add a point well off that line",
        Refused::Reflected(_) => {
            "One side is the mirror image of the other: check the sign of each axis and the order of the points"
        }
        Refused::MethodFails(_) => "Leave --method out",
        Refused::NoConsensus { .. } => "Check the pairing, widen --robust, or accept fewer pairs with --min-inliers",
        Refused::SearchTooLong { .. } => "Give --robust a smaller tolerance or fewer pairs",
        Refused::NoConvergence { .. } => "The set of inliers keeps changing: change --robust a little",
        Refused::Unpaired { .. } | Refused::Unmatched { .. } => "Give every point its partner",
        Refused::NotFinite { .. } | Refused::BadWeight { .. } | Refused::BadCovariance { .. } => {
            "Check that pair in the file"
        }
    }
}
