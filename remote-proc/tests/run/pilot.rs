//! The whole of it, as two people would start it: a navigation, and a second screen.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bus::Bus;
use bus::message::{Ages, Command as Request, ToolPose, Tracked};
use bus::port::{CommandClient, FrameSubscriber, Subscriber};
use bus::run::{RUNTIME_DIR_VARIABLE, RunContext};
use bus::topic::{HELD_FRAME, TOOL_POSE};
use scene::Scene;

use crate::rig::{PATIENCE, Program, alone, free_endpoint, remote_proc, until, world};

/// Images compared of each view; `TROCAR_POSES` asks for more.
const POSES: usize = 8;
/// So many poses are taken at once: what comes meanwhile of longer runs is passed over.
const BATCH: usize = 100;

/// The folder of the other programs; `None`, with a printed reason, where the chore did not say.
fn programs() -> Option<PathBuf> {
    let folder = std::env::var_os("TROCAR_PROGRAMS").map(PathBuf::from);
    if folder.is_none() {
        println!(
            "skipped: TROCAR_PROGRAMS does not name the folder of the other programs (`cargo xtask test-remote` does)"
        );
    }
    folder
}

/// One of the two runs, as a program beside it sees it.
struct Looking {
    scene: Scene,
    bus: Bus,
    poses: Subscriber<ToolPose>,
}

impl Looking {
    fn at(world: &Path, name: &str) -> Self {
        let dir = world.join(name);
        let (run, text) = until("the run", || RunContext::load_with_scene(&dir, None).ok());
        let bus = Bus::join(&run).unwrap();
        Self {
            scene: Scene::parse(&text, Path::new("s.toml")).unwrap(),
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap(),
            bus,
        }
    }

    /// The next `count` valid poses: each one, or some 0.3 s apart, so that they differ.
    fn valid_poses(&self, count: usize, each: bool) -> Vec<ToolPose> {
        let (mut chosen, mut last) = (Vec::new(), 0);
        until("valid poses on the second machine", || {
            while let Some(pose) = self.poses.next().unwrap() {
                let time = pose.t_capture_ns / 300_000_000;
                let is_next = chosen.len() < count && (each || time != last);
                if is_next && matches!(pose.tracked_at(i64::MAX), Ok(Tracked::Valid(_))) {
                    last = time;
                    chosen.push(pose);
                }
            }
            (chosen.len() == count).then_some(())
        });
        chosen
    }

    /// The hashes of the images of `poses`, of every view but the overview, as they are drawn on request.
    fn images(&self, poses: &[ToolPose]) -> Vec<blake3::Hash> {
        let mut images = Vec::new();
        for (plane, views) in self.scene.renderers() {
            let client = CommandClient::open(&self.bus, &plane.process()).unwrap();
            let open =
                |view: &usize| FrameSubscriber::open(&self.bus, &HELD_FRAME, &self.scene.views[*view].name).unwrap();
            let held: Vec<FrameSubscriber> = views.iter().map(open).collect();
            for pose in poses {
                let reply = client.ask(Request::render(*pose), PATIENCE).unwrap();
                assert!(!reply.refused, "{}", reply.text);
                for frames in &held {
                    let frame = frames.newest().unwrap().expect("an image that was asked for");
                    let header = frame.header();
                    assert_eq!((header.stamp.seq, header.stamp.on_request), (pose.seq, 1));
                    let shown = frame.shown(header.stamp.t_framed_ns, Ages::of(&self.scene.limits));
                    images.push(blake3::hash(shown.rgba));
                }
            }
        }
        images
    }
}

#[test]
fn a_second_screen_shows_the_same_pixels() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let endpoint = free_endpoint();
    let asked = std::env::var("TROCAR_POSES").ok().and_then(|count| count.parse().ok());
    let count: usize = asked.unwrap_or(POSES);
    let pilot = |arguments: &[&str]| {
        let mut command = Command::new(programs.join("pilot"));
        command
            .args(arguments)
            .current_dir(world.path())
            .env(RUNTIME_DIR_VARIABLE, world.path());
        command
    };
    let first = Program::start(
        world.path(),
        "first",
        pilot(&["run", "--run", "or", "--headless", "--out", "o1"]),
    );
    let near = Looking::at(world.path(), "or");
    let mut send = remote_proc();
    send.args(["send", "--run", "or", "--listen", &endpoint]);
    let sender = Program::start(world.path(), "send", send);
    until("the sender", || {
        let mut facts = remote_proc();
        facts.args(["facts", &endpoint]).stderr(std::process::Stdio::null());
        facts.output().unwrap().status.success().then_some(())
    });
    let mut second = pilot(&["remote", &endpoint, "--headless", "--out", "o2", "--run", "second"]);
    let second = Program::start(world.path(), "second", {
        second.env_remove("DISPLAY");
        second
    });
    let far = Looking::at(world.path(), "second");
    let (mut images, mut differing) = (0, 0);
    for first in (0..count).step_by(BATCH) {
        let chosen = far.valid_poses(BATCH.min(count - first), count > POSES);
        let (here, there) = (near.images(&chosen), far.images(&chosen));
        assert_eq!(here.len(), there.len());
        images += here.len();
        differing += here.iter().zip(&there).filter(|(a, b)| a != b).count();
    }
    println!("{differing} of {images} images of {count} poses differ");
    assert!(images >= count);
    assert_eq!(differing, 0, "of {images} images\n{}\n{}", first.said(), second.said());
    // Whatever is chosen is chosen on the machine that navigates.
    let refused = pilot(&["choose", "x", "--run", "second"]).output().unwrap();
    let words = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(words.contains("the run of another machine is shown here"), "{words}");
    let stopped = pilot(&["stop", "--run", "second"]).output().unwrap();
    assert!(stopped.status.success(), "{}", String::from_utf8_lossy(&stopped.stderr));
    until("the report", || {
        world.path().join("o2/report.json").exists().then_some(())
    });
    std::thread::sleep(Duration::from_millis(200));
    let report = std::fs::read_to_string(world.path().join("o2/report.json")).unwrap();
    assert!(
        report.contains("\"same_volume\": true") && report.contains(&endpoint),
        "{report}\n{}",
        sender.said()
    );
}
