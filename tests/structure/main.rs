//! The house itself.

mod circles;
mod documents;
mod floors;
