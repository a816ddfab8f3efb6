//! The overview: making the surfaces, an image while the camera stands still, and one while it turns.
//!
//! `cargo bench --workspace --bench surface [-- CT ...]`: the generated patient with voxels of 1.5 and of 0.75 mm, and each CT that is
//! named, as images of 480 x 480. The alternative to keeping the anatomy is to draw all of it for each pose, which is what a camera that turns
//! costs. Processor time, medians; what other programs take is not in it.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]

#[path = "shared/figures.rs"]
#[allow(dead_code, reason = "times only")]
mod figures;

use std::path::Path;
use std::sync::Arc;

use bus::message::Chosen;
use bus::volume::OwnedVolume;
use figures::{Times, cpu_ms, load};
use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool, Vector};
use scene::{Scene, VolumeSource, VolumeSpec};
use slice_view_proc::reslice::Cpu;
use slice_view_proc::{Anatomy, Notice, Origin, Rendered, Renderer};

const POSES: u32 = 200;
const TURNS: u32 = 40;
const SCENE: &str = "[[views]]\nname = \"surface\"\nplane = \"surface\"\nextent = \"global\"\nsize = [480, 480]\n\
    [[views]]\nname = \"a\"\nplane = \"axial\"\nextent = \"local\"\n\
    [[views]]\nname = \"p\"\nplane = \"perpendicular\"\nextent = \"local\"\n\
    [[targets]]\nname = \"n\"\nct_mm = [20, -20, 50]\n[[targets]]\nname = \"m\"\nct_mm = [-20, -20, 60]";

fn main() {
    println!("{}", load());
    println!("                         voxels  triangles   made ms   image ms   turned ms   ratio");
    for spacing in [1.5, 0.75] {
        let mut spec = VolumeSpec::of_path("phantom".into());
        if let VolumeSource::Phantom { spacing_mm } = &mut spec.source {
            *spacing_mm = spacing;
        }
        row(&format!("phantom {spacing} mm"), &spec);
    }
    for path in std::env::args().skip(1).filter(|argument| !argument.starts_with("--")) {
        let name = Path::new(&path)
            .file_name()
            .map_or("CT".into(), |name| name.to_string_lossy());
        row(&name, &VolumeSpec::of_path(path.clone().into()));
    }
    println!("{}", load());
}

fn row(name: &str, spec: &VolumeSpec) {
    let volume = match volume_loader::load(spec) {
        Ok(volume) => volume,
        Err(error) => return println!("{name}: {error}"),
    };
    let mut anatomy = None;
    // By this thread's clock it would be nothing: another one makes it.
    let made = process_ms(|| anatomy = Some(Anatomy::of(&volume.view(), 300.0, None, &mut || {})));
    let Some(anatomy) = anatomy else { return };
    let triangles = anatomy.triangles();
    let (image, turned) = images(&volume, Arc::new(anatomy));
    println!(
        "{name:<18} {:>12}  {triangles:>9}  {made:>8.0}  {image:>9.2}  {turned:>10.1}  {:>6.1}",
        volume.grid.voxels(),
        turned / image
    );
}

/// Processor time of an image, ms: with the anatomy kept, and with all of it drawn.
fn images(volume: &OwnedVolume, anatomy: Arc<Anatomy>) -> (f64, f64) {
    let scene = Scene::parse(SCENE, Path::new("")).expect("a scene");
    let mut renderer = Renderer::new(scene.views[0].clone());
    renderer.show_anatomy(anatomy);
    let chosen = Chosen {
        name: "n".to_owned(),
        centre: scene.targets[0].centre,
        radius_mm: 2.5,
        entry: Some(Point::new(160.0, 30.0, 50.0)),
        stop_mm: 0.0,
    };
    let mut draw = |i: u32, camera: Option<SlicePlane>| {
        let what = Rendered {
            volume: volume.view(),
            volume_name: "01234567",
            marks: volume.marks,
            pose: Some(pose(volume, i)),
            accuracy: None,
            notice: Notice::Live,
            origin: Origin::Tracker,
            remarks: &[],
            chosen: Some(&chosen),
            seq: u64::from(i),
            registration_id: 1,
            tissue: slice_view_proc::tissue::Tissues::default(),
        };
        renderer.turn(camera);
        cpu_ms(|| drop(renderer.render(&what, &scene, &mut Cpu::default())))
    };
    draw(0, None);
    let (mut stood, mut turned) = (Times::default(), Times::default());
    (0..POSES).for_each(|i| stood.push(draw(i, None)));
    (0..TURNS).for_each(|i| turned.push(draw(i, Some(camera(volume, i)))));
    (stood.median(), turned.median())
}

/// A tube from the patient's left to the middle of the volume, that moves.
fn pose(volume: &OwnedVolume, i: u32) -> Rigid<Ct, Tool> {
    let sway = f64::from(i % 50) / 50.0;
    let tip = volume.grid.centre() + Vector::new(20.0 * sway, -5.0, 3.0 * sway);
    let along = Vector::new(-1.0, -0.3 + 0.1 * sway, 0.05)
        .direction()
        .unwrap_or(-Direction::X);
    Rigid::from_axes(tip, along, Direction::Z).unwrap_or_else(Rigid::identity)
}

/// Around the patient.
fn camera(volume: &OwnedVolume, i: u32) -> SlicePlane {
    let (s, c) = (0.15 * f64::from(i)).sin_cos();
    let right = Vector::new(c, s, 0.0).direction().unwrap_or(Direction::X);
    let (low, high) = volume.grid.bounds();
    let pixel_mm = low.distance(high) / 1.4 / 480.0;
    SlicePlane::centred(volume.grid.centre(), [right, -Direction::Z], pixel_mm, [480, 480]).expect("a camera")
}

/// Processor time of this process.
fn process_ms(work: impl FnOnce()) -> f64 {
    let now = || rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    let began = now();
    work();
    let ended = now();
    (ended.tv_sec - began.tv_sec) as f64 * 1e3 + (ended.tv_nsec - began.tv_nsec) as f64 / 1e6
}
