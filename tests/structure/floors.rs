//! The floors of the workspace: who may depend on whom, and how long a file may be.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Dependencies go strictly down. A new crate needs a line here, and one in ARCHITECTURE.md.
const FLOORS: &[(&str, u8)] = &[
    ("chance", 0),
    ("fit", 0),
    ("geometry", 0),
    ("calib", 1),
    ("exchange", 1),
    ("guidance", 1),
    ("igtl", 1),
    ("ndi", 1),
    ("optics", 1),
    ("phantom", 1),
    ("picture", 1),
    ("scene", 1),
    ("simulation", 1),
    ("surface", 1),
    ("ultrasound", 1),
    ("bead", 2),
    ("bone", 2),
    ("bus", 2),
    ("echo", 2),
    ("hand", 2),
    ("organs", 2),
    ("probe", 2),
    ("surface-registration", 2),
    ("calib-cli", 3),
    ("gateway-proc", 3),
    ("tissue-proc", 3),
    ("pilot", 3),
    ("recorder", 3),
    ("simulation-cli", 3),
    ("slice-view-proc", 3),
    ("localizer-proc", 3),
    ("tracker-proc", 3),
    ("volume-loader", 3),
    ("window", 3),
    ("study", 4),
    ("trocar", 5),
    ("trocar-fuzz", 5),
    ("xtask", 5),
];

/// Libraries behind a wall: what begins like the first may be named by the second only; by each of them where it stands
/// in several rows. Deflated bytes come in volumes and in sequences of ultrasound images, which are no volumes and are
/// read by a crate on the same floor.
const WALLS: &[(&str, &str)] = &[
    ("iceoryx2", "bus"),
    ("foxglove", "recorder"),
    ("mcap", "recorder"),
    ("dicom", "volume-loader"),
    ("flate2", "calib-cli"),
    ("flate2", "volume-loader"),
    ("hayro", "volume-loader"),
    ("nifti", "volume-loader"),
    ("pure_jpegls", "volume-loader"),
    ("hdf5", "exchange"),
    ("roxmltree", "exchange"),
    ("wgpu", "slice-view-proc"),
    ("egui", "window"),
    ("winit", "window"),
    ("softbuffer", "window"),
    ("x11rb", "window"),
    ("ab_glyph", "picture"),
    ("tiny-skia", "picture"),
];

/// Crates that may name these libraries and no others.
const SPARE: &[(&str, &[&str])] = &[
    ("chance", &[]),
    ("fit", &[]),
    (
        "exchange",
        &["geometry", "hdf5-pure", "roxmltree", "serde", "serde_json", "thiserror"],
    ),
    ("geometry", &["nalgebra", "serde"]),
    ("igtl", &["thiserror"]),
    ("ndi", &["thiserror"]),
    (
        "organs",
        &[
            "geometry",
            "nalgebra",
            "scene",
            "serde",
            "sha2",
            "simulation",
            "thiserror",
            "toml",
        ],
    ),
];

/// The longest file, lines: a thought may need more than a screen, and no more than a few.
const MAX_LINES: usize = 700;
/// The most files in one folder: as many names as a newcomer reads before choosing one.
const MAX_FILES: usize = 25;
/// A dependency as it stands in a manifest.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Edge {
    from: String,
    to: String,
    /// For tests and benchmarks only.
    dev: bool,
}

/// What is wrong with these dependencies, in words. `members` are the crates of the workspace.
fn violations(members: &[String], edges: &[Edge]) -> Vec<String> {
    let floors: BTreeMap<&str, u8> = FLOORS.iter().copied().collect();
    let homeless = members.iter().filter(|name| !floors.contains_key(name.as_str()));
    let mut wrong: Vec<String> = homeless
        .map(|name| format!("{name} has no floor: give it one in FLOORS"))
        .collect();
    for edge in edges {
        let Edge { from, to, dev } = edge;
        if let (Some(a), Some(b)) = (floors.get(from.as_str()), floors.get(to.as_str())) {
            let goes_down = if *dev { b <= a } else { b < a };
            if !goes_down {
                wrong.push(format!("{from} (floor {a}) depends on {to} (floor {b}): not down"));
            }
        }
        wrong.extend(over_the_wall(edge));
    }
    wrong
}

/// Tests may climb walls: an oracle is somebody else's library.
fn over_the_wall(Edge { from, to, dev }: &Edge) -> Vec<String> {
    if *dev {
        return Vec::new();
    }
    let owners: Vec<&str> = WALLS
        .iter()
        .filter(|(library, _)| to.starts_with(library))
        .map(|(_, owner)| *owner)
        .collect();
    let is_outside = !owners.is_empty() && !owners.contains(&from.as_str());
    let walls = is_outside.then(|| format!("{from} depends on {to}: only {} may", owners.join(" and ")));
    let spare = SPARE
        .iter()
        .filter(|(owner, few)| from == owner && !few.contains(&to.as_str()));
    let spare = spare.map(|(_, few)| format!("{from} depends on {to}: it may on {} only", few.join(", ")));
    walls.into_iter().chain(spare).collect()
}

/// What Cargo says of the packages of the workspace, or with those of others where `option` is not `--no-deps`.
pub(crate) fn packages(option: &str) -> Vec<Value> {
    #[allow(clippy::disallowed_methods, reason = "cargo knows the manifests best")]
    let output = Command::new(env!("CARGO"))
        .args(["metadata", option, "--format-version", "1", "--manifest-path"])
        .arg(root().join("Cargo.toml"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// The file that each library of the workspace begins with.
pub(crate) fn crate_roots() -> Vec<PathBuf> {
    let packages = packages("--no-deps");
    let targets = packages
        .iter()
        .flat_map(|package| package["targets"].as_array().unwrap());
    let libraries = targets.filter(|target| target["kind"][0] == "lib");
    libraries
        .map(|target| PathBuf::from(target["src_path"].as_str().unwrap()))
        .collect()
}

/// The members of the workspace and all their dependencies, from their manifests.
fn workspace() -> (Vec<String>, Vec<Edge>) {
    let packages = packages("--no-deps");
    let name = |value: &Value| value["name"].as_str().unwrap().to_owned();
    let edges = packages.iter().flat_map(|package| {
        let dependencies = package["dependencies"].as_array().unwrap();
        dependencies.iter().map(move |dependency| Edge {
            from: name(package),
            to: name(dependency),
            dev: dependency["kind"] == "dev",
        })
    });
    (packages.iter().map(name).collect(), edges.collect())
}

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file below `folder`, but for build folders and what is hidden.
pub(crate) fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let hidden = path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !hidden && !path.join("CACHEDIR.TAG").exists() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

fn lines(path: &Path) -> usize {
    fs::read_to_string(path).unwrap().lines().count()
}

#[test]
fn dependencies_go_down() {
    let (members, edges) = workspace();
    let wrong = violations(&members, &edges);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let gone: Vec<_> = FLOORS
        .iter()
        .filter(|(name, _)| !members.iter().any(|m| m == name))
        .collect();
    assert!(gone.is_empty(), "no longer members of the workspace: {gone:?}");
}

#[test]
fn files_are_short() {
    let mut files = Vec::new();
    rust_files(root(), &mut files);
    assert!(files.len() > 100, "found only {}", files.len());
    let long: Vec<_> = files
        .iter()
        .filter(|path| lines(path) > MAX_LINES)
        .map(|path| format!("{}: {} lines; at most {MAX_LINES}", path.display(), lines(path)))
        .collect();
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn folders_hold_few_files() {
    let mut files = Vec::new();
    rust_files(root(), &mut files);
    let mut count: BTreeMap<&Path, usize> = BTreeMap::new();
    for file in &files {
        *count.entry(file.parent().unwrap()).or_default() += 1;
    }
    let full: Vec<_> = count.iter().filter(|(_, files)| **files > MAX_FILES).collect();
    assert!(full.is_empty(), "at most {MAX_FILES} Rust files a folder: {full:?}");
}

/// `part.rs` beside the folder `part`, everywhere: the name of a module is that of its file.
#[test]
fn modules_have_files_of_their_name() {
    let mut files = Vec::new();
    rust_files(root(), &mut files);
    let is_in_src = |path: &PathBuf| path.components().any(|part| part.as_os_str() == "src");
    let wrong: Vec<_> = files
        .iter()
        .filter(|path| is_in_src(path) && path.ends_with("mod.rs"))
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn edge(from: &str, to: &str) -> Edge {
    Edge {
        from: from.to_owned(),
        to: to.to_owned(),
        dev: false,
    }
}

fn complaints(edge: Edge) -> String {
    violations(&[], &[edge]).join("\n")
}

#[test]
fn an_upward_edge_is_reported_by_name() {
    assert_eq!(
        complaints(edge("bus", "pilot")),
        "bus (floor 2) depends on pilot (floor 3): not down"
    );
    assert_eq!(complaints(edge("pilot", "bus")), "");
}

#[test]
fn neighbours_do_not_depend_on_each_other_but_their_tests_may() {
    let edge = edge("recorder", "tracker-proc");
    assert!(complaints(edge.clone()).contains("recorder (floor 3) depends on tracker-proc (floor 3)"));
    assert_eq!(complaints(Edge { dev: true, ..edge }), "");
    let up = Edge {
        dev: true,
        ..self::edge("geometry", "phantom")
    };
    assert!(complaints(up).contains("geometry (floor 0) depends on phantom (floor 1)"));
}

#[test]
fn walls_hold() {
    assert_eq!(
        complaints(edge("pilot", "iceoryx2-bb-posix")),
        "pilot depends on iceoryx2-bb-posix: only bus may"
    );
    assert_eq!(complaints(edge("bus", "iceoryx2")), "");
    assert_eq!(
        complaints(edge("exchange", "flate2")).lines().next(),
        Some("exchange depends on flate2: only calib-cli and volume-loader may")
    );
    for owner in ["calib-cli", "volume-loader"] {
        assert_eq!(complaints(edge(owner, "flate2")), "");
    }
    assert!(complaints(edge("geometry", "rand")).contains("nalgebra, serde only"));
    assert!(violations(&["newcomer".to_owned()], &[])[0].contains("newcomer has no floor"));
}
