//! Keys, sessions, and forgers.

pub(crate) mod authority;
pub(crate) mod forger;
pub(crate) mod room;
