//! From files, whole or not: everything is built on one tolerant reader, [`scan`].

pub(crate) mod chunk;
pub mod damage;
pub(crate) mod file_records;
pub mod info;
pub(crate) mod lost;
pub(crate) mod one_run;
pub(crate) mod organs;
pub mod reader;
pub mod scan;
pub mod seek;
pub(crate) mod spread;
mod stated;
pub(crate) mod tally;
pub(crate) mod timing;
pub mod verify;
