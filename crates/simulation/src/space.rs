//! Bodies in space: the rigid instruments that tissue is held against.

pub mod tube;
