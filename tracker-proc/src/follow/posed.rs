//! Markers whose poses come ready made, from a file or from a localizer: their constants and their errors.

use geometry::{Ct, Frame, Point, Rigid, Tracker, Uncertain};
use scene::operating_room::Deviations;
use scene::tracking::PosedMarkers;

use super::Source;
use crate::chain::{Links, Registration};
use crate::errors::errors_about;

/// How such a source describes itself. Nothing is stated of how well a scene knows where its markers sit.
pub(super) fn source(markers: &PosedMarkers, ct_from_tracker: Rigid<Ct, Tracker>) -> Source {
    Source {
        own: Links {
            marker_from_tool: markers.marker_from_tool.into(),
            registration: match &markers.reference {
                Some((_, ct_from_reference)) => Registration::Referenced((*ct_from_reference).into()),
                None => Registration::Fixed(ct_from_tracker.into()),
            },
        },
        own_errors_known: false,
        errors_known: markers.noise.is_some(),
        has_reference: markers.reference.is_some(),
        noiseless: false,
    }
}

/// A pose with the noise that the scene states, about the marker's origin; none where that noise cannot be.
pub(crate) fn uncertain<F: Frame>(pose: Rigid<Tracker, F>, noise: Option<Deviations>) -> Option<Uncertain<Tracker, F>> {
    let Some(noise) = noise else {
        return Some(pose.into());
    };
    let origin = pose * Point::<F>::new(0.0, 0.0, 0.0);
    Some(errors_about(origin, noise).ok()? * pose)
}
