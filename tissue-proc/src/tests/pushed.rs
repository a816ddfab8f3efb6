//! The error of the shipped node alone, pushed by the tube: beside nodes, in fat, of other stiffness.

use bus::message::ToolPose;
use nalgebra::{Matrix3, Vector3};

use super::*;
use crate::message::header;

/// The shipped scene of organs without kidney and aorta, with numbers replaced.
fn scene(folder: &Path, name: &str, changes: &[(&str, &str)]) -> Scene {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/demo-organs.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let (head, rest) = text.split_once("[[organs]]").unwrap();
    let (_, node) = rest.rsplit_once("[[organs]]").unwrap();
    let (node, rest) = node.split_once("[[rigid]]").unwrap();
    let (_, around) = rest.split_once("[surroundings]").unwrap();
    // With the kidney the tube's way ends there until it touches, and fat is all around the node.
    let around = around.replace("corridor = 12.0", "corridor = 0.1");
    let mut text = format!("{head}[[organs]]{node}[surroundings]{around}");
    for (from, to) in changes {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join(name), text).unwrap();
    let text = format!(
        "seed = 1\n[volume]\nsource = \"phantom\"\nspacing_mm = 1.5\n[tissue]\norgans = \"{name}\"\ntolerance = 1e-7\nerror_every = 1\n\
         [[targets]]\nname = \"node\"\nct_mm = [{}, {}, {}]\ndiameter_mm = 5.0\n",
        NODE[0], NODE[1], NODE[2]
    );
    Scene::parse(&text, &folder.join("scene.toml")).unwrap()
}

/// The node, as the tube comes to it from the patient's left with its tip so far from the node's middle.
struct Pushed {
    anatomy: Anatomy,
}

impl Pushed {
    fn by(scene: &Scene) -> Self {
        Self {
            anatomy: anatomy(scene).unwrap(),
        }
    }

    /// Where the node's middle has gone, mm, in a settled state, and the force on the tube, N, in the CT's axes.
    fn to(&mut self, from: f64) -> [Vector3<f64>; 2] {
        let Anatomy { live, errors, .. } = &mut self.anatomy;
        let settled = (0..12).any(|_| state(live.answer(several::at_the_node(from))).0 == State::Settled);
        assert!(settled, "{from}");
        let node = Point::new(NODE[0], NODE[1], NODE[2]);
        let force = live.turned(&live.frames.force().force);
        [errors.moved(node, live).unwrap(), force].map(Vector3::from)
    }

    /// The covariances that are told of both there, mm^2 and N^2.
    fn covariances(&mut self, from: f64) -> Option<[Matrix3<f64>; 2]> {
        let Anatomy { live, errors, .. } = &mut self.anatomy;
        let Answer::State(frame) = live.answer(several::at_the_node(from)) else {
            panic!("{from}")
        };
        errors.forget();
        errors.find(&ToolPose::EMPTY, &frame, live);
        let answer = Answer::State(frame);
        let header = header(&ToolPose::EMPTY, (1, [0; 32]), Some(&answer), live);
        let told = errors.told(header, Some(&frame), live);
        (told.errors_known == 1 && told.force_error_known == 1).then(|| {
            [told.errors[0].covariance, told.force_covariance]
                .map(|[xx, xy, xz, yy, yz, zz]| Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
        })
    }
}

/// Its second derivatives without contact are not positive definite from about the first millimetre on: its error was told as unknown.
#[test]
fn the_error_of_a_node_that_the_tube_pushes_is_that_of_nodes_in_fat_of_other_stiffness() {
    let folder = tempfile::tempdir().unwrap();
    let small = 0.01_f64;
    let [fat, node] = ["young = 2e-3", "young = 20e-3"];
    let by = |name, key: &str, by: f64| {
        let value: f64 = key.rsplit_once(' ').unwrap().1.parse().unwrap();
        Pushed::by(&scene(
            folder.path(),
            name,
            &[(key, &format!("young = {}", value * by.exp()))],
        ))
    };
    let mut base = Pushed::by(&scene(folder.path(), "base.toml", &[]));
    let mut others = [
        [by("a.toml", fat, small), by("b.toml", fat, -small)],
        [by("c.toml", node, small), by("d.toml", node, -small)],
    ];
    // The scene's own standard deviations of both logarithms.
    let spread = 0.5;
    for from in [8.0, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.0, -0.5, -1.0, -1.5, -2.0] {
        let [place, force] = base.to(from);
        let mut again = [Matrix3::zeros(); 2];
        for pair in &mut others {
            let [up, down] = pair.each_mut().map(|one| one.to(from));
            for (again, (up, down)) in again.iter_mut().zip(up.iter().zip(&down)) {
                let by_one = (up - down) * (spread / (2.0 * small));
                *again += by_one * by_one.transpose();
            }
        }
        let told = base.covariances(from).unwrap();
        let deviations = told.map(|told| told.trace().sqrt());
        println!(
            "{from}: {:.3} mm, {:.4} N; deviations {deviations:.4?}",
            place.norm(),
            force.norm()
        );
        // Differences of states a hundredth apart leave the square of that; by points of contact that come and go within it more. Rounding is
        // of what is there where nothing presses.
        for (told, again) in told.iter().zip(&again) {
            let off = (told - again).norm();
            println!("  off {:.1e}", off / again.norm());
            assert!(off <= 1e-3 * again.norm() + 1e-12, "{from}: {told}{again}");
        }
        assert!(
            from > 1.0 || (deviations[0] > 0.01 && deviations[1] > 0.1 * force.norm()),
            "{from}"
        );
    }
}
