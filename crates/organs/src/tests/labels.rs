//! Labels on grids of any orthogonal axes.

use nalgebra::Vector3;

use super::{RADIUS, SIZE, grid, labels};
use crate::{Labels, NoLabels};

/// Axes along the patient's, turned by a third about the diagonal, turned by an angle, and left-handed ones.
const AXES: [[[f64; 3]; 3]; 5] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]],
    [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, -1.0]],
];

#[test]
fn places_of_the_patient_have_their_label_whatever_the_axes() {
    let far = RADIUS + 0.9;
    for axes in AXES {
        let labels = labels(axes).unwrap();
        for (at, wanted) in [
            ([0.0, 0.0, 0.0], 1),
            ([10.0, -8.0, 6.0], 1),
            ([0.0, -far - 2.0, 0.0], 0),
            ([far + 2.0, 0.0, 0.0], 0),
            ([0.0, RADIUS + 4.5, 0.0], 3),
            ([0.0, 0.0, 1000.0], 0),
        ] {
            let at = Vector3::from(at);
            let own = labels.own(&at);
            assert_eq!(labels.at(&own), wanted, "{at:?} with {axes:?}");
            // Places are tens of mm, so a turn and back is off by some 1e-14 mm.
            assert!((labels.patient(&own) - at).norm() < 1e-12);
            assert!((labels.turned(&labels.own_direction(&at)) - at).norm() < 1e-12);
        }
        assert_eq!(labels.all(), [1, 3]);
        assert_eq!(labels.hash, "ball");
    }
}

#[test]
fn moments_keep_their_sense_where_the_files_axes_are_left_handed() {
    for axes in AXES {
        let labels = labels(axes).unwrap();
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| labels.turned(&axis));
        assert!((x.cross(&y) - z).norm() < 1e-12, "{axes:?}");
    }
}

#[test]
fn axes_that_lean_and_voxels_below_zero_are_refused() {
    let leaning = [[1.0, 0.0, 0.0], [0.01, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert!(matches!(
        labels(leaning).unwrap_err(),
        NoLabels::Oblique { axes: [0, 1], cosine } if (cosine - 0.01).abs() < 1e-4
    ));
    let mut slices = 0;
    let last = Labels::new(&grid(AXES[0]), String::new(), |z, out| {
        assert_eq!((z, out.len()), (slices, SIZE[0] * SIZE[1]));
        slices += 1;
        out.fill(0);
        if z as usize == SIZE[2] - 1 {
            out[SIZE[0] * SIZE[1] - 1] = -7;
        }
    });
    assert_eq!(last.unwrap_err(), NoLabels::Negative { found: -7 });
    assert_eq!(slices as usize, SIZE[2]);
}

#[test]
fn each_voxel_about_a_box_is_visited_once() {
    let labels = labels(AXES[0]).unwrap();
    let mut seen = Vec::new();
    let corners = [Vector3::new(-10.0, 3.1, 8.9), Vector3::new(4.0, 6.0, 500.0)];
    labels.each([&corners[0], &corners[1]], &mut |at, label| {
        assert_eq!(label, labels.at(&at));
        seen.push((at / super::SPACING).map(|x| x.round() as usize));
    });
    let last = SIZE[2] - 1;
    assert_eq!(seen.first().map(|v| [v.x, v.y, v.z]), Some([0, 1, 2]));
    assert_eq!(seen.last().map(|v| [v.x, v.y, v.z]), Some([2, 2, last]));
    assert_eq!(seen.len(), 3 * 2 * (last - 1));
}
