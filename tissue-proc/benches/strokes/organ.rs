//! The shipped scene's kidney, and the tube that passes under it.

use std::path::Path;

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use organs::{Labels, Model, Parsed, Plan, RawSpaceScene, Way};
use scene::Scene;
use simulation::space::cells::Field;
use simulation::space::frames::{Frames, Settings};
use simulation::space::tube::Tube;

/// The kidney as `config/tissue.toml` has it.
pub(crate) struct Shipped {
    plan: Plan,
    labels: Labels,
    tool_mm: f64,
}

/// Places in the organ, as combinations of its nodes.
pub(crate) struct Targets(Vec<Vec<(u32, f64)>>);

impl Targets {
    /// How far each has moved.
    pub(crate) fn moved(&self, a: &[f64]) -> Vec<Vector3<f64>> {
        let node = |(node, weight): &(u32, f64)| Vector3::from_column_slice(&a[3 * *node as usize..][..3]) * *weight;
        self.0.iter().map(|row| row.iter().map(node).sum()).collect()
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

impl Shipped {
    pub(crate) fn read() -> Self {
        let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
        let path = config.join("tissue.toml");
        let scene = Scene::parse(&std::fs::read_to_string(&path).unwrap(), &path).unwrap();
        let path = config.join("solids/demo-kidney.toml");
        let source = Parsed::<RawSpaceScene>::parse(organs::read(&path).unwrap(), &path).unwrap();
        let map = volume_loader::load_labels_seeded(Path::new("phantom"), &scene.volume, scene.seed).unwrap();
        let (volume, view) = (&map.volume, map.volume.view());
        Self {
            plan: Plan::new(&source.scene).unwrap(),
            labels: Labels::new(&volume.grid, volume.hash.to_string(), |z, out| view.slice(z, out)).unwrap(),
            tool_mm: scene.tool.length_mm,
        }
    }

    /// The same in cubes of another side, mm; near the tube's way they are halved as ever.
    pub(crate) fn in_cubes_of(mut self, side: f64) -> Self {
        self.plan.organs[0].settings.side = side;
        self
    }

    pub(crate) fn model(&self) -> Model {
        Model::without_tube(&self.plan, &self.labels).unwrap()
    }

    /// All over the inside of such a model, 2 mm apart, by the label map's own field and the mesh's polynomials: not the points that the mesh carries.
    pub(crate) fn places(model: &Model) -> Targets {
        targets(&model.bodies[0], 2.0, 0.0)
    }

    /// Frames of such a model with these settings, the tube's way, and places some 3 mm deep in the organ, 12 mm apart.
    pub(crate) fn frames(&self, model: &Model, settings: &Settings) -> (Frames, Way, Targets) {
        let model = model.changed(&self.plan, &self.labels).unwrap();
        let body = &model.bodies[0];
        let (way, last) = (model.way, model.way.last(&body.field));
        let tube = tube(&way, self.tool_mm, pose(&way, 0.0, &Vector3::zeros()));
        let wanted = |at: &Vector3<f64>, _: &Vector3<f64>| way.spacing([at, at], last).is_some();
        // A smoothed indicator, from a half outside to minus a half inside: 1.64 deviations of 2 mm deep.
        let targets = targets(body, 12.0, -0.45);
        let a = model.system.initial();
        let frames = Frames::new(model.system, a, 0, tube, *settings, wanted).unwrap();
        (frames, way, targets)
    }
}

fn targets(body: &organs::Body, apart: f64, below: f64) -> Targets {
    let [low, high] = body.field.corners;
    let counts = (high - low).map(|d| (d / apart) as usize + 1);
    let places = (0..counts.iter().product::<usize>()).map(|n| {
        let [i, j, k] = [n % counts.x, n / counts.x % counts.y, n / (counts.x * counts.y)].map(|i| apart * i as f64);
        low + Vector3::new(i, j, k)
    });
    let deep = places.filter(|at| body.field.value(at) < below);
    // One in the region whose cube was all but empty has none.
    Targets(deep.filter_map(|at| body.mesh.row(&at)).collect())
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
