//! What is held is what a person saw, whoever said that it is held; asked for on a real bus, where renderers and the pilot answer when
//! they get round to it.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::path::{Path, PathBuf};

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::gather::{PoseId, Set};
use bus::message::{Command, CommandKind, FrameHeader, FrameStamp, Guide, ToolPose};
use bus::port::{CommandServer, FramePublisher, Publisher, VolumeSubscriber};
use bus::run::RunContext;
use bus::topic::{GUIDE, HELD_FRAME, TOOL_POSE, VIEW_FRAME};
use scene::{Plane, Scene};
use window::feed::{Feed, stale_ns};
use window::ports::{Has, Ports};
use window::screen::Wish;
use window::wishes::Asked;

/// A run with its renderers and its pilot, which answer when they are told to, and what a window has of it.
struct Rig {
    scene: Scene,
    live: Vec<FramePublisher>,
    held: Vec<FramePublisher>,
    poses: Publisher<ToolPose>,
    guides: Publisher<Guide>,
    renderers: Vec<CommandServer>,
    pilot: CommandServer,
    asked: Asked,
    feed: Feed,
    ports: Ports,
    bus: Bus,
    run: RunContext,
    _folder: tempfile::TempDir,
}

impl Rig {
    fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("tw").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        let bus = Bus::join(&run).unwrap();
        let scene = Scene::parse("", Path::new("")).unwrap();
        let views = |topic| {
            let views = scene.views.iter();
            let open = |view: &scene::View| FramePublisher::open(&bus, topic, &view.name, 4).unwrap();
            views.map(open).collect()
        };
        let renderers = scene.renderers().into_iter();
        let serve = |(plane, _): (Plane, _)| CommandServer::open(&bus, &plane.process()).unwrap();
        Self {
            live: views(&VIEW_FRAME),
            held: views(&HELD_FRAME),
            poses: Publisher::open(&bus, &TOOL_POSE, "").unwrap(),
            guides: Publisher::open(&bus, &GUIDE, "").unwrap(),
            renderers: renderers.map(serve).collect(),
            pilot: CommandServer::open(&bus, "pilot").unwrap(),
            asked: Asked::open(&bus, &scene, Has::default(), PathBuf::new()).unwrap(),
            feed: Feed::new(scene.views.len(), VolumeSubscriber::open(&bus).unwrap()),
            ports: Ports::open(&bus, &scene, Has::default()).unwrap(),
            scene,
            bus,
            run,
            _folder: folder,
        }
    }

    /// A pose, with its images in the views that show it.
    fn pose(&self, seq: u64, shows: impl Fn(Plane) -> bool) -> ToolPose {
        let now_ns = self.bus.clock().now_ns();
        let pose = ToolPose {
            seq,
            t_capture_ns: now_ns,
            ..ToolPose::EMPTY
        };
        self.poses.send(pose).unwrap();
        for (view, publisher) in self.scene.views.iter().zip(&self.live) {
            if shows(view.plane) {
                send(publisher, &self.bus, &pose);
            }
        }
        pose
    }

    /// One turn of the window.
    fn turn(&mut self) -> Option<Set> {
        self.feed.take(&self.ports).unwrap();
        self.asked.hear().unwrap();
        let now_ns = self.bus.clock().now_ns();
        let set = self.feed.choose(now_ns, stale_ns(&self.scene));
        self.asked.draw_held(&self.feed, now_ns).unwrap();
        set
    }

    fn hold_or_follow(&mut self) {
        self.asked
            .carry_out(&Wish::Hold, &self.feed, &self.scene, (None, None))
            .unwrap();
    }

    /// The renderers draw what was asked for first; returns of which pose.
    fn draw(&self) -> Option<u64> {
        let mut drawn = None;
        for renderer in &self.renderers {
            let request = renderer.next().unwrap()?;
            let pose = request.command().pose;
            drawn = Some(pose.seq);
            for publisher in &self.held {
                send(publisher, &self.bus, &pose);
            }
            request.reply(Ok("drawn")).unwrap();
        }
        drawn
    }

    /// The pilot does what was asked for first; returns what that was.
    fn obey(&self) -> Option<Command> {
        let request = self.pilot.next().unwrap()?;
        let command = *request.command();
        let held = (command.command_kind() == Some(CommandKind::Hold)).then(|| id(&command.pose));
        self.guides.send(Guide::default().holding(held)).unwrap();
        request.reply(Ok("")).unwrap();
        Some(command)
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.run.sweep();
    }
}

fn id(pose: &ToolPose) -> PoseId {
    PoseId {
        seq: pose.seq,
        t_capture_ns: pose.t_capture_ns,
    }
}

fn send(publisher: &FramePublisher, bus: &Bus, pose: &ToolPose) {
    let header = FrameHeader {
        stamp: FrameStamp {
            seq: pose.seq,
            t_capture_ns: pose.t_capture_ns,
            ..FrameStamp::default()
        },
        width: 1,
        height: 1,
        ..FrameHeader::default()
    };
    publisher.send(header, &[0; 4], bus.clock(), i64::MAX).unwrap();
}

/// `pilot hold` says which pose is held and has it drawn by nobody, nor has a recording: the screen was red, without any image.
#[test]
fn a_pose_that_is_held_without_this_window_is_drawn() {
    let mut rig = Rig::new();
    let pose = rig.pose(7, |_| true);
    assert_eq!(rig.turn(), Some(Set::One(id(&pose))));
    rig.guides.send(Guide::default().holding(Some(id(&pose)))).unwrap();
    let missing = rig.scene.views.len();
    assert_eq!(rig.turn(), Some(Set::Mixed { poses: 0, missing }));
    // Asked for once, however often the window comes round.
    rig.turn();
    assert_eq!((rig.draw(), rig.draw()), (Some(7), None));
    assert_eq!(rig.turn(), Some(Set::One(id(&pose))));
    assert!(rig.feed.frames().iter().all(Option::is_some));
}

/// Where views differ it was the newest pose, of an image that the sight with its numbers is not of.
#[test]
fn where_views_differ_the_pose_of_the_sight_is_held() {
    let mut rig = Rig::new();
    let pose = rig.pose(7, |_| true);
    rig.turn();
    // Of the next pose all have come but that across the tube; of the first the others have been passed over.
    for seq in [8, 9, 10] {
        rig.pose(seq, |plane| plane != Plane::Perpendicular);
        rig.turn();
    }
    std::thread::sleep(rig.scene.limits.stale);
    assert!(matches!(rig.turn(), Some(Set::Mixed { missing: 0, .. })));
    rig.hold_or_follow();
    assert_eq!(rig.draw(), Some(7));
    rig.turn();
    let asked = rig.obey().unwrap();
    assert_eq!(
        (asked.command_kind(), id(&asked.pose)),
        (Some(CommandKind::Hold), id(&pose))
    );
}

/// Renderers took their time, and meanwhile another window held: the screen stood still again after somebody had followed.
#[test]
fn who_follows_again_is_not_held_by_an_earlier_wish() {
    let mut rig = Rig::new();
    let pose = rig.pose(7, |_| true);
    rig.turn();
    rig.hold_or_follow();
    // A person who presses the key again meanwhile is told why nothing more happens.
    let again = rig.asked.carry_out(&Wish::Hold, &rig.feed, &rig.scene, (None, None));
    assert_eq!(again.unwrap_err(), "what is to be held is being drawn");
    rig.guides.send(Guide::default().holding(Some(id(&pose)))).unwrap();
    rig.turn();
    rig.hold_or_follow();
    assert_eq!(rig.draw(), Some(7));
    rig.turn();
    assert_eq!(rig.obey().unwrap().command_kind(), Some(CommandKind::Follow));
    rig.turn();
    assert!(rig.obey().is_none());
}
