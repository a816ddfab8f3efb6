//! The shipped scene's kidney, and the tube that passes under it.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use organs::{Labels, Model, Parsed, Plan, RawSpaceScene, Way};
use scene::Scene;
use simulation::space::frames::{Frames, Settings};
use simulation::space::tube::Tube;

/// The kidney as `config/tissue.toml` has it, with frames of these settings; and the tube's way.
pub(crate) fn kidney(settings: &[Settings]) -> (Vec<Frames>, Way) {
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
        let a = model.system.initial();
        (Frames::new(model.system, a, 0, tube, *settings, wanted).unwrap(), way)
    });
    let (frames, ways): (Vec<Frames>, Vec<Way>) = made.unzip();
    (frames, ways[0])
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
