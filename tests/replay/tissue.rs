//! Organs that move with the tube, in simulated time and in replays: each image shows the state of its very pose, and what is made again
//! is the same to the bit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::support::{World, pictures, png_texts, report, stderr, stdout};
use recorder::read::seek::Session;
use recorder::wire::proto::TissueFrame;

/// Of the shipped scene's way, so many poses a second for so many seconds.
const RATE: usize = 10;
const SECONDS: usize = 11;

/// The shipped scene with one small view.
fn scene(world: &World) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("config/tissue.toml")).unwrap();
    let organs = root.join("config/solids/demo-kidney.toml");
    let text = text
        .replace("rate_hz = 20.0", &format!("rate_hz = {RATE}.0"))
        .replace("solids/demo-kidney.toml", organs.to_str().unwrap());
    let view =
        "[[views]]\nname = \"frontal\"\nplane = \"frontal\"\nextent = \"local\"\nfield_mm = 120.0\nsize = [192, 192]\n";
    world.file(
        "tissue.toml",
        &(text.split("[[views]]").next().unwrap().to_owned() + view),
    )
}

/// The recorded states by the number of their pose.
fn states(recording: &Path) -> BTreeMap<u64, TissueFrame> {
    let states = Session::open(recording).unwrap().tissue_from(i64::MIN).unwrap();
    let of_pose = |state: TissueFrame| (state.header.pose_seq, state);
    states.map(|state| of_pose(state.unwrap())).collect()
}

fn replay(world: &World, recording: &Path, out: &str, more: &[&str]) -> PathBuf {
    let (recording, out) = (recording.to_string_lossy(), world.path(out));
    let all = ["replay", &*recording, "--headless", "--out", &*out.to_string_lossy()];
    let output = world.output("pilot", &[&all[..], more].concat());
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    out
}

/// Every picture of a replay shows the recorded state of its pose; how many there are.
fn check_pictures(out: &Path, states: &BTreeMap<u64, TissueFrame>) -> usize {
    let files = std::fs::read_dir(out.join("images")).unwrap();
    let files: Vec<_> = files.map(|file| file.unwrap().path()).collect();
    for file in &files {
        let texts = png_texts(file);
        let state = &states[&texts["pose_seq"].parse().unwrap()].header;
        assert_eq!(texts.get("tissue_seq"), Some(&state.seq.to_string()), "{texts:?}");
        let words = ["settled", "approximate", "catching up", "refused"];
        assert_eq!(texts["tissue"], words[state.state as usize], "{texts:?}");
    }
    files.len()
}

#[test]
fn each_image_of_a_replay_has_the_state_of_its_pose_and_states_made_again_are_the_same_to_the_bit() {
    let world = World::new();
    let live = world.path("live");
    let seconds = format!("{SECONDS}s");
    world.navigate(&scene(&world), &live, &["--speed", "max", "--for", &seconds]);
    let recording = live.join("session.mcap");

    // Simulated time waits for the state of each pose, so that no image is late, and some show a pushed organ.
    let poses = RATE * SECONDS;
    let shown = &report(&live)["tissue"];
    assert_eq!(
        (&shown["unmarked"], &shown["images"]["late"]),
        (&0.into(), &0.into()),
        "{shown}"
    );
    let states = states(&recording);
    assert_eq!(states.len(), poses);
    let force = |state: &TissueFrame| state.header.force.iter().map(|f| f * f).sum::<f64>().sqrt();
    assert!(states.values().filter(|state| force(state) > 0.2).count() > 20);

    let again = replay(&world, &recording, "again", &["--speed", "max", "--images", "every"]);
    assert_eq!(check_pictures(&again, &states), poses);
    assert_eq!(pictures(&live), pictures(&again));

    // A stretch has the mesh that came before it.
    let part = world.path("part.mcap");
    let [from, to] = [&recording, &part].map(|path| path.to_str().unwrap());
    let cut = world.output("recorder", &["cut", from, "--from", "6s", "--to", "7s", "--out", to]);
    assert!(cut.status.success(), "{}", stderr(&cut));
    let stretch = replay(&world, &part, "stretch", &["--speed", "max", "--images", "every"]);
    let count = check_pictures(&stretch, &states);
    assert!((9..=11).contains(&count), "{count}");

    let made = replay(&world, &recording, "made", &["--recompute-tissue"]);
    let found = &report(&made)["replay"]["recomputed"]["difference"]["tissue"];
    assert_eq!(
        (&found["common"], &found["identical"]),
        (&poses.into(), &poses.into()),
        "{found}"
    );
    assert_eq!(pictures(&live).get("frontal.png"), pictures(&made).get("frontal.png"));
}
