//! The target that the environment variable `TROCAR_FUZZ` names.

#![no_main]

use std::sync::LazyLock;

use trocar_fuzz::{TARGETS, Target};

static TARGET: LazyLock<&Target> = LazyLock::new(|| {
    let asked = std::env::var("TROCAR_FUZZ").unwrap_or_default();
    let found = TARGETS.iter().find(|t| t.name == asked);
    found.unwrap_or_else(|| panic!("TROCAR_FUZZ names no target: {asked:?}"))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (TARGET.take)(bytes));
