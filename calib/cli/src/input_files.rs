//! Files of numbers as they lie on the disk, read line by line.

pub(crate) mod columns;
pub(crate) mod fields;
pub(crate) mod pairs_csv;
pub(crate) mod points_text;
pub(crate) mod source;
