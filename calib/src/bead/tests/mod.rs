//! Tests of the whole search.

mod accuracy;
mod rivals;
mod specimen;
