//! Sparse symmetric matrices: sums of entries, `L D L^T` without pivoting, and the signs of its pivots.
//!
//! Written here because systems are small (100 to 10 000 unknowns) and change their pattern with every contact: what
//! counts is the cost of a call, not the rate of large dense blocks. The signs of `D` are the inertia of the matrix
//! (Sylvester), which tells a minimum from a saddle.

mod ldl;
mod order;
mod symbolic;
mod triplets;

pub use ldl::{Inertia, Ldl, NoPivot};
pub use order::minimum_degree;
pub use triplets::Triplets;
