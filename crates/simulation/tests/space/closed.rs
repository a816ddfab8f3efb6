//! Closed forms of large strains and of the half space.

mod half_space;
mod punch;
mod rivlin;
