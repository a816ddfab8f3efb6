//! The driver of each protocol.

use scene::localizer::LinkSpec;
use scene::tracking::{EmitterSource, PosedMarkers};

use crate::driver::Driver;
use crate::ndi::Ndi;
use crate::openigtlink::OpenIgtLink;

pub use crate::ndi::SetUpError;
pub use crate::openigtlink::NamesError;

/// Why there is no driver.
#[derive(Debug, thiserror::Error)]
pub enum DriverError {
    /// The names of OpenIGTLink's tools.
    #[error(transparent)]
    Names(#[from] NamesError),
    /// The tools of a device of NDI.
    #[error(transparent)]
    Ndi(#[from] SetUpError),
    /// The tracker follows emitters.
    #[error("OpenIGTLink has no single markers; tracker.source = \"markers\" follows its poses")]
    NoEmitters,
}

/// What is made of what a localizer sees.
#[derive(Debug, Clone, Copy)]
pub enum Follows<'a> {
    /// Poses of markers, made by the localizer.
    Markers(&'a PosedMarkers),
    /// Single markers, of which the tracker makes poses.
    Emitters(&'a EmitterSource),
}

/// What speaks the scene's protocol; not connected yet.
///
/// # Errors
/// [`DriverError`].
pub fn of(link: &LinkSpec, follows: Follows<'_>) -> Result<Box<dyn Driver>, DriverError> {
    Ok(match (link, follows) {
        (LinkSpec::OpenIgtLink(link), Follows::Markers(markers)) => Box::new(OpenIgtLink::new(link, markers)?),
        (LinkSpec::OpenIgtLink(_), Follows::Emitters(_)) => return Err(DriverError::NoEmitters),
        (LinkSpec::Ndi(link), follows) => Box::new(Ndi::new(link, follows)?),
    })
}
