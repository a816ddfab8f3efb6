//! H3: a depth gauge on a navigator's screen was not in step with its other views. Every frame that says so shows one pose, in all
//! images, in the sight's numbers and in the coded cell, and every other says by how many poses its images differ; judged by the pixels.
//!
//! Four renderers on a real bus draw what they get round to. Each image has one colour, by the number of its pose.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::path::Path;

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::{
    Chosen, FrameHeader, FrameStamp, Guide, ImagePlane, ToolPose, Tracked, VolumeHash, VolumeHeader, Workflow,
};
use bus::port::{FramePublisher, Publisher, VolumePublisher, VolumeSubscriber};
use bus::run::RunContext;
use bus::session::Session;
use bus::topic::{GUIDE, TOOL_POSE, VIEW_FRAME, WORKFLOW};
use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool, Vector};
use guidance::workflow::Stage;
use scene::{Plane, Scene};
use window::code::Shown;
use window::feed::{Feed, Now};
use window::frame::{Coded, Frames, Painted};
use window::model::Model;
use window::ports::{Has, Ports};
use window::screen::{Look, Outcome};
use window::sizes::{Screen, Sizes};

/// Columns and rows of an image.
const SIDE: u32 = 16;
const SCREEN: Screen = Screen {
    pixels: [1024, 640],
    pixel_mm: 0.25,
};
/// Where all poses aim at, mm along the tube.
const TARGET_MM: f64 = 700.0;
const VOLUME: VolumeHash = VolumeHash([7; 32]);

/// Numbers that look like chance, the same each time (Marsaglia's xorshift).
struct Chance(u64);

impl Chance {
    fn below(&mut self, count: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % count
    }
}

/// How far the tip of this pose is from the target, mm: another tenth for each of 9000 poses.
fn to_go_mm(seq: u64) -> f64 {
    (seq % 9000) as f64 / 10.0
}

fn placed(seq: u64) -> Rigid<Ct, Tool> {
    let tip = Vector::new(0.0, 0.0, TARGET_MM - to_go_mm(seq));
    Rigid::from_rotation_vector(Vector::new(0.0, 0.0, 0.0), tip).unwrap()
}

fn pose(seq: u64, now_ns: i64) -> ToolPose {
    let mut pose = ToolPose {
        seq,
        t_capture_ns: now_ns,
        t_publish_ns: now_ns,
        tip_mm: 0.1,
        flags: ToolPose::TIP_KNOWN,
        ..ToolPose::EMPTY
    };
    pose.set(Tracked::Valid(placed(seq)));
    for place in [15, 18, 20] {
        pose.covariance[place] = 0.001;
    }
    pose
}

fn header(pose: &ToolPose) -> FrameHeader {
    let axes = [Direction::X, Direction::Y];
    let tip = placed(pose.seq) * Point::<Tool>::new(0.0, 0.0, 0.0);
    let plane = SlicePlane::centred(tip, axes, 1.0, [SIDE; 2]).unwrap();
    let window = scene::WindowLevel {
        centre_hu: 40.0,
        width_hu: 400.0,
    };
    FrameHeader {
        stamp: FrameStamp {
            seq: pose.seq,
            t_capture_ns: pose.t_capture_ns,
            volume_hash: VOLUME.0,
            ..FrameStamp::default()
        },
        plane: ImagePlane::of(Some(&plane), window),
        width: SIDE,
        height: SIDE,
    }
}

/// The colour of a pose's images, 0 to 255: its number's low 16 bits, and their sum for a check.
fn colour(seq: u64) -> [u8; 3] {
    let [low, high, ..] = seq.to_le_bytes();
    [low, high, low.wrapping_add(high) ^ 0x5a]
}

/// The number of the pose whose colour a pixel has.
fn number(pixel: u32) -> Option<u64> {
    let [blue, green, red, _] = pixel.to_le_bytes();
    let seq = u64::from(red) + 256 * u64::from(green);
    (colour(seq) == [red, green, blue]).then_some(seq)
}

/// A renderer: its views, the newest pose that it began, and which views of that are still to be drawn.
struct Renderer {
    views: Vec<usize>,
    pose: ToolPose,
    left: Vec<usize>,
}

struct Rig {
    scene: Scene,
    run: RunContext,
    views: Vec<FramePublisher>,
    poses: Publisher<ToolPose>,
    /// Whoever comes late hears what was said as long as these live.
    _said: (VolumePublisher, Publisher<Guide>, Publisher<Workflow>),
    ports: Ports,
    feed: Feed,
    session: Session,
    bus: Bus,
    _folder: tempfile::TempDir,
}

impl Rig {
    fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("tw").tempdir_in("/tmp").unwrap();
        let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
        run.store().unwrap();
        let bus = Bus::join(&run).unwrap();
        let scene = Scene::parse("", Path::new("")).unwrap();
        let bytes = (4 * SIDE * SIDE) as usize;
        let views = scene.views.iter();
        let views = views.map(|view| FramePublisher::open(&bus, &VIEW_FRAME, &view.name, bytes).unwrap());
        let views = views.collect();
        let feed = Feed::new(scene.views.len(), VolumeSubscriber::open(&bus).unwrap());
        let ports = Ports::open(&bus, &scene, Has::default()).unwrap();
        let volume = volume(&bus);
        let (guides, workflows) = tell(&bus);
        Self {
            views,
            poses: Publisher::open(&bus, &TOOL_POSE, "").unwrap(),
            _said: (volume, guides, workflows),
            session: Session::live(bus.clock().clone()),
            scene,
            run,
            ports,
            feed,
            bus,
            _folder: folder,
        }
    }

    fn renderers(&self) -> Vec<Renderer> {
        let of = |plane: Plane| {
            let views = self.scene.views.iter().enumerate();
            views
                .filter(|(_, view)| view.plane == plane)
                .map(|(index, _)| index)
                .collect()
        };
        let planes = [Plane::Axial, Plane::Frontal, Plane::Sagittal, Plane::Perpendicular];
        planes
            .map(|plane| Renderer {
                views: of(plane),
                pose: ToolPose::EMPTY,
                left: Vec::new(),
            })
            .into()
    }

    fn send(&self, view: usize, pose: &ToolPose) {
        let [red, green, blue] = colour(pose.seq);
        let rgba = [red, green, blue, 255].repeat((SIDE * SIDE) as usize);
        self.views[view]
            .send(header(pose), &rgba, self.bus.clock(), i64::MAX)
            .unwrap();
    }
}

fn volume(bus: &Bus) -> VolumePublisher {
    let layout = bus::volume::Layout::new([4, 4, 4], [4, 4, 4]).unwrap();
    let publisher = VolumePublisher::open(bus, &layout).unwrap();
    let header = VolumeHeader {
        ct_from_voxel: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        hash: VOLUME.0,
        dims: [4; 3],
        brick: [4; 3],
        ..VolumeHeader::default()
    };
    publisher.loan().unwrap().publish(header).unwrap();
    publisher
}

/// A target, and a run that navigates.
fn tell(bus: &Bus) -> (Publisher<Guide>, Publisher<Workflow>) {
    let chosen = Chosen {
        name: "node".to_owned(),
        centre: Point::new(0.0, 0.0, TARGET_MM),
        radius_mm: 2.5,
        entry: None,
        stop_mm: 0.0,
    };
    let workflow = Workflow {
        t_ns: 0,
        stage: Stage::ALL.iter().position(|stage| *stage == Stage::Navigating).unwrap() as u32,
        flags: Workflow::SIGHT | Workflow::IMAGES,
        ..Workflow::default()
    };
    let guides = Publisher::<Guide>::open(bus, &GUIDE, "").unwrap();
    guides.send(Guide::default().choosing(Some(&chosen), 1)).unwrap();
    let workflows = Publisher::open(bus, &WORKFLOW, "").unwrap();
    workflows.send(workflow).unwrap();
    (guides, workflows)
}

/// The pose of each image by its pixels, in the order of the screen, the one across the tube last; `None` where they do not agree.
fn on_glass(pixels: &[u32], sizes: &Sizes) -> Vec<Option<u64>> {
    let cells = sizes.cells.iter().enumerate().filter(|(k, _)| *k != sizes.sight);
    cells
        .map(|(_, cell)| {
            // Beside the letters, which stand at the middle of the sides.
            let places = [[0.4, 0.45], [0.6, 0.45], [0.4, 0.6], [0.6, 0.6]];
            let at = places.map(|[x, y]| {
                let (x, y) = (cell.left() + x * cell.width(), cell.top() + y * cell.height());
                number(pixels[y as usize * SCREEN.pixels[0] as usize + x as usize])
            });
            at[0].filter(|_| at.iter().all(|number| *number == at[0]))
        })
        .collect()
}

/// The distance to go as it stands on the screen.
fn says_to_go(outcome: &Outcome, mm: f64) -> bool {
    outcome.words.0.iter().any(|placed| {
        let said = placed.painted.parse::<f64>();
        // To a tenth below ten millimetres, else to whole ones.
        said.is_ok_and(|said| (said - mm).abs() <= 0.5001)
    })
}

/// A pose comes now and then, and one of the renderers goes on with what it draws. `apart`: each draws poses that no other draws.
fn go_on(rig: &Rig, renderers: &mut [Renderer], newest: &mut ToolPose, chance: &mut Chance, apart: bool) {
    if chance.below(8) == 0 {
        *newest = pose(newest.seq + 1, rig.bus.clock().now_ns());
        rig.poses.send(*newest).unwrap();
    }
    let which = chance.below(4);
    let renderer = &mut renderers[which as usize];
    let draws = !apart || newest.seq % 4 == which;
    match renderer.left.pop() {
        Some(view) => rig.send(view, &renderer.pose),
        // Now and then it sleeps.
        None if draws && newest.seq > renderer.pose.seq && chance.below(3) > 0 => {
            (renderer.pose, renderer.left) = (*newest, renderer.views.clone());
        }
        None => {}
    }
}

/// Takes what has come and paints a frame of it.
fn frame(rig: &mut Rig, painter: &mut Frames, pixels: &mut [u32]) -> Painted {
    rig.feed.take(&rig.ports).unwrap();
    let now_ns = rig.session.clock().now_ns();
    let now = Now {
        session_ns: now_ns,
        run_ns: now_ns,
        began_ns: None,
    };
    rig.feed.choose(now_ns, window::feed::stale_ns(&rig.scene));
    let model = Model::of(&rig.feed.known(&rig.scene, &rig.session, now, None));
    let (look, coded) = (Look::default(), Coded { key: 1, pid: 1 });
    let what = (&model, &rig.feed);
    painter
        .paint(what, (SCREEN, &look), (Vec::new(), 0.0), coded, pixels)
        .unwrap()
}

/// Holds what a frame says against its pixels, `found`; returns whether it showed several poses.
fn is_mixed(found: &[Option<u64>], painted: &Painted, feed: &Feed) -> bool {
    let numbers: Option<Vec<u64>> = found.iter().copied().collect();
    let numbers = numbers.unwrap_or_else(|| panic!("{found:?}"));
    let (least, most) = (numbers.iter().min().unwrap(), numbers.iter().max().unwrap());
    let words = &painted.outcome.words;
    let says = |text: &str| words.0.iter().any(|placed| placed.painted.contains(text));
    let differ = most - least;
    assert_eq!(says("one pose"), differ == 0, "{numbers:?}");
    let plural = if differ == 1 { "" } else { "S" };
    let mark = format!("VIEWS DIFFER {differ} POSE{plural}");
    assert_eq!(says(&mark), differ > 0, "{numbers:?}");
    let to_go_mm = to_go_mm(*numbers.last().unwrap());
    assert!(says_to_go(&painted.outcome, to_go_mm), "{numbers:?}");
    let captured = feed.frames().iter().flatten().map(|frame| frame.header().stamp);
    let oldest = captured.min_by_key(|stamp| stamp.seq).unwrap();
    assert_eq!(oldest.seq, *least);
    // The cell holds whole milliseconds.
    let (code, _) = painted.code.unwrap();
    assert!((0..=1).contains(&code.age_ms(oldest.t_capture_ns)), "{numbers:?}");
    differ > 0
}

/// Paints `frames` frames between drawings; the numbers of frames that showed one pose, and several.
fn watch(frames: usize, seed: u64) -> [usize; 2] {
    let mut rig = Rig::new();
    let (mut chance, mut renderers) = (Chance(seed), rig.renderers());
    let (mut painter, mut newest, mut counts) = (Frames::default(), ToolPose::EMPTY, [0, 0]);
    let sizes = Sizes::of(SCREEN, rig.views.len()).unwrap();
    let mut pixels = vec![0; (SCREEN.pixels[0] * SCREEN.pixels[1]) as usize];
    while counts[0] + counts[1] < frames {
        let apart = (counts[0] + counts[1]) / 300 % 2 == 1;
        go_on(&rig, &mut renderers, &mut newest, &mut chance, apart);
        if chance.below(6) > 0 {
            continue;
        }
        let painted = frame(&mut rig, &mut painter, &mut pixels);
        // Images that are dimmed say why and are not to be followed.
        if painted.code.unwrap().0.shown() == Shown::Live {
            let found = on_glass(&pixels, &sizes);
            counts[usize::from(is_mixed(&found, &painted, &rig.feed))] += 1;
        }
    }
    rig.run.sweep();
    counts
}

#[test]
fn h3_every_frame_shows_one_pose_or_says_by_how_many_its_images_differ() {
    let counts = watch(2000, 1);
    assert!(counts.iter().all(|count| *count > 200), "{counts:?}");
}

#[test]
#[ignore = "100 000 frames take minutes: cargo test --release -p window --test one_pose -- --ignored --nocapture"]
#[allow(clippy::print_stdout, reason = "the figure is what it is for")]
fn a_hundred_thousand_frames() {
    for seed in 1..=10 {
        println!("one pose, several: {:?}", watch(10_000, seed));
    }
}
