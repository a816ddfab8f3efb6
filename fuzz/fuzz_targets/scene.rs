//! A scene file.

#![no_main]

use std::path::Path;

use bus::scene::Scene;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Err(error) = Scene::parse(text, Path::new("fuzz.toml"))
    {
        drop(error.to_string());
    }
});
