//! Laws of behaviour: the elastic energy of a unit of reference area as a function `w(F)` of the deformation gradient.
//!
//! The argument is the *displacement gradient* `G = F - I`, never a strain: the Green-Lagrange tensor hides the sign of
//! `det F`, so that no law of it can be safe against inversion, and forming `F^T F - I` from positions loses every digit
//! of a small strain. All is plane strain: the third stretch is 1.
//!
//! Every law is `w = w_s(G) + (lambda / 2) theta(G)^2` with a measure of volume `theta` of its own; the mixed form of the
//! elements projects `theta` and leaves the rest alone.

mod lame;
mod linear;
mod material;
mod neo_hookean;
mod ogden;
mod project;
mod response;
mod saint_venant;
mod stress;

#[cfg(test)]
mod tests;

pub use lame::Lame;
pub use material::{Law, Material};
pub(crate) use neo_hookean::x_minus_ln_1p;
pub use ogden::Ogden;
pub use project::{Modes, signed_svd};
pub use response::{Response, Volume};
pub use stress::Stress;

/// Why a material cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refused {
    /// Young's modulus is not a finite number above zero.
    #[error("Young's modulus is {found}; it must be a finite number above 0")]
    Young {
        /// The number found.
        found: f64,
    },
    /// Poisson's ratio is outside the open interval from -1 to 1/2.
    #[error("Poisson's ratio is {found}; it must be above -1 and below 0.5 (at 0.5 lambda is infinite)")]
    Poisson {
        /// The number found.
        found: f64,
    },
    /// The exponents and weights of an Ogden law.
    #[error(
        "term {term} of the Ogden law is weight {weight}, exponent {exponent}: their product must be finite and above 0"
    )]
    OgdenTerm {
        /// Index of the term, from 0.
        term: usize,
        /// The weight found.
        weight: f64,
        /// The exponent found.
        exponent: f64,
    },
    /// An Ogden law of no term or of too many.
    #[error("an Ogden law has 1 to {most} terms; {found} were given")]
    OgdenTerms {
        /// How many were given.
        found: usize,
        /// The most that are kept.
        most: usize,
    },
}
