//! The overview in a replay: the same poses give the same bytes, with the structures of the label map.

use std::fs;

use crate::support::nifti::Nifti;
use crate::support::{World, png_texts, report, stderr, stdout};

/// A CT of 20 mm voxels about a ball of bone, and structures on both sides of it; with the overview of it.
const SCENE: &str = r#"
[volume]
source = "ct.nii"
[tracker.approach]
insert_s = 1.0
pause_s = 0.2
sweep_s = 1.0
[recording]
[limits]
stale_ms = 1000.0
silent_s = 30.0
stop_s = 30.0
max_missing_share = 1.0
latency_p99_ms = 0.0
[plan]
labels = "labels.nii"
[[targets]]
name = "node"
ct_mm = [-100, -90, 70]
[[views]]
name = "surface"
plane = "surface"
extent = "global"
size = [256, 256]
[[views]]
name = "axial"
plane = "axial"
extent = "local"
size = [128, 128]
"#;

fn nifti(value: impl Fn(i32, i32, i32) -> i16) -> Vec<u8> {
    let voxels = (0..8).flat_map(|k| (0..10).flat_map(move |j| (0..12).map(move |i| (i, j, k))));
    let bytes = voxels.flat_map(|(i, j, k)| value(i, j, k).to_le_bytes());
    Nifti::header().with(bytes).into()
}

fn write(world: &World) {
    let ball = |i: i32, j: i32, k: i32| ((i - 6).pow(2) + (j - 5).pow(2) + (k - 4).pow(2)) < 7;
    fs::write(
        world.path("ct.nii"),
        nifti(|i, j, k| if ball(i, j, k) { 900 } else { 40 }),
    )
    .unwrap();
    fs::write(
        world.path("labels.nii"),
        nifti(|i, j, k| {
            if ball(i, j, k) {
                0
            } else {
                ((i + j + k) % 9 == 0).into()
            }
        }),
    )
    .unwrap();
}

fn replay(world: &World, out: &str) -> std::process::Output {
    let (recording, out) = (world.path("live/session.mcap"), world.path(out));
    let [recording, out] = [&recording, &out].map(|path| path.to_string_lossy());
    let output = world.output(
        "pilot",
        &[
            "replay",
            &recording,
            "--headless",
            "--speed",
            "max",
            "--images",
            "every",
            "--out",
            &out,
        ],
    );
    assert!(output.status.success(), "{}\n{}", stdout(&output), stderr(&output));
    output
}

#[test]
fn the_overview_of_a_replay_is_that_of_the_run_byte_for_byte() {
    let world = World::new();
    write(&world);
    let scene = world.file("s.toml", SCENE);
    world.navigate(&scene, &world.path("live"), &["--for", "1500ms"]);
    replay(&world, "again");
    let live = world.path("live/surface.png");
    let seq: u64 = png_texts(&live)["pose_seq"].parse().unwrap();
    let of = |out: &str, seq: u64| fs::read(world.path(out).join(format!("images/surface-{seq:06}.png"))).unwrap();
    assert!(fs::read(&live).unwrap() == of("again", seq));
    let views = report(&world.path("again"));
    for view in views["views"].as_array().unwrap() {
        assert_eq!(
            (&view["rendered"], &view["dropped"]),
            (&views["poses"]["published"], &0.into()),
            "{view}"
        );
    }
    // Twice is the same, all of them.
    replay(&world, "twice");
    let names = fs::read_dir(world.path("again/images"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    let mut count = 0;
    for name in names
        .map(|name| name.to_string_lossy().into_owned())
        .filter(|name| name.starts_with("surface-"))
    {
        let [again, twice] =
            ["again", "twice"].map(|out| fs::read(world.path(out).join("images").join(&name)).unwrap());
        assert!(again == twice, "{name}");
        count += 1;
    }
    assert!(count > 20, "{count}");
    // Where the map has gone, the image says so and the replay goes on.
    fs::remove_file(world.path("labels.nii")).unwrap();
    let output = replay(&world, "without");
    assert!(
        stderr(&output).contains("labels.nii") && stderr(&output).contains("It is not shown"),
        "{}",
        stderr(&output)
    );
    assert!(of("without", seq) != of("again", seq));
}
