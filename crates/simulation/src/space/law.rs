//! Laws of behaviour in three dimensions: the elastic energy of a unit of reference volume as a function of the
//! displacement gradient `G = F - I`.
//!
//! The laws are those of the plane ([`crate::law::Law`]), each `w = w_s(G) + (lambda / 2) theta(G)^2` with a measure of
//! volume `theta` of its own, which the elements may project. Where the third stretch is 1 they are the plane's.
//!
//! Second-order tensors are vectors of 9, column by column: `(11, 21, 31, 12, 22, 32, 13, 23, 33)`. Nothing is formed
//! from `F` that `G` gives with more digits: a strain of 1e-12 keeps all of them.

mod fibre;
mod linear;
mod material;
mod neo_hookean;
mod ogden;
mod principal;
mod project;
mod response;
mod saint_venant;

#[cfg(test)]
mod tests;

pub use fibre::{BadFibre, Fibre};
pub use material::Material;
pub use response::{Response, Tangent, Tensor, Volume};

pub(crate) use response::{excess, vector};
