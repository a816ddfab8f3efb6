//! Clients that are not of this project: the C++ library OpenIGTLink, and pyigtl. Where they are not to be had, a test says so and is skipped.

#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "peers are programs of others, and a test that is skipped says why"
)]

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::OnceLock;

use serde_json::Value;

const HEADERS: &str = "/usr/include/openigtlink";

/// The C++ client, compiled once; `None` with a printed reason where there is no compiler or no library.
pub(crate) fn cxx() -> Option<&'static Path> {
    static PEER: OnceLock<Option<PathBuf>> = OnceLock::new();
    told(PEER.get_or_init(|| compiled("peer")).as_deref())
}

/// The C++ server, likewise.
pub(crate) fn cxx_server() -> Option<&'static Path> {
    static SERVER: OnceLock<Option<PathBuf>> = OnceLock::new();
    told(SERVER.get_or_init(|| compiled("server")).as_deref())
}

fn told(program: Option<&'static Path>) -> Option<&'static Path> {
    if program.is_none() {
        println!("skipped: no C++ peer (on Debian: apt-get install g++ libopenigtlink-dev)");
    }
    program
}

fn compiled(name: &str) -> Option<PathBuf> {
    if !Path::new(HEADERS).exists() {
        return None;
    }
    let source = super::root().join(format!("tests/interop/{name}.cxx"));
    // Beside the tests; of one process, as several may compile at once.
    let folder = std::env::current_exe().ok()?.parent()?.to_owned();
    let out = folder.join(format!("igtl-{name}-{}", std::process::id()));
    let done = Command::new("g++")
        .args(["-O2", "-I", HEADERS, "-o"])
        .arg(&out)
        .arg(&source)
        .arg("-lOpenIGTLink")
        .output();
    let done = done.ok()?;
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    // Every process that uses it has its own: it is removed once the file is open for as long as it runs.
    Some(out)
}

/// Starts the C++ client.
pub(crate) fn start(peer: &Path, address: SocketAddr, arguments: &[&str]) -> Child {
    Command::new(peer)
        .args([address.ip().to_string(), address.port().to_string()])
        .args(arguments)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The lines that the C++ client has printed when it ended well.
pub(crate) fn lines(child: Child) -> Vec<String> {
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}");
    text.lines().map(str::to_owned).collect()
}

/// Runs the script over pyigtl and gives what it prints; `None` with a printed reason where there is no interpreter.
pub(crate) fn python(address: SocketAddr, arguments: &[&str]) -> Option<Child> {
    let Some(python) = std::env::var_os("TROCAR_PYTHON") else {
        println!("skipped: TROCAR_PYTHON is not set (`cargo xtask test` prepares an interpreter and sets it)");
        return None;
    };
    let script = super::root().join("tests/python/check_gateway.py");
    let child = Command::new(python)
        .arg(script)
        .args([address.ip().to_string(), address.port().to_string()])
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    Some(child.unwrap())
}

/// What the script printed.
pub(crate) fn printed(child: Child) -> Value {
    let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
    assert!(status.success(), "{}", String::from_utf8_lossy(&stderr));
    serde_json::from_slice(&stdout).unwrap()
}

/// The numbers behind the first `skip` words of a line.
pub(crate) fn numbers(line: &str, skip: usize) -> Vec<f64> {
    line.split_whitespace()
        .skip(skip)
        .map(|word| word.parse().unwrap_or_else(|_| panic!("{word:?} in {line:?}")))
        .collect()
}
