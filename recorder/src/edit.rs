//! Whole files of other files: recovered, cut, joined by attachments, translated, compared.

pub(crate) mod attach;
pub(crate) mod compare;
pub mod cut;
pub mod export;
pub mod import;
pub(crate) mod progress;
pub mod recover;
pub(crate) mod recovered;
