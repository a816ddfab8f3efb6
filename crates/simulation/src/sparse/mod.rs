//! Sparse symmetric matrices: sums of entries, `L D L^T` without pivoting, and the signs of its pivots.
//!
//! Written here because systems are small (100 to 10 000 unknowns) and change their pattern with every contact: the cost of a
//! call and of a new order counts as much as the rate of large dense blocks, which is the library's. The signs of `D` are the inertia of the
//! matrix (Sylvester), which tells a minimum from a saddle.

mod front;
mod graph;
mod ldl;
mod order;
mod symbolic;
#[cfg(test)]
mod tests;
mod tree;
mod triplets;

pub use ldl::{Inertia, Ldl, NoPivot};
pub use triplets::Triplets;
