//! Random bytes for every parser of what comes from outside: files that a person chooses, messages of the bus, and streams
//! of localizers.
//!
//! A target takes any bytes and may refuse them, but neither panics nor takes more memory or time than what is good for a
//! file of that length. `cargo test -p trocar-fuzz` gives each its seeds and some thousands of mutations; `cargo xtask fuzz`
//! looks further, guided by what the code covers.

mod calibrations;
mod drivers;
mod enhanced;
mod exchange;
mod folder;
mod links;
mod localizer;
mod messages;
mod mutate;
mod receiving;
mod recordings;
mod seeds;
mod volumes;

pub use folder::Folder;
pub use mutate::Mutator;

use std::path::Path;

/// A parser, or several that read the same kind of bytes.
pub struct Target {
    /// Its name, and that of the folder of its seeds.
    pub name: &'static str,
    /// Takes any bytes.
    pub take: fn(&[u8]),
    /// Good bytes to begin with.
    pub seeds: fn() -> Result<Vec<Vec<u8>>, Failure>,
}

/// Why there are no seeds.
pub type Failure = Box<dyn std::error::Error>;

/// All of them.
pub const TARGETS: [Target; 23] = [
    target("nifti", |b| volumes::read_as("nii", b), seeds::nifti),
    target("nrrd", |b| volumes::read_as("nrrd", b), seeds::nrrd),
    target("metaimage", |b| volumes::read_as("mha", b), seeds::metaimage),
    target("dicom", volumes::read_as_dicom, seeds::dicom),
    target("receive", receiving::association, receiving::seeds),
    target("scene", scene, seeds::scene),
    target("solids", solids, seeds::solids),
    target("mcap", recordings::mcap, recordings::seeds),
    target("sequence", recordings::sequence, recordings::sequences),
    target("table", calibrations::table, calibrations::tables),
    target("result", calibrations::result, calibrations::results),
    target("rom", calibrations::rom, calibrations::roms),
    target("image", calibrations::image, calibrations::images),
    target("run", messages::run, messages::runs),
    target("message", messages::message, messages::seeds),
    target("igtl", links::igtl, links::igtl_seeds),
    target("ndi", localizer::ndi, localizer::ndi_seeds),
    target("igtl-driver", drivers::igtl, drivers::igtl_seeds),
    target("ndi-driver", drivers::ndi, drivers::ndi_seeds),
    target("points", exchange::points, exchange::points_seeds),
    target("transform", exchange::transform, exchange::transform_seeds),
    target("deviceset", exchange::device_set, exchange::device_set_seeds),
    target("surface", exchange::surface, exchange::surface_seeds),
];

const fn target(name: &'static str, take: fn(&[u8]), seeds: fn() -> Result<Vec<Vec<u8>>, Failure>) -> Target {
    Target { name, take, seeds }
}

/// A scene file.
fn scene(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Err(error) = scene::Scene::parse(text, Path::new("fuzz.toml"))
    {
        drop(error.to_string());
    }
}

/// A scene of solids, as `simulate check` reads it.
fn solids(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = simulation_cli::check(text.to_owned(), Path::new("fuzz.toml"));
    }
}
