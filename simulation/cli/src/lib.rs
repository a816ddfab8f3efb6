//! Floor 2: `simulate`, the command line of the quasi-static simulation of solids: a scene file in, pictures of states and
//! fields and a report out.
//!
//! The mechanics are in the crate `simulation`; here are the file, the model made of it, the way from state to state, the
//! pictures and the words. Numbers are in the units that the scene names: no conversion is made, and nothing depends on
//! them. Forces are of a unit of depth.

pub mod cli;
mod draw;
mod model;
mod output;
mod report;
mod run;
mod scene;
mod words;
