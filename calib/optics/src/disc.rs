//! Discs in images: where they are to a pixel ([`detect()`]), and to hundredths of one ([`fit_disc`]).
//!
//! Section 5.1 of part III of the thesis, with what it leaves open: the radius is estimated, uniform regions and ties are
//! defined, sums are exact. [`Blurred`] is the model of an ellipse behind a blur that all fits share.

mod blurred;
mod chi;
mod detect;
mod ellipse;
mod equations;
mod error;
mod fit;
mod normal;
mod raster;
mod region;

pub(crate) use blurred::REACH;
pub use blurred::{Blurred, Coverage};
pub use chi::{Chi, Probe};
pub use detect::{DetectOptions, Disc, MAX_DISCS, Polarity, detect};
pub use ellipse::{Axes, Ellipse};
pub(crate) use equations::{Equations, Sums};
pub use error::{DetectRefused, FitRefused};
pub(crate) use fit::fit_expected;
pub use fit::{DiscFit, fit_disc};
pub(crate) use raster::Raster;
pub use region::Region;
