//! The shipped scene's kidney, and the tube that passes under it.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use organs::{Labels, Model, Parsed, Plan, RawSpaceScene, Way};
use scene::Scene;
use simulation::space::cells::Field;
use simulation::space::frames::{Frames, Settings};
use simulation::space::tube::Tube;

/// Places inside that are compared lie so far apart along the axes, mm.
const APART: f64 = 2.0;

/// A place inside: the nodes that move it, and their weights.
pub(crate) type Place = Vec<(usize, f64)>;

/// The kidney as `config/tissue.toml` has it, with frames of these settings; the tube's way; and places all over the inside.
pub(crate) fn kidney(settings: &[Settings]) -> (Vec<Frames>, Way, Vec<Place>) {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
    let path = config.join("tissue.toml");
    let scene = Scene::parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
    let path = config.join("solids/demo-kidney.toml");
    let source = Parsed::<RawSpaceScene>::parse(organs::read(&path).unwrap(), &path).unwrap();
    let plan = Plan::new(&source.scene).unwrap();
    let map = volume_loader::load_labels_seeded(Path::new("phantom"), &scene.volume, scene.seed).unwrap();
    let (volume, view) = (&map.volume, map.volume.view());
    let labels = Labels::new(&volume.grid, volume.hash.to_string(), |z, out| view.slice(z, out)).unwrap();
    let made = settings.iter().map(|settings| {
        let model = Model::without_tube(&plan, &labels).unwrap();
        let (way, last) = (model.way, model.way.last(&model.bodies[0].field));
        let tube = tube(&way, scene.tool.length_mm, pose(&way, 0.0, &Vector3::zeros()));
        let wanted = |at: &Vector3<f64>, _: &Vector3<f64>| way.spacing([at, at], last).is_some();
        let (a, places) = (model.system.initial(), places(&model));
        let frames = Frames::new(model.system, a, 0, tube, *settings, wanted).unwrap();
        (frames, (way, places))
    });
    let (frames, mut rest): (Vec<Frames>, Vec<(Way, Vec<Place>)>) = made.unzip();
    let (way, places) = rest.swap_remove(0);
    (frames, way, places)
}

/// By the label map's own field and the mesh's polynomials, not by the points that the mesh carries.
fn places(model: &Model) -> Vec<Place> {
    let (field, solid) = (&model.bodies[0].field, model.system.bodies.solid(0));
    let [low, high] = field.corners;
    let counts = ((high - low) / APART).map(|n| n as usize);
    let all = (0..counts.product()).map(|k| {
        let (x, y, z) = (k % counts.x, k / counts.x % counts.y, k / (counts.x * counts.y));
        low + Vector3::new(x as f64, y as f64, z as f64) * APART
    });
    let inside = all.filter(|at| field.value(at) < 0.0);
    let shares = inside.filter_map(|at| solid.shares(&at));
    shares
        .map(|shares| shares.iter().map(|s| (s.node as usize, s.weight)).collect())
        .collect()
}

/// The tube in a frame of its own: the middle of its round tip is the origin, and the handle along -z.
fn tube(way: &Way, length: f64, pose: Isometry3<f64>) -> Tube {
    let handle = Point3::new(0.0, 0.0, way.radius - length);
    Tube::new(pose, &[Point3::origin(), handle], &[way.radius; 2]).unwrap()
}

/// Its pose with the foremost point so far from the entry, mm, and moved.
pub(crate) fn pose(way: &Way, gone: f64, aside: &Vector3<f64>) -> Isometry3<f64> {
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &way.direction).unwrap();
    Isometry3::from_parts(Translation3::from(way.middle(gone) + aside), turn)
}
