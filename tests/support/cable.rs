//! A network of its own for a peer, with a cable that can be pulled.

use std::path::Path;
use std::process::Command;

/// A network namespace with one link to this one.
pub struct Cable {
    name: String,
    /// Of whoever lives there.
    pub address: String,
}

impl Cable {
    /// `None`, with a printed reason, where this may not be done.
    pub fn new() -> Option<Self> {
        let number = std::process::id();
        let (name, near, far) = (format!("tr{number}"), format!("tn{number}"), format!("tf{number}"));
        // Of 10.213.0.0/16 four addresses for each process.
        let base = (number % 16_000) * 4;
        let host = |last: u32| format!("10.213.{}.{}", (base + last) / 256, (base + last) % 256);
        let cable = Self {
            name: name.clone(),
            address: host(2),
        };
        let steps = [
            format!("netns add {name}"),
            format!("link add {near} type veth peer name {far}"),
            format!("link set {far} netns {name}"),
            format!("addr add {}/30 dev {near}", host(1)),
            format!("link set {near} up"),
            format!("-n {name} addr add {}/30 dev {far}", host(2)),
            format!("-n {name} link set {far} up"),
        ];
        let done = steps.iter().all(|step| ip(step));
        if !done {
            println!("skipped: no network namespaces here (ip of iproute2, as root)");
            return None;
        }
        Some(cable)
    }

    /// A program that will live there.
    pub fn command(&self, program: &Path) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.name]).arg(program);
        command
    }

    /// `up` or `down`.
    pub fn set(&self, state: &str) {
        let number = std::process::id();
        assert!(ip(&format!("-n {} link set tf{number} {state}", self.name)));
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        // The link goes with it.
        ip(&format!("netns del {}", self.name));
    }
}

fn ip(arguments: &str) -> bool {
    let output = Command::new("ip").args(arguments.split(' ')).output();
    output.is_ok_and(|output| output.status.success())
}
