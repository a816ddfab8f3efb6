//! The whole of it, as two people would start it: a navigation, and a second screen.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use bus::Bus;
use bus::message::{Ages, Command as Request, TissueHeader, TissueShown, TissueState, ToolPose, Tracked};
use bus::port::{CommandClient, FrameSubscriber, HeadedSubscriber, Subscriber};
use bus::run::{RUNTIME_DIR_VARIABLE, RunContext};
use bus::topic::{HELD_FRAME, TISSUE, TOOL_POSE};
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

    /// The images of `poses`, of every view but the overview, as they are drawn on request: hashes, and what of moved organs they show.
    fn images(&self, poses: &[ToolPose]) -> Vec<(blake3::Hash, Option<TissueShown>)> {
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
                    images.push((blake3::hash(shown.rgba), TissueShown::from_code(header.stamp.tissue)));
                }
            }
        }
        images
    }
}

/// A run, the sender beside it, and the run that shows it.
struct Both {
    near: Looking,
    far: Looking,
    endpoint: String,
    first: Program,
    sender: Program,
    second: Program,
}

fn pilot(world: &Path, programs: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(programs.join("pilot"));
    command
        .args(arguments)
        .current_dir(world)
        .env(RUNTIME_DIR_VARIABLE, world)
        .env_remove("DISPLAY");
    command
}

impl Both {
    fn start(world: &Path, programs: &Path, scene: &[&str]) -> Self {
        let endpoint = free_endpoint();
        let run = [&["run"], scene, &["--run", "or", "--headless", "--out", "o1"]].concat();
        let first = Program::start(world, "first", pilot(world, programs, &run));
        let near = Looking::at(world, "or");
        let mut send = remote_proc();
        send.args(["send", "--run", "or", "--listen", &endpoint]);
        let sender = Program::start(world, "send", send);
        until("the sender", || {
            let mut facts = remote_proc();
            facts.args(["facts", &endpoint]).stderr(std::process::Stdio::null());
            facts.output().unwrap().status.success().then_some(())
        });
        let show = ["remote", &endpoint, "--headless", "--out", "o2", "--run", "second"];
        let second = Program::start(world, "second", pilot(world, programs, &show));
        Self {
            near,
            far: Looking::at(world, "second"),
            endpoint,
            first,
            sender,
            second,
        }
    }

    fn said(&self) -> String {
        [&self.first, &self.sender, &self.second].map(Program::said).join("\n")
    }
}

#[test]
fn a_second_screen_shows_the_same_pixels() {
    let Some(programs) = programs() else { return };
    let _alone = alone();
    let world = world();
    let asked = std::env::var("TROCAR_POSES").ok().and_then(|count| count.parse().ok());
    let count: usize = asked.unwrap_or(POSES);
    let both = Both::start(world.path(), &programs, &[]);
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

/// The shipped scene with organs on coarser voxels, whose tube goes in so slowly that a busy machine's model keeps up.
fn moving(world: &Path) -> PathBuf {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
    let organs = config.join("solids/demo-kidney.toml").canonicalize().unwrap();
    let text = std::fs::read_to_string(config.join("tissue.toml")).unwrap();
    let text = text
        .replace("solids/demo-kidney.toml", organs.to_str().unwrap())
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
