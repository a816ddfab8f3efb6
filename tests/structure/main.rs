//! The house itself.

mod circles;
mod floors;
