//! The driver of each protocol.

use scene::localizer::LinkSpec;
use scene::tracking::PosedMarkers;

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
}

/// What speaks the scene's protocol; not connected yet.
///
/// # Errors
/// [`DriverError`].
pub fn of(link: &LinkSpec, markers: &PosedMarkers) -> Result<Box<dyn Driver>, DriverError> {
    Ok(match link {
        LinkSpec::OpenIgtLink(link) => Box::new(OpenIgtLink::new(link, markers)?),
        LinkSpec::Ndi(link) => Box::new(Ndi::new(link, markers)?),
    })
}
