//! Organs that move with the tube, in simulated time, in replays and in snapshots of recordings: each image shows the state of its very pose, and
//! what is made again is the same to the bit.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::support::{World, pictures, png_texts, report, stderr, stdout};
use bus::message::TissueMesh;
use recorder::read::reader;
use recorder::read::scan::Item;
use recorder::read::seek::Session;
use recorder::wire::proto::{MeshFrame, TissueFrame};
use recorder::wire::schema::TISSUE_MESH;

/// Of the shipped scene's way, so many poses a second for so many seconds.
const RATE: usize = 10;
const SECONDS: usize = 11;

/// Where the shipped scene has the node that its tube pushes aside, and the place in the kidney: its targets in an organ, in this order.
const IN_ORGANS: [[f64; 3]; 2] = [[28.5, 2.6, 50.0], [62.0, 40.0, 95.0]];

/// The shipped scene, of a kidney, a node and a vessel, with one small view, aiming at the target that the kidney takes along: its tube stops under the kidney,
/// where the model's error is told of what stands still.
fn scene(world: &World) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("config/tissue.toml")).unwrap();
    let organs = root.join("config/solids/demo-organs.toml");
    let text = text
        .replace("rate_hz = 20.0", &format!("rate_hz = {RATE}.0"))
        .replace("[18.8, -6.9, 35.6]", "[66.3, 39.1, 75.0]")
        .replace("target = \"para-aortic node\"", "target = \"in the lower pole\"")
        // What stands still for a second is not to be killed for it on a busy machine.
        .replace("stale_ms = 300.0", "stale_ms = 300.0\nsilent_s = 10.0")
        .replace("solids/demo-organs.toml", organs.to_str().unwrap());
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

/// The picture of an instant of a recording, without a run: what came of asking for it.
fn snapshot(world: &World, recording: &Path, which: &[&str], out: &Path) -> std::process::Output {
    let (recording, out) = (recording.to_string_lossy(), out.to_string_lossy());
    let all = [
        "snapshot",
        "--recording",
        &*recording,
        "--view",
        "frontal",
        "--out",
        &*out,
    ];
    world.output("slice-view-proc", &[&all[..], which].concat())
}

/// Snapshots of some instants are byte for byte the pictures that a replay took.
fn check_snapshots(world: &World, recording: &Path, replayed: &Path, seqs: &[u64]) {
    let out = world.path("instant.png");
    for seq in seqs {
        let taken = snapshot(world, recording, &["--seq", &seq.to_string()], &out);
        assert!(taken.status.success(), "{}", stderr(&taken));
        let picture = replayed.join(format!("images/frontal-{seq:06}.png"));
        assert_eq!(
            std::fs::read(&out).unwrap(),
            std::fs::read(picture).unwrap(),
            "pose {seq}"
        );
    }
}

/// Files that were cut off, and places that are none, are refused by name and leave no picture.
fn check_refused(world: &World, recording: &Path) {
    let (cut, out) = (world.path("cut.mcap"), world.path("none.png"));
    let bytes = std::fs::read(recording).unwrap();
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    for (recording, which, words) in [
        (cut.as_path(), ["--seq", "60"], ["at byte", "recorder recover"]),
        (
            recording,
            ["--seq", "100000"],
            ["no pose of this number", "its first is"],
        ),
        (recording, ["--at", "1h"], ["--at 3600 s", "goes from 0 s to"]),
    ] {
        let said = snapshot(world, recording, &which, &out);
        let text = stderr(&said);
        assert!(
            !said.status.success() && words.iter().all(|word| text.contains(word)),
            "{text}"
        );
        assert!(!out.exists());
    }
}

/// States that push the kidney tell the model's error at the targets in organs, of a pose that is a little older, and larger the more it is pushed:
/// of each its own.
fn check_errors(states: &BTreeMap<u64, TissueFrame>) {
    let all = |state: &TissueFrame| {
        (state.header.errors_known == 2).then(|| [state.header.errors[0], state.header.errors[1]])
    };
    let of = |state: &TissueFrame| all(state).map(|[_, kidney]| kidney);
    let moved = |state: &TissueFrame| {
        let covariance = of(state)?.covariance;
        Some((covariance[0] + covariance[3] + covariance[5]).sqrt())
    };
    let settled = states
        .values()
        .filter(|state| state.header.state == 0 && force(state) > 0.2);
    let known: Vec<f64> = settled.clone().filter_map(moved).collect();
    assert!(known.len() > 10 && known.len() * 2 > settled.count(), "{known:?}");
    // Tenths of a millimetre at least, by stiffnesses that are off by tenths; and no metre.
    let most = known.iter().copied().fold(0.0, f64::max);
    assert!((0.1..30.0).contains(&most), "{most} mm");
    for state in states.values().filter(|state| state.header.state != 0) {
        assert_eq!(of(state), None, "{:?}", state.header.pose_seq);
    }
    // The node's is nothing: no tube is at it.
    for [node, _] in states.values().filter_map(all) {
        assert!(node.covariance.iter().all(|c| c.abs() < 1e-12), "{node:?}");
    }
    for state in states.values().filter(|state| of(state).is_some()) {
        let header = &state.header;
        assert_eq!(all(state).unwrap().map(|place| place.at_rest_mm), IN_ORGANS);
        let place = header.errors[0].at_rest_mm;
        let (_, age_ns) = header.error_of(place).unwrap();
        assert!(
            age_ns > 0 && header.errors_pose_seq < header.pose_seq,
            "{}",
            header.pose_seq
        );
    }
}

/// Organ by organ in the order of the mesh: while the kidney is pushed, node and vessel lie at rest to the bit.
fn check_moved(recording: &Path, states: &BTreeMap<u64, TissueFrame>) {
    let mut items = Session::open(recording).unwrap().items_from(0).unwrap();
    let mesh = items.find_map(|item| match item.unwrap() {
        Item::Message(message) if message.channel.topic == TISSUE_MESH => reader::decode::<MeshFrame>(&message).ok(),
        _ => None,
    });
    let mesh = mesh.unwrap();
    let mesh = TissueMesh::read(&mesh.header, &mesh.bytes).unwrap();
    let counts: Vec<usize> = mesh.organs.iter().map(|organ| organ.nodes as usize).collect();
    let names: Vec<&str> = mesh.organs.iter().map(|organ| organ.name.as_str()).collect();
    assert_eq!(names, ["left kidney", "aorta", "para-aortic node"]);
    let places = |state: &TissueFrame| -> Vec<Vec<f32>> {
        let ends = counts.iter().scan(0, |first, count| {
            *first += 3 * count;
            Some((*first - 3 * count, *first))
        });
        ends.map(|(first, end)| state.nodes[first..end].to_vec()).collect()
    };
    let first = places(&states[&1]);
    let farthest = |state: &TissueFrame| -> Vec<f32> {
        let now = places(state);
        let each = now
            .iter()
            .zip(&first)
            .map(|(now, rest)| now.iter().zip(rest).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max));
        each.collect()
    };
    for state in states
        .values()
        .filter(|state| state.header.state == 0 && force(state) > 0.2)
    {
        let far = farthest(state);
        assert!(matches!(far[..], [kidney, 0.0, 0.0] if kidney > 1.0), "{far:?}");
    }
}

fn force(state: &TissueFrame) -> f64 {
    state.header.force.iter().map(|f| f * f).sum::<f64>().sqrt()
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
    assert!(states.values().filter(|state| force(state) > 0.2).count() > 20);
    check_errors(&states);
    check_moved(&recording, &states);

    let again = replay(&world, &recording, "again", &["--speed", "max", "--images", "every"]);
    assert_eq!(check_pictures(&again, &states), poses);
    assert_eq!(pictures(&live), pictures(&again));
    // The first, one without a touch, some that are pushed, and the last, which the run itself has pictured.
    let last = *states.keys().next_back().unwrap();
    check_snapshots(&world, &recording, &again, &[1, 30, 70, 80, last]);
    let held = std::fs::read(live.join("frontal.png")).unwrap();
    assert_eq!(std::fs::read(world.path("instant.png")).unwrap(), held);
    check_refused(&world, &recording);

    // A stretch has the mesh that came before it.
    let part = world.path("part.mcap");
    let [from, to] = [&recording, &part].map(|path| path.to_str().unwrap());
    let cut = world.output("recorder", &["cut", from, "--from", "6s", "--to", "7s", "--out", to]);
    assert!(cut.status.success(), "{}", stderr(&cut));
    let stretch = replay(&world, &part, "stretch", &["--speed", "max", "--images", "every"]);
    let count = check_pictures(&stretch, &states);
    assert!((9..=11).contains(&count), "{count}");
    let mut shown = states
        .keys()
        .copied()
        .filter(|seq| stretch.join(format!("images/frontal-{seq:06}.png")).exists());
    // Of its first pose a stretch does not say for how long the measurement had stood still: replay and snapshot tell that alike.
    let first = shown.next().unwrap();
    check_snapshots(&world, &part, &stretch, &[first, shown.next_back().unwrap()]);
    let of = |folder: &Path| std::fs::read(folder.join(format!("images/frontal-{first:06}.png"))).unwrap();
    assert!(of(&stretch) != of(&again));

    let made = replay(&world, &recording, "made", &["--recompute-tissue"]);
    let found = &report(&made)["replay"]["recomputed"]["difference"]["tissue"];
    assert_eq!(
        (&found["common"], &found["identical"]),
        (&poses.into(), &poses.into()),
        "{found}"
    );
    assert_eq!(pictures(&live).get("frontal.png"), pictures(&made).get("frontal.png"));
}
