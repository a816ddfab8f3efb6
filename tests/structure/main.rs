//! The house itself.

mod floors;
