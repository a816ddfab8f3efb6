//! The pixels of a second screen are those of the first.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::message::{TissueHeader, TissueShown, TissueState};
use bus::port::HeadedSubscriber;
use bus::topic::TISSUE;

use crate::both::{Both, pilot, programs};
use crate::rig::{alone, until, world};

/// Images compared of each view; `TROCAR_POSES` asks for more.
const POSES: usize = 8;
/// So many poses are taken at once: what comes meanwhile of longer runs is passed over.
const BATCH: usize = 100;

/// The shipped scene, whose renderers may say nothing for as long as a busy machine holds them up over hundreds of images in a row.
fn patient(world: &Path) -> PathBuf {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/demo.toml");
    let text = std::fs::read_to_string(config).unwrap();
    let path = world.join("patient.toml");
    std::fs::write(&path, text.replace("[limits]\n", "[limits]\nsilent_s = 30.0\n")).unwrap();
    path
}

#[test]
fn a_second_screen_shows_the_same_pixels() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let asked = std::env::var("TROCAR_POSES").ok().and_then(|count| count.parse().ok());
    let count: usize = asked.unwrap_or(POSES);
    let scene = patient(world.path());
    let both = Both::start(world.path(), &programs, &[scene.to_str().unwrap()]);
    let (mut images, mut differing) = (0, 0);
    for first in (0..count).step_by(BATCH) {
        let chosen = both.far.valid_poses(BATCH.min(count - first), count > POSES);
        let (here, there) = (both.near.images(&chosen), both.far.images(&chosen));
        assert_eq!(here.len(), there.len());
        images += here.len();
        differing += here.iter().zip(&there).filter(|(a, b)| a != b).count();
    }
    println!("{differing} of {images} images of {count} poses differ");
    assert!(images >= count);
    assert_eq!(differing, 0, "of {images} images\n{}", both.said());
    // Whatever is chosen is chosen on the machine that navigates.
    let asked = |arguments: &[&str]| pilot(world.path(), &programs, arguments);
    let refused = asked(&["choose", "x", "--run", "second"]).output().unwrap();
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(words.contains("the run of another machine is shown here"), "{words}");
    let stopped = asked(&["stop", "--run", "second"]).output().unwrap();
    assert!(stopped.status.success(), "{}", String::from_utf8_lossy(&stopped.stderr));
    until("the report", || {
        world.path().join("o2/report.json").exists().then_some(())
    });
    std::thread::sleep(Duration::from_millis(200));
    let report = std::fs::read_to_string(world.path().join("o2/report.json")).unwrap();
    assert!(
        report.contains("\"same_volume\": true") && report.contains(&both.endpoint),
        "{report}\n{}",
        both.said()
    );
}

/// The shipped scene with the kidney alone on coarser voxels, whose tube goes in so slowly that a busy machine's model keeps up.
fn moving(world: &Path) -> PathBuf {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
    let organs = config.join("solids/demo-kidney.toml").canonicalize().unwrap();
    let text = std::fs::read_to_string(config.join("tissue.toml")).unwrap();
    let text = text
        .replace("solids/demo-organs.toml", organs.to_str().unwrap())
        .replace("[18.8, -6.9, 35.6]", "[65.2, 38.0, 77.7]")
        .replace("spacing_mm = 1.5", "spacing_mm = 3.0")
        .replace("insert_s = 8.0", "insert_s = 40.0")
        .replace("pause_s = 3.0", "pause_s = 600.0")
        .replace("noise_mm = 0.05", "noise_mm = 0.0")
        .replace("noise_deg = 0.01", "noise_deg = 0.0");
    let path = world.join("moving.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn a_second_screen_shows_organs_where_the_first_has_them() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let scene = moving(world.path());
    let both = Both::start(world.path(), &programs, &[scene.to_str().unwrap()]);
    let states = HeadedSubscriber::<TissueHeader, f32>::open(&both.far.bus, &TISSUE, TISSUE.buffer).unwrap();
    let mut poses = std::collections::VecDeque::new();
    let force = |state: &TissueHeader| state.force.iter().map(|f| f * f).sum::<f64>().sqrt();
    let (mut seen, mut asked, mut pushed) = (0, 0, 0.0_f64);
    while seen < 4 {
        assert!(asked < 100, "no two images of a state\n{}", both.said());
        // The newest state there, and its pose: soon asked for, as renderers keep few states.
        let state = until("a settled state on the second machine", || {
            while let Some(pose) = both.far.poses.next().unwrap() {
                poses.push_back(pose);
            }
            let mut newest = None;
            while let Some(state) = states.next().unwrap() {
                newest = Some(*state.header());
            }
            newest.filter(|state| state.state_of() == Ok(TissueState::Settled) && force(state) > 0.1)
        });
        pushed = pushed.max(force(&state));
        let Some(pose) = poses.iter().find(|pose| pose.seq == state.pose_seq).copied() else {
            continue;
        };
        asked += 1;
        let (here, there) = (both.near.images(&[pose]), both.far.images(&[pose]));
        for (here, there) in here.iter().zip(&there) {
            // A renderer that is asked too late has the state no longer, and says so.
            if [here.1, there.1] == [Some(TissueShown::Settled); 2] {
                assert_eq!(here.0, there.0, "pose {}\n{}", pose.seq, both.said());
                seen += 1;
            }
        }
    }
    println!("{seen} images of moved organs are the same, pushed by up to {pushed} N");
}
