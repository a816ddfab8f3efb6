//! Paired-point registration: the rigid transform that brings a cloud of points `b_i` in `From` nearest to the same
//! points `a_i` seen in `To` (thesis, part III, chapter 4).
//!
//! Minimised is the weighted mean of `|a_i - (R b_i + t)|^2` (4.1). With both clouds centred (4.4 to 4.6) the best
//! rotation maximises `tr(R^T Psi)` (4.13), `Psi = mean(a'_i b'_i^T)` (4.10); `t = mean(a) - R mean(b)` follows.
//!
//! | step | cost at n = 24 | where |
//! |---|---|---|
//! | points to [`Moments`] | one pass for the centres, one for `Psi` | [`Moments::of`] |
//! | moments to rotation | by the chosen [`Method`] | [`Moments::solve`] |
//! | both, and the transform | allocates nothing | [`fit()`] |
//! | residuals per point, leave-one-out, covariance | allocates | [`register`] |
//!
//! The answer exists and is unique where the condition number `s1 / (s2 + sgn s3)` of `Psi` is finite; it is then
//! reached within 20 x 2^-53 x condition radians. Everything else is refused by name, with the singular values:
//! [`Refused`].
//!
//! ```
//! use calib::registration::{Method, Noise, Pairs, register};
//! use geometry::{Ct, Point, Tracker, Vector};
//!
//! let seen: [Point<Tracker>; 4] =
//!     [[0.0, 0.0, 0.0], [60.0, 0.0, 0.0], [0.0, 80.0, 0.0], [0.0, 0.0, 50.0]].map(|[x, y, z]| Point::new(x, y, z));
//! let in_scan = seen.map(|p| Point::<Ct>::new(-p.mm()[1], p.mm()[0], p.mm()[2]) + Vector::new(5.0, 0.0, -7.0));
//! let found = register(Pairs::new(&in_scan, &seen)?, Method::default())?;
//! assert!(found.fre_rms_mm < 1e-12 && found.fit.certificate().is_global());
//! let tre_mm = found.predicted_tre_mm(Noise { sigma_mm: 0.3 }, Point::new(0.0, 0.0, 100.0));
//! assert!(tre_mm > 0.3 && tre_mm < 2.0);
//! # Ok::<(), calib::registration::Refused>(())
//! ```

mod anisotropic;
mod certificate;
mod clique;
mod error;
mod fit;
mod horaud_monga;
pub(crate) mod jacobi;
mod leave_one_out;
mod method;
mod mirror;
mod moments;
mod newton;
mod pairs;
mod planar;
mod polar;
mod propagated;
mod quaternion;
mod register;
mod robust;
mod rotation_vector;
mod scaled;
mod small_sample;
mod statistics;
mod svd;
mod told_noise;

pub use anisotropic::{Anisotropic, register_anisotropic};
pub use certificate::Certificate;
pub use error::{Refused, SingularValues};
pub use fit::{Fit, fit};
pub use horaud_monga::fit_horaud_monga;
pub use jacobi::symmetric3;
pub use method::Method;
pub use mirror::Mirror;
pub use moments::Moments;
pub use pairs::Pairs;
pub use planar::{PlanarFit, fit_planar};
pub use propagated::{PairError, Propagated, chi_squared, propagated, rms_at};
pub use register::{Registration, register};
pub use robust::{Robust, register_robust};
pub use scaled::{Scaled, fit_scaled};
pub use small_sample::few_residuals_factor;
pub use statistics::{Noise, predicted_tre_mm};
pub use told_noise::{greatest_chi_squared, told_noise_factor};
