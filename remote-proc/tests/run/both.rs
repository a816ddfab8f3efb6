//! Two whole runs, as two people would start them: a navigation, and a second screen.

use std::path::{Path, PathBuf};
use std::process::Command;

use bus::Bus;
use bus::message::{Ages, Command as Request, TissueShown, ToolPose, Tracked};
use bus::port::{CommandClient, FrameSubscriber, Subscriber};
use bus::run::{RUNTIME_DIR_VARIABLE, RunContext};
use bus::topic::{HELD_FRAME, TOOL_POSE};
use scene::Scene;

use crate::rig::{PATIENCE, Program, free_endpoint, remote_proc, until};
use crate::wire::Wire;

/// The folder of the other programs; `None`, with a printed reason, where the chore did not say.
pub(crate) fn programs() -> Option<PathBuf> {
    let folder = std::env::var_os("TROCAR_PROGRAMS").map(PathBuf::from);
    if folder.is_none() {
        println!(
            "skipped: TROCAR_PROGRAMS does not name the folder of the other programs (`cargo xtask test-remote` does)"
        );
    }
    folder
}

/// A scene that a busy machine keeps up with: small images of few voxels, which are of the present for a second, and long patience.
const SMALL: &str = r#"
seed = 1
[volume]
source = "phantom"
spacing_mm = 6.0
[tracker]
rate_hz = 60.0
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
[[views]]
name = "axial-global"
plane = "axial"
extent = "global"
size = [128, 128]
[[views]]
name = "frontal-local"
plane = "frontal"
extent = "local"
size = [128, 128]
"#;

/// The path of [`SMALL`].
pub(crate) fn small(world: &Path) -> String {
    let path = world.join("small.toml");
    std::fs::write(&path, SMALL).unwrap();
    path.to_str().unwrap().to_owned()
}

/// One of the two runs, as a program beside it sees it.
pub(crate) struct Looking {
    pub(crate) run: RunContext,
    pub(crate) scene: Scene,
    pub(crate) bus: Bus,
    pub(crate) poses: Subscriber<ToolPose>,
}

impl Looking {
    pub(crate) fn at(world: &Path, name: &str) -> Self {
        let dir = world.join(name);
        let (run, text) = until("the run", || RunContext::load_with_scene(&dir, None).ok());
        let bus = Bus::join(&run).unwrap();
        Self {
            scene: Scene::parse(&text, Path::new("s.toml")).unwrap(),
            poses: Subscriber::open(&bus, &TOOL_POSE, "", TOOL_POSE.buffer).unwrap(),
            bus,
            run,
        }
    }

    /// The next `count` valid poses: each one, or some 0.3 s apart, so that they differ.
    pub(crate) fn valid_poses(&self, count: usize, each: bool) -> Vec<ToolPose> {
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
    pub(crate) fn images(&self, poses: &[ToolPose]) -> Vec<(blake3::Hash, Option<TissueShown>)> {
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
pub(crate) struct Both {
    pub(crate) near: Looking,
    pub(crate) far: Looking,
    /// Where the second one dials.
    pub(crate) endpoint: String,
    pub(crate) wire: Wire,
    pub(crate) first: Program,
    pub(crate) sender: Program,
    pub(crate) second: Program,
}

/// A verb of the pilot, in the folder of the test.
pub(crate) fn pilot(world: &Path, programs: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(programs.join("pilot"));
    command
        .args(arguments)
        .current_dir(world)
        .env(RUNTIME_DIR_VARIABLE, world)
        .env_remove("DISPLAY");
    command
}

impl Both {
    pub(crate) fn start(world: &Path, programs: &Path, scene: &[&str]) -> Self {
        Self::start_with(world, programs, scene, &["--headless"], |_| {})
    }

    /// The same, with these words for `pilot remote`, whose command `change` may change.
    pub(crate) fn start_with(
        world: &Path,
        programs: &Path,
        scene: &[&str],
        more: &[&str],
        change: impl FnOnce(&mut Command),
    ) -> Self {
        let listens = free_endpoint();
        let wire = Wire::before(&listens, 0);
        let endpoint = wire.endpoint();
        let run = [&["run"], scene, &["--run", "or", "--headless", "--out", "o1"]].concat();
        let first = Program::start(world, "first", pilot(world, programs, &run));
        let near = Looking::at(world, "or");
        let mut send = remote_proc();
        send.args(["send", "--run", "or", "--listen", &listens]);
        let sender = Program::start(world, "send", send);
        until("the sender", || {
            let mut facts = remote_proc();
            facts.args(["facts", &listens]).stderr(std::process::Stdio::null());
            facts.output().unwrap().status.success().then_some(())
        });
        let show = ["remote", &endpoint, "--out", "o2", "--run", "second"];
        let mut show = pilot(world, programs, &[&show, more].concat());
        change(&mut show);
        let second = Program::start(world, "second", show);
        Self {
            near,
            far: Looking::at(world, "second"),
            endpoint,
            wire,
            first,
            sender,
            second,
        }
    }

    pub(crate) fn said(&self) -> String {
        [&self.first, &self.sender, &self.second].map(Program::said).join("\n")
    }

    /// Ends a run as somebody would who asks for it, and waits for its end.
    pub(crate) fn stop(&mut self, world: &Path, programs: &Path, name: &str) {
        let stopped = pilot(world, programs, &["stop", "--run", name]).output().unwrap();
        assert!(stopped.status.success(), "{}", String::from_utf8_lossy(&stopped.stderr));
        match name {
            "or" => self.first.ended(),
            _ => self.second.ended(),
        };
    }
}
