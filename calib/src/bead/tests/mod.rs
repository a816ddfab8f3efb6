//! Tests of the whole search.

mod accuracy;
mod grounds;
mod rivals;
mod slices;
mod specimen;
