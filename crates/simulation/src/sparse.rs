//! Sparse symmetric matrices: sums of entries, `L D L^T` without pivoting, and the signs of its pivots.
//!
//! Written here because systems are small (100 to 10 000 unknowns) and change their pattern with every contact: the cost of a
//! call and of a new order counts as much as the rate of large dense blocks, which is the library's. The signs of `D` are the inertia of the
//! matrix (Sylvester), which tells a minimum from a saddle.
//!
//! Meshes in space are larger and keep their pattern: they are ordered by nested dissection ([`Dissection`]), solve from a factor packed
//! for it, in single precision where that is asked for ([`Precision`]), and eliminate by several threads.
//!
//! Multifrontal: `graph` holds the pattern and unknowns that are alike, `order` the order of elimination (minimum degree or nested
//! dissection), `tree` the elimination tree and its supernodes, `symbolic` the fronts and where entries go, `front` the dense kernels
//! (large ones by `nalgebra`'s product), `numbers` a front's elimination and `parallel` that of all by threads (`share`), `ldl` the
//! whole, `solution` what is solved with it, by `substitution` in the factor or in one `packed` for it (`store`), `compliance` what a few
//! combinations of unknowns move of one another.

mod dense;
mod extend;
mod front;
mod graph;
mod kept;
mod ldl;
mod number;
mod numbers;
mod order;
mod packed;
mod parallel;
mod parts;
mod product;
mod share;
mod solution;
mod store;
mod substitution;
mod symbolic;
#[cfg(test)]
mod tests;
mod tree;
mod triplets;

pub(crate) use dense::Dense;
pub use ldl::{Inertia, Ldl, NoPivot};
pub use order::{Dissection, NoOrder};
pub use solution::Reduced;
pub use store::Precision;
pub use triplets::Triplets;
