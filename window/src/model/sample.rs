//! Runs as they might be, for tests: seven images of one live pose, a target, and whatever is changed of them.

use std::path::Path;
use std::rc::Rc;

use bus::gather::{PoseId, Set};
use bus::message::{
    Chosen, ClockLaw, FrameHeader, FrameStamp, FrameState, Guide, Heartbeat, Identity, IdentitySource, ImagePlane,
    ProcessState, Steps, Timeline, ToolPose, Tracked, VolumeHash, Workflow,
};
use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool, Vector};
use guidance::workflow::Stage;
use scene::{Plane, Scene};

use super::{Known, Model, Recorded};

/// A run at one moment. Every message may be changed before it is looked at.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    /// The scene of seven views.
    pub(crate) scene: Scene,
    /// Now, ns.
    pub(crate) now_ns: i64,
    /// Of each view.
    pub(crate) headers: Vec<Option<FrameHeader>>,
    /// How they belong together.
    pub(crate) set: Option<Set>,
    /// Poses.
    pub(crate) poses: Vec<ToolPose>,
    /// What is aimed at.
    pub(crate) guide: Option<Guide>,
    /// How far the run has come.
    pub(crate) workflow: Option<Workflow>,
    /// The steps.
    pub(crate) steps: Option<Steps>,
    /// Whose it is.
    pub(crate) identity: Option<Identity>,
    /// The examination.
    pub(crate) volume: Option<VolumeHash>,
    /// The recorder.
    pub(crate) recorder: Option<(Option<Heartbeat>, i64)>,
    /// How long ago this screen was read back, ns.
    pub(crate) watched_ns: Option<i64>,
    /// The localizer says what a new start of it gets over.
    pub(crate) may_restart_localizer: bool,
    /// A recording is shown.
    pub(crate) is_replay: bool,
    /// The clock of it.
    pub(crate) law: Option<ClockLaw>,
    /// What the recording holds.
    pub(crate) timeline: Option<Rc<Timeline>>,
    /// Where it was made: `Some(None)` does not say.
    pub(crate) recorded_in: Option<Option<String>>,
    /// Time is simulated.
    pub(crate) is_simulated: bool,
}

/// The examination of the sample.
pub(crate) const VOLUME: VolumeHash = VolumeHash([0x36; 32]);
/// When the sample's pose was captured, ns.
pub(crate) const CAPTURED_NS: i64 = 5_000_000_000;

impl Sample {
    /// A tool at `ct_from_tool`, seen 20 ms ago, a target of 5 mm at `target`.
    pub(crate) fn new(ct_from_tool: Rigid<Ct, Tool>, target: Point<Ct>) -> Self {
        Self::of("", ct_from_tool, target)
    }

    /// The same with the views of this scene.
    pub(crate) fn of(scene: &str, ct_from_tool: Rigid<Ct, Tool>, target: Point<Ct>) -> Self {
        let scene = Scene::parse(scene, Path::new("")).unwrap();
        let mut pose = ToolPose {
            seq: 300,
            t_capture_ns: CAPTURED_NS,
            t_publish_ns: CAPTURED_NS,
            registration_id: 0xb709_89f4 << 32,
            tip_mm: 0.6,
            flags: ToolPose::TIP_KNOWN,
            ..ToolPose::EMPTY
        };
        pose.set(Tracked::Valid(ct_from_tool));
        for place in [15, 18, 20] {
            pose.covariance[place] = 0.04;
        }
        let headers = scene
            .views
            .iter()
            .map(|view| Some(header(&pose, plane(view.plane, ct_from_tool))))
            .collect();
        let chosen = Chosen {
            name: "para-aortic-left".to_owned(),
            centre: target,
            radius_mm: 2.5,
            entry: None,
            stop_mm: 0.0,
        };
        Self {
            headers,
            set: Some(Set::One(id(&pose))),
            poses: vec![pose],
            guide: Some(Guide::default().choosing(Some(&chosen), 7)),
            workflow: Some(workflow(
                Stage::Navigating,
                Workflow::RESEARCH | Workflow::SIGHT | Workflow::NOT_CHECKED | Workflow::IMAGES,
            )),
            steps: None,
            identity: Some(Identity::new(
                VOLUME,
                IdentitySource::Phantom,
                ["PHANTOM", "", "", "", ""],
            )),
            volume: Some(VOLUME),
            recorder: Some((Some(beat()), 50_000_000)),
            watched_ns: Some(50_000_000),
            may_restart_localizer: false,
            is_replay: false,
            law: None,
            timeline: None,
            recorded_in: None,
            is_simulated: false,
            now_ns: CAPTURED_NS + 20_000_000,
            scene,
        }
    }

    /// What a screen would show.
    pub(crate) fn model(&self) -> Model {
        Model::of(&self.known())
    }

    /// As it came over the bus.
    pub(crate) fn known(&self) -> Known<'_> {
        Known {
            scene: &self.scene,
            now_ns: self.now_ns,
            headers: &self.headers,
            set: self.set,
            poses: &self.poses,
            guide: self.guide,
            workflow: self.workflow,
            steps: self.steps,
            identity: self.identity,
            volume: self.volume,
            recorder: self.recorder,
            watched_ns: self.watched_ns,
            may_restart_localizer: self.may_restart_localizer,
            is_replay: self.is_replay,
            law: self.law,
            timeline: self.timeline.as_ref(),
            recorded_in: self
                .recorded_in
                .as_ref()
                .map(|hash| hash.as_deref().map_or(Recorded::Unknown, Recorded::In)),
            is_simulated: self.is_simulated,
            began_ns: Some(0),
        }
    }

    /// The same with every image in this state.
    pub(crate) fn in_state(mut self, state: FrameState) -> Self {
        self.headers
            .iter_mut()
            .flatten()
            .for_each(|header| header.stamp.state = state.code());
        self
    }
}

/// A pose of the sample: the tip at a place, the tube along +z of the tool turned by a rotation vector.
pub(crate) fn pose(turn: [f64; 3], tip: [f64; 3]) -> Rigid<Ct, Tool> {
    let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
    Rigid::from_rotation_vector(vector(turn), vector(tip)).unwrap()
}

/// Which pose a message is.
pub(crate) fn id(pose: &ToolPose) -> PoseId {
    PoseId {
        seq: pose.seq,
        t_capture_ns: pose.t_capture_ns,
    }
}

/// A workflow at a stage.
pub(crate) fn workflow(stage: Stage, flags: u32) -> Workflow {
    Workflow {
        t_ns: 0,
        stage: Stage::ALL.iter().position(|known| *known == stage).unwrap() as u32,
        flags,
        ..Workflow::default()
    }
}

fn beat() -> Heartbeat {
    Heartbeat::new(ProcessState::Ready, CAPTURED_NS, Default::default(), "")
}

fn header(pose: &ToolPose, plane: SlicePlane) -> FrameHeader {
    FrameHeader {
        stamp: FrameStamp {
            seq: pose.seq,
            t_capture_ns: pose.t_capture_ns,
            registration_id: pose.registration_id,
            volume_hash: VOLUME.0,
            ..FrameStamp::default()
        },
        plane: ImagePlane::of(
            Some(&plane),
            scene::WindowLevel {
                centre_hu: 40.0,
                width_hu: 400.0,
            },
        ),
        width: 512,
        height: 512,
    }
}

/// As the renderers place them, written anew: axial from the feet, frontal from the front, sagittal from the left, across along the
/// tube.
fn plane(of: Plane, ct_from_tool: Rigid<Ct, Tool>) -> SlicePlane {
    let tip = ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    let axes = match of {
        Plane::Axial => [Direction::X, Direction::Y],
        Plane::Frontal => [Direction::X, -Direction::Z],
        Plane::Sagittal => [Direction::Y, -Direction::Z],
        Plane::Perpendicular => [
            ct_from_tool * -Direction::<Tool>::X,
            ct_from_tool * -Direction::<Tool>::Y,
        ],
        Plane::Surface => unreachable!("the seven images have none"),
    };
    SlicePlane::centred(tip, axes, 0.2, [512, 512]).unwrap()
}
