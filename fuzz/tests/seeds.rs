//! Every target with its seeds and some mutations of each: none panics. `cargo xtask fuzz` looks further.

use trocar_fuzz::{Mutator, TARGETS};

/// Mutations of a target's seeds, all together.
const MUTATIONS: usize = 1500;

fn swept(names: &[&str]) {
    for target in TARGETS.iter().filter(|t| names.contains(&t.name)) {
        let seeds = (target.seeds)().unwrap_or_else(|error| panic!("{}: {error}", target.name));
        assert!(!seeds.is_empty(), "{}", target.name);
        for (number, seed) in seeds.iter().enumerate() {
            (target.take)(seed);
            let mut mutator = Mutator::new(number as u64 + 1);
            for _ in 0..MUTATIONS / seeds.len() {
                (target.take)(&mutator.damaged(seed));
            }
        }
    }
}

#[test]
fn volumes_survive_damage() {
    swept(&["nifti", "nrrd", "metaimage", "dicom"]);
}

#[test]
fn scenes_survive_damage() {
    swept(&["scene", "solids"]);
}

#[test]
fn recordings_survive_damage() {
    swept(&["mcap", "sequence"]);
}

#[test]
fn calibrations_survive_damage() {
    swept(&["table", "result", "rom", "image"]);
}

#[test]
fn messages_and_runs_survive_damage() {
    swept(&["run", "message"]);
}

#[test]
fn links_survive_damage() {
    swept(&["igtl", "ndi", "igtl-driver", "ndi-driver", "receive"]);
}

#[test]
fn files_of_other_programs_survive_damage() {
    swept(&["points", "transform", "deviceset", "surface"]);
}

#[test]
fn each_target_is_swept() {
    assert_eq!(TARGETS.len(), 23);
}
