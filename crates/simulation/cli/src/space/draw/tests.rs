//! Pictures of a ball that is moved as a whole: where it is drawn, and how large.

use nalgebra::{Matrix3, Vector3};

use super::super::Space;
use super::super::errors::Said;
use super::super::report::Whole;
use super::super::run::{OnTube, Run, State};
use super::super::tests::maps::{BALL, SCENE, folder};
use super::super::tissue::Between;
use super::cut::Pixel;
use super::{Album, shape};

/// A state in which all is moved by `by`, in the patient's axes.
fn moved(space: &Space, by: &Vector3<f64>) -> State {
    let own = space.labels.own_direction(by);
    let nodes = space.model.system.places().len() / 3;
    State {
        label: "moved".to_owned(),
        stroke: 14.0,
        a: (0..3 * nodes).map(|k| own[k % 3]).collect(),
        found: None,
        on_tube: OnTube {
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            points: 0,
            area: 0.0,
            depth: 0.0,
        },
        on_rigid: Vec::new(),
        balance: 0.0,
        between: Between {
            depth: 0.0,
            at: Vector3::zeros(),
            side: 10.0,
        },
        in_rigid: 0.0,
        parts: 1,
        seconds: 0.0,
    }
}

#[test]
fn what_is_moved_as_a_whole_is_drawn_where_it_is() {
    // A left-handed file, its axes in another order.
    let (_folder, path) = folder(
        &Matrix3::from_columns(&[Vector3::z(), Vector3::x(), -Vector3::y()]),
        0.0,
    );
    let space = Space::new(SCENE.to_owned(), &path, None, super::super::tests::READ).unwrap();
    let by = Vector3::new(3.0, 2.0, -4.0);
    let run = Run {
        states: vec![moved(&space, &by)],
        refused: None,
    };
    let whole = Whole {
        title: "a ball",
        path: "ball.nii",
        plan: &space.plan,
        labels: &space.labels,
        model: &space.model,
        run: &run,
        origin: &space.origin,
        errors: &Said::NotAsked,
        complete: true,
    };
    let album = Album::new(&whole);
    let (state, axes) = (&run.states[0], album.axes());
    let all = album.moved(state);
    for (which, [right, down]) in axes.iter().enumerate() {
        let (cut, plane) = album.cut(state, &all, which, 300).unwrap();
        // Middle and number of the pixels that satisfy something.
        let seen = |wanted: &dyn Fn(usize) -> bool| {
            let (mut sum, mut count) = ([0.0, 0.0], 0.0);
            for n in (0..cut.pixels.len()).filter(|n| wanted(*n)) {
                sum = [sum[0] + (n % 300) as f64, sum[1] + (n / 300) as f64];
                count += 1.0;
            }
            ([sum[0] / count, sum[1] / count], count * plane.pixel_mm().powi(2))
        };
        // The tube was put into the ball: both are there, and said to be.
        let organ = seen(&|n| matches!(cut.pixels[n], Pixel::Organ(_) | Pixel::Overlap));
        // The circles in which the plane cuts the ball where it is, and where it was.
        let middle = Vector3::from(plane.point(149.5, 149.5).mm());
        let (normal, ball) = (right.cross(down), Vector3::from(BALL.0) + by);
        let circle = std::f64::consts::PI * (BALL.1.powi(2) - (ball - middle).dot(&normal).powi(2)).max(0.0);
        let on = [(ball - middle).dot(right), (ball - middle).dot(down)].map(|mm| mm / plane.pixel_mm() + 149.5);
        println!("cut {which}: {organ:?}, expected {on:?} {circle:.1}");
        // The surface of these voxels is within half a millimetre of the ball's: 5 % of a circle of 20 mm.
        assert!((organ.1 - circle).abs() < 0.05 * BALL.1.powi(2) * 3.2, "{which}");
        let off = (organ.0[0] - on[0]).hypot(organ.0[1] - on[1]) * plane.pixel_mm();
        assert!(off < 0.4, "{which}: off by {off} mm");
        // What a lattice says between its places of a uniform field is that field.
        let shown = cut
            .pixels
            .iter()
            .filter_map(|p| if let Pixel::Organ(v) = p { Some(v) } else { None });
        assert!(shown.into_iter().all(|v| (v - by.norm()).abs() < 1e-9));
        assert!(cut.pixels.contains(&Pixel::Left) && cut.pixels.contains(&Pixel::Overlap));
        // The floor is the only label beside the ball, and named rigid; it lies at the patient's back.
        let rigid = (0..cut.pixels.len()).filter(|n| cut.pixels[*n] == Pixel::Rigid);
        let back = |n: usize| plane.point((n % 300) as f64, (n / 300) as f64).mm()[1] - BALL.0[1];
        assert!(rigid.into_iter().all(|n| (19.0..32.0).contains(&back(n))));
        assert!(!cut.pixels.contains(&Pixel::Other));
    }
}

#[test]
fn the_head_is_up_and_no_side_is_mistaken() {
    let (_folder, path) = folder(&Matrix3::identity(), 0.0);
    let space = Space::new(SCENE.to_owned(), &path, None, super::super::tests::READ).unwrap();
    let run = Run {
        states: Vec::new(),
        refused: None,
    };
    let whole = Whole {
        title: "a ball",
        path: "ball.nii",
        plan: &space.plan,
        labels: &space.labels,
        model: &space.model,
        run: &run,
        origin: &space.origin,
        errors: &Said::NotAsked,
        complete: true,
    };
    let album = Album::new(&whole);
    let camera = shape::camera(&album.skins, &Vector3::y(), [300, 200]).unwrap();
    let seen = |at: Vector3<f64>| camera.project(super::skin::point(&(Vector3::from(BALL.0) + at)));
    let (here, left, head, front) = (
        seen(Vector3::zeros()),
        seen(Vector3::x()),
        seen(Vector3::z()),
        seen(-Vector3::y()),
    );
    // Of a tube that comes from the front: the patient's left is on the right, the head up, the front near the viewer.
    assert!(left.x > here.x && (left.y - here.y).abs() < 1e-9);
    assert!(head.y < here.y && front.depth_mm < here.depth_mm);
    // Cuts along the tube have its tip down.
    for [right, down] in &album.axes()[..2] {
        assert!((down - Vector3::y()).norm() < 1e-12 && right.dot(down).abs() < 1e-12);
    }
    // Across, the viewer looks along it.
    let [right, down] = album.axes()[2];
    assert!((right.cross(&down) - Vector3::y()).norm() < 1e-12 && (down + Vector3::z()).norm() < 1e-12);
}
