//! Quasi-static simulation of rigid and deformable solids in the plane, after chapter II 3 of Bainville's thesis, and in
//! three dimensions ([`space`]).
//!
//! At each instant the system is in a local minimum of its potential energy within the free space. Three parts that know
//! as little of one another as can be:
//!
//! * [`solid`]: geometry and deformation. A solid is a black box: a number of parameters held outside of it, an energy
//!   with two derivatives, and a boundary with [`solid::Cursor`]s. Meshes of nine-node elements ([`q9`]) of an elastic
//!   [`law`], rigid polygons, and solids in a deformable block.
//! * [`constraint`]: links and contacts, terms of the energy that see boundaries only.
//! * [`control`]: the search for the minimum, which sees vectors and sparse matrices ([`sparse`]) only.
//!
//! A [`system::System`] joins them. Lengths, forces and stresses are in any consistent units: no tolerance is absolute.

pub mod bodies;
pub mod constraint;
pub mod control;
pub mod equilibrium;
pub mod law;
pub mod q9;
pub mod solid;
pub mod space;
pub mod sparse;
pub mod system;
mod turn;
