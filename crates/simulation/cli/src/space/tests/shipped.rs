//! The scene of the kidney: its label map is not part of Trocar.

use std::path::{Path, PathBuf};

use super::super::Space;
use super::READ;

/// The shipped scene where its label map is there; else says why not.
fn kidney() -> Option<Space> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../config/solids/kidney.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let shared = std::env::var_os("TROCAR_SHARED").map(PathBuf::from);
    let map = "data/ct-abdopelvis-nifti/example_seg_fast_force_split.nii.gz";
    let folder = path.parent().unwrap().join("../../../shared");
    let map = shared.unwrap_or(folder).join(map);
    if !map.is_file() {
        println!(
            "skipped: config/solids/kidney.toml needs {}, which is not there",
            map.display()
        );
        return None;
    }
    Some(Space::new(text, &path, Some(&map), READ).unwrap())
}

#[test]
fn the_kidney_is_read_meshed_and_held() {
    let Some(space) = kidney() else { return };
    let words = space.described();
    println!("{words}");
    for part in ["right kidney: label 2, 7134 voxels", "first touches", "is no obstacle"] {
        assert!(words.contains(part), "{part:?} is not in:\n{words}");
    }
}

/// By hand, as it takes minutes: TROCAR_OUT=dir cargo test -p simulation-cli whole_kidney -- --ignored --nocapture
#[test]
#[ignore = "takes minutes"]
fn whole_kidney() {
    let Some(mut space) = kidney() else { return };
    space.ask_for_errors();
    let folder = tempfile::tempdir().unwrap();
    let out = std::env::var_os("TROCAR_OUT").map_or_else(|| folder.path().to_owned(), PathBuf::from);
    std::fs::create_dir_all(&out).unwrap();
    println!("{}", space.run(&out, &mut |line| println!("{line}")).unwrap());
}
