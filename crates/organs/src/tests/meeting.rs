//! Organs that have come into one another, planted: two balls that are moved by known ways.

use nalgebra::{Rotation3, Vector3};
use simulation::space::cells::Field;

use super::{labelled, plan};
use crate::{Meeting, Meetings, Model};

const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// Radii of the balls, mm.
const RADII: [f64; 2] = [12.0, 9.0];

/// Two balls beside one another along x; `apart` is the way between them, mm, by their labels.
fn balls(apart: f64) -> Model {
    let organ = |name: &str, label: usize| {
        format!(
            "[[organs]]\nname = \"{name}\"\nlabel = {label}\nyoung = 0.01\npoisson = 0.45\nsmoothing = 2.0\ncubes = {{ side = 12.0 }}\n"
        )
    };
    let text = format!(
        "title = \"two balls\"\nunits = {{ length = \"mm\", stress = \"N/mm2\" }}\nspace = {{ labels = \"balls.nii\" }}\n{}{}\
         [surroundings]\nyoung = 1e-3\nmargin = 20.0\ncorridor = 8.0\n\
         [tube]\ndiameter = 12.0\nentry = [-12.0, -50.0, 1.0]\ntarget = [-12.0, 0.0, 1.0]\nstroke = 4.0\nstep = 2.0\n",
        organ("one", 1),
        organ("two", 2)
    );
    let middles = [-RADII[0], apart + RADII[1]];
    let label = |at: &Vector3<f64>| {
        let inside = |k: usize| (at - Vector3::new(middles[k], 0.0, 0.0)).norm() < RADII[k];
        if inside(0) { 1 } else { 2 * i16::from(inside(1)) }
    };
    Model::without_tube(&plan(&text).unwrap(), &labelled(AXES, label).unwrap()).unwrap()
}

/// The way between both surfaces along the line of their middles, by the fields alone.
fn gap(model: &Model) -> f64 {
    let [low, high] = model.bodies[0].field.corners;
    let middle = 0.5 * (low + high);
    let at = |x: f64| Vector3::new(x, middle.y, middle.z);
    let inside = |k: usize, x: f64| model.bodies[k].field.value(&at(x)) < 0.0;
    let steps = (0..100_000).map(|k| middle.x + 1e-3 * f64::from(k));
    let end = steps.clone().find(|x| !inside(0, *x)).unwrap();
    let begin = steps.into_iter().find(|x| inside(1, *x)).unwrap();
    begin - end
}

/// What is found where the second ball is moved.
fn met(model: &Model, moved: impl Fn(&dyn simulation::space::solid::Solid, &mut [f64])) -> Option<Meeting> {
    let meetings = Meetings::new(&model.bodies);
    let (bodies, mut a) = (&model.system.bodies, model.system.initial());
    moved(bodies.solid(1), &mut a[bodies.offset(1)..]);
    meetings.deepest(bodies, &a)
}

#[test]
fn balls_that_are_moved_into_one_another_are_found_with_their_depth_and_beside_one_another_are_not() {
    let model = balls(6.0);
    let gap = gap(&model);
    assert!((3.0..9.0).contains(&gap), "{gap}");
    let meetings = Meetings::new(&model.bodies);
    assert_eq!(meetings.at_rest(), None);
    // An eighth of the cube root of a ball's volume, or 1 mm.
    assert!(meetings.step() <= 1.0 && meetings.places() > 1000);
    for depth in [0.5, 2.0, 6.0] {
        let found = met(&model, |solid, a| {
            solid.translate(a, Vector3::new(-gap - depth, 0.0, 0.0))
        });
        let Meeting { organs, depth: found } = found.unwrap();
        assert_eq!(organs, [0, 1]);
        // Balls of some 10 mm: a place 0.6 mm beside the line of the middles is 0.02 mm less deep in each, and a label's ball is none.
        assert!((found - depth).abs() < 0.15, "{found} for {depth}");
    }
    for beside in [0.1, 0.5, 3.0] {
        let found = met(&model, |solid, a| {
            solid.translate(a, Vector3::new(beside - gap, 0.0, 0.0))
        });
        assert_eq!(found, None, "{beside}");
    }
    // Nothing that the model says could be compared with: no number is no place.
    let none = met(&model, |_, a| a[40] = f64::NAN);
    assert!(none.unwrap().depth.is_infinite());
}

/// Stated: settled, and not in one another. True: one organ had gone through the other from one state to the next, and was apart again behind it.
#[test]
fn balls_that_go_through_one_another_between_two_states_are_found_there() {
    let model = balls(6.0);
    let (gap, meetings, bodies) = (gap(&model), Meetings::new(&model.bodies), &model.system.bodies);
    let placed = |by: Vector3<f64>| {
        let mut a = model.system.initial();
        bodies.solid(1).translate(&mut a[bodies.offset(1)..], by);
        a
    };
    let [before, behind] = [1.0 - gap, -gap - 60.0].map(|x| placed(Vector3::new(x, 0.0, 0.0)));
    let both = [&before, &behind].map(|a| meetings.deepest(bodies, a));
    assert_eq!(both, [None, None]);
    let found = meetings.deepest_between(bodies, &before, &behind).unwrap();
    // As deep as the smaller one is thick at least, somewhere on the way.
    assert!(found.organs == [0, 1] && found.depth > RADII[1], "{found:?}");
    // Around it, and along it, nothing is met.
    let beside = placed(Vector3::new(1.0 - gap, 30.0, 0.0));
    assert_eq!(meetings.deepest_between(bodies, &before, &beside), None);
    assert_eq!(meetings.deepest_between(bodies, &before, &before), None);
    // And where it ends counts, as ever.
    let deep = placed(Vector3::new(-gap - 2.0, 0.0, 0.0));
    assert_eq!(
        meetings.deepest_between(bodies, &before, &deep),
        meetings.deepest(bodies, &deep)
    );
}

/// A ball that is turned, stretched and swallowed is pulled back to where it is at rest, and its surface is the one that it has then.
#[test]
fn a_ball_that_is_turned_or_stretched_or_swallowed_is_found_where_it_is() {
    let model = balls(6.0);
    let (gap, body) = (gap(&model), &model.bodies[1]);
    let middle = 0.5 * (body.field.corners[0] + body.field.corners[1]);
    let turned = |by: f64| {
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.5);
        met(&model, |solid, a| {
            solid.rotate(a, &turn, middle);
            solid.translate(a, Vector3::new(-gap + by, 0.0, 0.0));
        })
    };
    // A label's ball of 9 mm in voxels of 3 is round to less than a millimetre.
    assert_eq!(turned(1.0), None);
    let found = turned(-2.0).unwrap().depth;
    assert!((found - 2.0).abs() < 1.0, "{found}");
    // Stretched by 1.5 along x about its middle: it comes half of its radius nearer on both sides.
    let stretched = |by: f64| {
        met(&model, |_, a| {
            for (node, u) in body.mesh.nodes.iter().zip(a.chunks_exact_mut(3)) {
                u[0] = 0.5 * (node.x - middle.x) + by;
            }
        })
    };
    let radius = (0..)
        .map(|k| 0.01 * f64::from(k))
        .find(|r| body.field.value(&(middle - Vector3::x() * *r)) >= 0.0)
        .unwrap();
    let at = 0.5 * radius - gap;
    assert_eq!(stretched(at + 0.1), None);
    let found = stretched(at - 1.0).unwrap().depth;
    assert!((found - 1.0).abs() < 0.15, "{found}");
    // Wholly in the other one: its surface has no point of the other's near.
    let other = 0.5 * (model.bodies[0].field.corners[0] + model.bodies[0].field.corners[1]);
    let swallowed = met(&model, |solid, a| solid.translate(a, other - middle))
        .unwrap()
        .depth;
    assert!(swallowed > 3.0, "{swallowed}");
}

#[test]
fn organs_that_touch_at_rest_are_found_there() {
    let touching = balls(-3.0);
    let found = Meetings::new(&touching.bodies).at_rest().unwrap();
    assert_eq!(found.organs, [0, 1]);
    // Labels whose voxels share faces: by a part of a voxel in one another, or at one another.
    assert!((-0.05..1.5).contains(&found.depth), "{found:?}");
    // And one organ alone meets none.
    let one = Meetings::new(&touching.bodies[..1]);
    assert_eq!((one.at_rest(), one.places()), (None, 0));
}
