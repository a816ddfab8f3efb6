//! The chain of a scene with the constants of its files, without a run: what the tracker would make poses with.

use geometry::{Ct, Point};
use scene::{Scene, TrackerSource};

use super::emitters::chain_of_scene;
use super::link_files::{Expected, calibration, registration};
use crate::chain::Chain;
use crate::markers::MarkersError;

/// Why a scene with its files gives no chain.
#[derive(Debug, thiserror::Error)]
pub enum FiledError {
    /// No emitters come from elsewhere.
    #[error("tracker.source must be \"emitters\" for a chain of files")]
    Source,
    /// The scene's markers or its localizer are unusable.
    #[error(transparent)]
    Markers(#[from] MarkersError),
    /// The calibration or the registration is refused, as the tracker refuses it.
    #[error("{0}")]
    Refused(String),
}

/// The chain of a scene whose localizer delivers emitters, in a run of the CT with this hash: calibration and registration are
/// those of the files that the scene names, read and refused as the tracker reads and refuses them. `region` is where in the
/// patient errors count.
///
/// # Errors
/// Each variant of [`FiledError`].
pub fn chain_of_files(scene: &Scene, ct_hash: &str, region: Point<Ct>) -> Result<Chain, FiledError> {
    let TrackerSource::Emitters(spec) = &scene.tracker.source else {
        return Err(FiledError::Source);
    };
    let mut chain = chain_of_scene(scene, spec, region)?;
    let expected = Expected {
        tool: scene.tool.name.clone(),
        ct_hash: ct_hash.to_owned(),
        has_reference: chain.reference.is_some(),
        target: region,
    };
    if let Some(link) = &scene.tracker.links.calibration {
        chain.marker_from_tool = calibration(link, &expected).map_err(FiledError::Refused)?;
    }
    if let Some(link) = &scene.tracker.links.registration {
        chain.registration = registration(link, &expected).map_err(FiledError::Refused)?.registration;
    }
    Ok(chain)
}
