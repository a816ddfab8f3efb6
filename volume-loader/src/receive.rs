//! Examinations from a PACS: a receiver of DICOM's storage service (PS3.4 annex B), which also answers verification (annex A).
//!
//! One association at a time. PDUs are read and written by `dicom-ul`; what is kept of them is bounded here: bytes, files, room on the
//! disk, and time. Data sets go byte for byte into a hidden file, are walked through to their end, and only then get a name, which is
//! made of checked UIDs. Nothing that a peer says opens a connection or a file of its choosing.
//!
//! A series that an association brings lies in a hidden folder until that association ends in order with nothing of the series refused
//! ([`Store`]): what broke off is not taken for an examination.

mod association;
mod command;
mod contexts;
mod instance;
mod limits;
mod message;
mod outcome;
mod part;
mod progress;
mod server;
mod store;
mod uid;
mod wire;

#[cfg(test)]
mod tests;

pub use association::{Rules, serve_bytes};
pub use limits::Limits;
pub use outcome::{Came, Ended, Outcome};
pub(crate) use server::{ServeError, Server};
pub use store::{Store, StoreError};
