//! Tests of the whole search.

mod accuracy;
mod grounds;
mod rivals;
mod slices;
pub(super) mod specimen;
