//! What is in a recording, so that other programs can read it: schemas, messages, names.

pub(crate) mod descriptor;
pub mod proto;
pub mod schema;
pub(crate) mod seq;
