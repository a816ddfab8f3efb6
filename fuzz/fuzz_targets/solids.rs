//! A scene of solids, as `simulate check` reads it.

#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = simulation_cli::check(text.to_owned(), Path::new("fuzz.toml"));
    }
});
