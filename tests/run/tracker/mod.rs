//! Where poses come from.

mod emitters;
mod links;
mod markers;
mod rate;
mod sequence;
