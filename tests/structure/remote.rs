//! What `remote-proc`, a workspace of its own, must have in common with this one.

use std::fs;

use crate::floors::root;

fn version(lock: &str, name: &str) -> String {
    let text = fs::read_to_string(root().join(lock)).unwrap();
    let of = |package: &str| {
        package
            .lines()
            .find_map(|line| line.strip_prefix("version = ").map(str::to_owned))
    };
    let named = format!("name = \"{name}\"\n");
    let found: Vec<String> = text
        .split("[[package]]")
        .filter(|package| package.contains(&named))
        .filter_map(of)
        .collect();
    assert_eq!(found.len(), 1, "{lock} has {} versions of {name}", found.len());
    found[0].clone()
}

/// Its processes join the same bus, which another version of these would lay out differently.
#[test]
fn the_second_machines_program_is_built_with_the_same_bus() {
    for name in ["iceoryx2", "blake3", "bytemuck"] {
        assert_eq!(
            version("Cargo.lock", name),
            version("remote-proc/Cargo.lock", name),
            "{name}"
        );
    }
}

/// Nobody else may name what lies on the network.
#[test]
fn zenoh_is_no_dependency_of_the_workspace() {
    let text = fs::read_to_string(root().join("Cargo.lock")).unwrap();
    assert!(!text.contains("name = \"zenoh\""));
}
