//! Trocar beside software of others that speaks OpenIGTLink.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

mod cable;
mod claims;
mod clients;
mod faults;
mod followed;
mod hostile;
mod markers;
mod peers;
mod pictures;
mod pilot;
mod poses;
mod rig;
#[path = "../support/mod.rs"]
mod support;

/// The program under test.
#[allow(clippy::disallowed_methods, reason = "tests start the real binaries")]
fn gateway() -> std::process::Command {
    std::process::Command::new(env!("CARGO_BIN_EXE_gateway-proc"))
}

fn root() -> std::path::PathBuf {
    env!("CARGO_MANIFEST_DIR").into()
}
