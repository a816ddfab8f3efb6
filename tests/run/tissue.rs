//! Organs that move with the tube: in images with the state of their very pose, and with a word where there is none.

mod killed;
mod lost;
mod slow;
mod watch;

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::support::{World, kill_9, pid_in, wait_for};
use bus::Bus;
use bus::message::{
    Ages, FrameStamp, TargetShown, TissueHeader, TissueMesh, TissueMeshHeader, TissueShown, TissueState,
};
use bus::port::{Frame, FrameSubscriber, HeadedSubscriber};
use bus::run::RunContext;
use bus::topic::{TISSUE, TISSUE_MESH, VIEW_FRAME};
use geometry::{Ct, Model, Point, VolumeGrid};
use phantom::Phantom;

/// Of the scene here.
const VOXEL_MM: f64 = 3.0;
/// So far from its place at rest a pixel may have its value: half a pixel of 120 mm / 512 (0.12 mm) and what a place may lie beside the
/// plane (0.1 mm), three times as far at rest where tissue is pressed to a third, and the raster's 0.35 mm.
const MOST_OFF_MM: f64 = 1.1;
/// Pixels that the dark rim of a line or a word reaches beyond it; 2 were found enough in images looked at.
const RIM: usize = 3;
/// Of words; the kidney is 212.
const WHITE: u8 = 250;

fn root() -> &'static std::path::Path {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// One model at a time: two on two processors, beside all other tests, are each left behind by the tube.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    // A test that failed has left nothing behind that another one would see.
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The shipped scene on coarser voxels, in which a node is none, with the kidney alone, held where the tube has pushed it.
fn scene(world: &World) -> std::path::PathBuf {
    let text = std::fs::read_to_string(root().join("config/tissue.toml")).unwrap();
    let organs = root().join("config/solids/demo-kidney.toml");
    // Its own target in the kidney goes: what is written about it would lie over the places that are looked at.
    let (before, rest) = text
        .split_once("[[targets]]                   # goes with the kidney")
        .unwrap();
    let (_, after) = rest.split_once("[recording]").unwrap();
    let text = format!("{before}[recording]{after}")
        .replace("spacing_mm = 1.5", "spacing_mm = 3.0")
        .replace("solids/demo-organs.toml", organs.to_str().unwrap())
        .replace("\"para-aortic node\"", "\"under the kidney\"")
        .replace("\"beside the aorta\"", "\"under the kidney\"")
        .replace(
            "name = \"under the kidney\"\nct_mm = [18.8, -6.9, 35.6]",
            "name = \"under the kidney\"\nct_mm = [65.2, 38.0, 77.7]",
        )
        .replace(
            "name = \"under the kidney\"\nct_mm = [28.5",
            "name = \"elsewhere\"\nct_mm = [28.5",
        )
        .replace("pause_s = 3.0", "pause_s = 600.0")
        // A busy machine makes some states a second: a model that is left behind by 30 mm would rightly refuse the tube.
        .replace("insert_s = 8.0", "insert_s = 40.0")
        .replace("noise_mm = 0.05", "noise_mm = 0.0")
        .replace("noise_deg = 0.01", "noise_deg = 0.0")
        // What stands still for a second is not to be killed for it on a busy machine.
        .replace("stale_ms = 300.0", "stale_ms = 300.0\nsilent_s = 10.0")
        .replace(
            "[recording]",
            &format!(
                "[[targets]]\nname = \"in the kidney\"\nct_mm = {:?}\n\n[recording]",
                in_the_kidney().mm()
            ),
        );
    world.file("tissue.toml", &text)
}

/// A place of the kidney above the target that the tube goes to, a few millimetres within its lower pole.
fn in_the_kidney() -> Point<Ct> {
    let patient = Phantom::new(1);
    let mut above = (0..200).map(|k| Point::new(65.2, 38.0, 77.7 + 0.25 * f64::from(k)));
    let surface = above.find(|at| patient.structure(*at) == phantom::structure::KIDNEY_LEFT);
    let place = surface.unwrap() + geometry::Vector::new(0.0, 0.0, 5.0);
    assert_eq!(patient.structure(place), phantom::structure::KIDNEY_LEFT);
    place
}

struct Rig {
    frames: FrameSubscriber,
    states: HeadedSubscriber<TissueHeader, f32>,
    mesh: (TissueMeshHeader, TissueMesh),
    /// States that came, by their number.
    came: BTreeMap<u64, (TissueHeader, Vec<f32>)>,
}

impl Rig {
    fn open(world: &World) -> Self {
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        let bus = Bus::join(&context).unwrap();
        let meshes = HeadedSubscriber::<TissueMeshHeader, u8>::open(&bus, &TISSUE_MESH, 1).unwrap();
        let states = HeadedSubscriber::open(&bus, &TISSUE, TISSUE.buffer).unwrap();
        let frames = FrameSubscriber::open(&bus, &VIEW_FRAME, "frontal").unwrap();
        let mesh = wait_for("the mesh", || meshes.next().unwrap());
        let read = TissueMesh::read(mesh.header(), mesh.values()).unwrap();
        Self {
            frames,
            states,
            mesh: (*mesh.header(), read),
            came: BTreeMap::new(),
        }
    }

    /// The next image for which `wanted` holds, with what came of the tissue meanwhile.
    fn image(&mut self, what: &str, wanted: impl Fn(&FrameStamp, Option<&TissueHeader>) -> bool) -> Frame {
        let (frames, states, came) = (&self.frames, &self.states, &mut self.came);
        wait_for(what, || {
            // The image first: its state was there before it.
            let frame = frames.newest().unwrap();
            while let Some(state) = states.next().unwrap() {
                came.insert(state.header().seq, (*state.header(), state.values().to_vec()));
            }
            let frame = frame?;
            let stamp = frame.header().stamp;
            wanted(&stamp, came.get(&stamp.tissue_seq).map(|state| &state.0)).then_some(frame)
        })
    }
}

/// Of a settled state in which the organ presses on the tube.
fn pushed(stamp: &FrameStamp, state: Option<&TissueHeader>) -> bool {
    let force = |state: &TissueHeader| state.force.iter().map(|f| f * f).sum::<f64>().sqrt();
    stamp.tissue == TissueShown::Settled.code() && state.is_some_and(|state| force(state) > 0.5)
}

/// Values of the 27 functions of a cube at a place from -1 to 1.
fn functions(at: [f64; 3]) -> [f64; 27] {
    let along = at.map(|x| [x * (x - 1.0) / 2.0, 1.0 - x * x, x * (x + 1.0) / 2.0]);
    std::array::from_fn(|k| along[0][k % 3] * along[1][k / 3 % 3] * along[2][k / 9])
}

/// Where places of the patient at rest are now, by the messages alone.
fn moved(mesh: &TissueMesh, places: &[f32], rest: Point<Ct>) -> Option<Point<Ct>> {
    let own = (mesh.ct_from_model.inverse() * rest).mm();
    let organ = &mesh.organs[0];
    let inside = |low: [f64; 3], side: f64| (0..3).all(|a| own[a] >= low[a] && own[a] < low[a] + side);
    let cube = organ.cubes.iter().find(|cube| inside(cube.low, cube.side))?;
    let values = functions(std::array::from_fn(|a| 2.0 * (own[a] - cube.low[a]) / cube.side - 1.0));
    let now: [f64; 3] = std::array::from_fn(|a| {
        let each = (0..27).map(|k| values[k] * f64::from(places[3 * cube.nodes[k] as usize + a]));
        each.sum()
    });
    Some(mesh.ct_from_model * Point::<Model>::new(now[0], now[1], now[2]))
}

/// The grey of HU in the scene's window, from 0 to 255.
fn grey(hu: f64) -> f64 {
    ((hu - 40.0) / 400.0 + 0.5).clamp(0.0, 1.0) * 255.0
}

#[test]
fn an_image_has_the_organ_where_the_state_of_its_pose_has_it_and_a_killed_model_leaves_marked_images() {
    let _alone = alone();
    let world = World::new();
    let pilot = world.start(&scene(&world), &world.path("out"), "default");
    let status = pilot.wait_live();
    let mut rig = Rig::open(&world);
    let frame = rig.image("an image of a pushed organ", pushed);
    let stamp = frame.header().stamp;
    let (state, places) = &rig.came[&stamp.tissue_seq];
    assert_eq!(state.state_of(), Ok(TissueState::Settled));
    // Tube and tissue are of one pose, and the mesh is the one that came.
    assert_eq!((state.pose_seq, state.t_capture_ns), (stamp.seq, stamp.t_capture_ns));
    assert_eq!(stamp.tissue_mesh.to_be_bytes()[..], rig.mesh.0.mesh_id[..8]);
    check_pixels(&frame, &rig.mesh.1, places);

    // A target in the organ goes with it; one beside it stays.
    let beside = stamp.target_mm;
    assert!(beside != [0.0; 3] && stamp.target_shown_mm == beside);
    assert_eq!(stamp.target, TargetShown::Beside.code());
    let said = world.output("pilot", &["choose", "in the kidney"]);
    assert!(said.status.success(), "{}", crate::support::stderr(&said));
    let frame = rig.image("an image of the target in the kidney", |stamp, state| {
        stamp.target_mm == in_the_kidney().mm() && pushed(stamp, state)
    });
    let stamp = frame.header().stamp;
    let wanted = moved(&rig.mesh.1, &rig.came[&stamp.tissue_seq].1, in_the_kidney())
        .unwrap()
        .mm();
    let off = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    // The same sums in another order.
    assert!(off(stamp.target_shown_mm, wanted) < 1e-6, "{stamp:?}: {wanted:?}");
    assert!(off(stamp.target_shown_mm, stamp.target_mm) > 1.0, "{stamp:?}");
    assert_eq!(stamp.target, TargetShown::Model.code());

    // A person may want the examination as it was taken, and back.
    for (wish, shown) in [("rest", TissueShown::Rigid), ("moved", TissueShown::Settled)] {
        let said = world.output("pilot", &["images", "--organs", wish]);
        assert!(said.status.success(), "{}", crate::support::stderr(&said));
        rig.image("an image as it was asked for", |stamp, _| stamp.tissue == shown.code());
    }

    kill_9(pid_in(&status, "tissue").unwrap());
    let late = rig.image("an image that says that the tissue is late", |stamp, _| {
        stamp.tissue == TissueShown::Late.code()
    });
    assert_eq!(late.header().stamp.tissue_seq, 0);
    // Whoever comes back finds the tube in tissue, and nobody knows how it came there.
    rig.came.clear();
    let refused = rig.image("an image that says that the tissue is refused", |stamp, _| {
        assert!(stamp.tissue != TissueShown::Settled.code());
        stamp.tissue == TissueShown::Refused.code()
    });
    assert!(refused.header().stamp.t_capture_ns > late.header().stamp.t_capture_ns);
    let status = pilot.wait_for("the reason", |status| {
        status.to_string().contains("from where it was last, draw it back")
    });
    assert!(pid_in(&status, "tissue").is_some());
    // It was killed: the run says so, and the last pictures what they show.
    assert!(!pilot.stop().success());
    let texts = crate::support::png_texts(&world.path("out/frontal.png"));
    assert!(texts["tissue"] == "refused" || texts["tissue"] == "late", "{texts:?}");
}

/// The examination as the run has it.
struct Voxels {
    grid: VolumeGrid,
    hu: Vec<i16>,
}

impl Voxels {
    fn of(patient: &Phantom) -> Self {
        let grid = patient.grid([VOXEL_MM; 3]).unwrap();
        let [nx, ny, nz] = grid.dims().map(|count| count as usize);
        let mut hu = vec![0; nx * ny * nz];
        for (k, slice) in (0..).zip(hu.chunks_mut(nx * ny)) {
            patient.fill_slice(&grid, k, slice);
        }
        Self { grid, hu }
    }

    fn voxel(&self, at: [usize; 3]) -> f64 {
        let [nx, ny, _] = self.grid.dims().map(|count| count as usize);
        f64::from(self.hu[(at[2] * ny + at[1]) * nx + at[0]])
    }

    /// Between the eight voxels around it, along each axis evenly; `at` counts voxels.
    fn between(&self, at: [f64; 3]) -> f64 {
        let low = at.map(|x| x.floor());
        let corner = |k: usize| {
            let up = [0, 1, 2].map(|axis| k >> axis & 1);
            let share: f64 = (0..3)
                .map(|axis| {
                    let part = at[axis] - low[axis];
                    if up[axis] == 1 { part } else { 1.0 - part }
                })
                .product();
            match share > 0.0 {
                true => share * self.voxel(std::array::from_fn(|axis| low[axis] as usize + up[axis])),
                false => 0.0,
            }
        };
        (0..8).map(corner).sum()
    }

    /// The least and the greatest value within `MOST_OFF_MM` along each axis. Between two layers of voxels it is linear along an axis, so that
    /// both lie at the ends of what is looked at or on a layer.
    fn around(&self, place: Point<Ct>) -> [f64; 2] {
        let middle = (self.grid.voxel_from_ct() * place).mm();
        let along = middle.map(|x| {
            let [low, high] = [-1.0, 1.0].map(|side| x + side * MOST_OFF_MM / VOXEL_MM);
            let layers = (low.ceil() as usize..=high.floor() as usize).map(|layer| layer as f64);
            [low, high].into_iter().chain(layers).collect::<Vec<_>>()
        });
        let mut found = [f64::INFINITY, f64::NEG_INFINITY];
        for x in &along[0] {
            for y in &along[1] {
                for z in &along[2] {
                    let hu = self.between([*x, *y, *z]);
                    found = [found[0].min(hu), found[1].max(hu)];
                }
            }
        }
        found
    }
}

/// True where a line or a word is so near that its dark rim may lie on this pixel: they are coloured or white, and bone, which is white too, is
/// nothing that is looked at.
fn drawn_near(rgba: &[u8], width: usize, [x, y]: [usize; 2]) -> bool {
    let drawn = |pixel: &[u8]| pixel[0] != pixel[1] || pixel[1] != pixel[2] || pixel[0] >= WHITE;
    (y - RIM..=y + RIM).any(|row| {
        let left = (row * width + x - RIM) * 4;
        rgba[left..left + (2 * RIM + 1) * 4].chunks_exact(4).any(drawn)
    })
}

/// Places of the kidney, where the messages have moved them into the image's plane: the image has there what the examination has at rest
/// around them.
fn check_pixels(frame: &Frame, mesh: &TissueMesh, places: &[f32]) {
    let patient = Phantom::new(1);
    let voxels = Voxels::of(&patient);
    let plane = frame.header().slice_plane().unwrap().unwrap();
    let ages = Ages {
        stale_ns: i64::MAX,
        lost_ns: i64::MAX,
    };
    let pixels = frame.shown(0, ages);
    let (mut seen, mut far) = (0, 0.0_f64);
    for k in 0..600_000_u32 {
        let part = |m: u32, span: f64| f64::from(k.wrapping_mul(m) >> 8) / f64::from(1 << 24) * span;
        let rest = Point::<Ct>::new(
            35.0 + part(2_654_435_761, 57.0),
            20.0 + part(40_503_001, 48.0),
            81.0 + part(3_266_489_917, 100.0),
        );
        if patient.structure(rest) != phantom::structure::KIDNEY_LEFT {
            continue;
        }
        let Some(now) = moved(mesh, places, rest) else { continue };
        let projected = plane.project(now);
        let [x, y] = [projected.x.round(), projected.y.round()];
        // Above it the words of the image stand, an alarm's on a dark band.
        let inside = (30.0..480.0).contains(&x) && (100.0..440.0).contains(&y);
        if !inside || projected.depth_mm.abs() > 0.1 {
            continue;
        }
        // A border within reach would let anything pass.
        let [low, high] = voxels.around(rest).map(grey);
        if high - low > 10.0 {
            continue;
        }
        let at = (y as usize * frame.header().width as usize + x as usize) * 4;
        let found = &pixels.rgba[at..at + 3];
        if found[0] < 20 || drawn_near(pixels.rgba, frame.header().width as usize, [x as usize, y as usize]) {
            continue;
        }
        // Voxels are whole HU, greys whole numbers.
        assert!(
            (low - 2.0..=high + 2.0).contains(&f64::from(found[0])),
            "{found:?} {low} to {high} at {now:?}"
        );
        seen += 1;
        far = far.max((now - rest).mm().iter().map(|x| x * x).sum::<f64>().sqrt());
    }
    assert!(seen > 100 && far > 1.0, "{seen} places seen, moved by {far} mm");
}
