//! What a file says of itself that is not the last of its session.

use mcap::records::Metadata;

/// The name of the metadata record: a whole file that ends with it is one part, and the session goes on in another file.
pub(crate) const PART: &str = "part";
/// How many files of the session came before it.
pub(crate) const BEFORE: &str = "files_before";

/// The record of a file before which so many came.
pub(crate) fn record(files_before: u32) -> Metadata {
    Metadata {
        name: PART.to_owned(),
        metadata: [(BEFORE.to_owned(), files_before.to_string())].into(),
    }
}
