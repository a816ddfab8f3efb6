//! What several test files share.

#![allow(
    dead_code,
    clippy::print_stderr,
    reason = "each test file uses some of it; a test that is not run says why"
)]

pub(crate) mod cases;
pub(crate) mod scenes;

use serde_json::Value;

/// The reference solutions computed with independent finite-element codes, or `None` with the reason printed.
pub(crate) fn oracle() -> Option<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/oracles/solids.json");
    match std::fs::read_to_string(path) {
        // Python wrote what has no value as NaN, which JSON does not know.
        Ok(text) => Some(serde_json::from_str(&text.replace("NaN", "null")).expect("the reference solutions are JSON")),
        Err(error) => {
            eprintln!("not run: {path}: {error}");
            None
        }
    }
}
