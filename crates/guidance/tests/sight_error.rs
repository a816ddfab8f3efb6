//! The predicted error, and what the verdict claims by it: held against poses drawn from the covariance.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

mod support;

use chance::Chance;
use geometry::motion::Motion;
use geometry::{Ct, Point, Rigid, Tool, Uncertain};
use guidance::sight::{Aim, Covariance, Sight, Unknown, Verdict};
use nalgebra::{Matrix2, Matrix6, Vector2, Vector6};
use proptest::prelude::*;
use support::{about, aim, look, pose, upper};

const DRAWS: u64 = 20_000;

/// A factor of a covariance: lower triangular, turns of `turn` rad about the point `c` and shifts of `shift` mm, all correlated.
fn factor(seed: u64, c: [f64; 3], turn: f64, shift: f64) -> Matrix6<f64> {
    let chance = Chance::new(seed, 0);
    let l = Matrix6::from_fn(|i, j| {
        let size = if i < 3 { turn } else { shift };
        if j > i {
            0.0
        } else {
            size * chance.normal((6 * i + j) as u64)
        }
    });
    // v = v_c - w x c = v_c + [c]x w.
    let mut lever = Matrix6::identity();
    let cross = nalgebra::Vector3::from(c).cross_matrix();
    lever.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
    lever * l
}

/// A true pose: the pose at hand, moved by a motion of the covariance.
fn drawn(ct_from_tool: &Rigid<Ct, Tool>, factor: &Matrix6<f64>, draw: u64) -> Rigid<Ct, Tool> {
    let chance = Chance::new(7, draw);
    let motion = factor * Vector6::from_fn(|i, _| chance.normal(i as u64));
    let [turn, shift] = [0, 3].map(|k| motion.fixed_rows::<3>(k).into_owned());
    ct_from_tool.moved_by(&Motion { turn, shift }).unwrap()
}

/// The target on the sight of the tool at a pose, with the sight's axes fixed to the tool: (right, up, depth), by hand.
fn on_sight(ct_from_tool: &Rigid<Ct, Tool>, target: Point<Ct>) -> [f64; 3] {
    let [x, y, z] = (ct_from_tool.inverse() * target).mm();
    [-x, y, z]
}

fn sight_of(ct_from_tool: Rigid<Ct, Tool>, factor: &Matrix6<f64>, aim: &Aim) -> Sight {
    look(
        ct_from_tool,
        Covariance::Upper(upper(&(factor * factor.transpose()))),
        aim,
    )
    .unwrap()
}

/// Five deviations of a count of `DRAWS` with this share.
fn binomial(share: f64) -> f64 {
    5.0 * (share * (1.0 - share) / DRAWS as f64).sqrt()
}

#[test]
fn the_ellipse_and_the_axis_hold_95_percent_of_the_draws() {
    for seed in 0..4 {
        let tip = [20.0, -150.0, 300.0];
        let ct_from_tool = pose([0.4, -1.1, 0.3 * seed as f64], tip);
        // Beside the axis and ahead, so that every turn counts.
        let target = ct_from_tool * Point::new(6.0, -11.0, 80.0);
        let factor = factor(seed, tip, 2e-3, 0.3);
        let sight = sight_of(ct_from_tool, &factor, &aim(target.mm(), 5.0));
        let predicted = sight.predicted.unwrap();
        let at = [sight.miss_mm[0], sight.miss_mm[1], sight.depth_mm];
        let [mut ellipse, mut by_matrix, mut along, mut ball] = [0_u32; 4];
        let [a, b] = predicted.ellipse.covariance_mm2;
        let inverse = Matrix2::new(a[0], a[1], b[0], b[1]).try_inverse().unwrap();
        for draw in 0..DRAWS {
            let there = on_sight(&drawn(&ct_from_tool, &factor, draw), target);
            let off = [0, 1, 2].map(|k| there[k] - at[k]);
            let plane = Vector2::new(off[0], off[1]);
            ellipse += u32::from(predicted.ellipse.contains([off[0], off[1]]));
            // The 0.95 quantile from a table.
            by_matrix += u32::from(plane.dot(&(inverse * plane)) <= 5.991_465);
            along += u32::from(off[2].abs() <= predicted.along_95_mm);
            ball += u32::from(off[0].hypot(off[1]).hypot(off[2]) <= predicted.ball_95_mm);
        }
        let [ellipse, by_matrix, along, ball] = [ellipse, by_matrix, along, ball].map(|n| f64::from(n) / DRAWS as f64);
        for (what, share) in [("ellipse", ellipse), ("matrix", by_matrix), ("along", along)] {
            // Second order: turns of 4e-3 over 360 mm are 3e-3 mm beside 0.4 mm, which moves the share by less than 1e-3.
            assert!((share - 0.95).abs() < binomial(0.95) + 1e-3, "{seed} {what}: {share}");
        }
        assert!((ellipse - by_matrix).abs() < 2e-4, "{ellipse} {by_matrix}");
        assert!(ball > 0.95 - binomial(0.95), "{seed}: {ball}");
    }
}

/// Central differences of the target on the sight by each of the six motions, about a pose and away from the axis.
#[test]
fn the_projection_has_the_jacobian_of_differences() {
    let ct_from_tool = pose([0.9, 0.5, -2.0], [120.0, -40.0, 260.0]);
    let target = ct_from_tool * Point::new(9.0, 14.0, 70.0);
    let factor = factor(3, [100.0, 20.0, 90.0], 1e-2, 0.5);
    let h = 1e-5;
    let mut slopes = nalgebra::Matrix3x6::<f64>::zeros();
    for k in 0..6 {
        let side = |sign: f64| {
            let motion = Vector6::from_fn(|i, _| if i == k { sign * h } else { 0.0 });
            let [turn, shift] = [0, 3].map(|k| motion.fixed_rows::<3>(k).into_owned());
            on_sight(&ct_from_tool.moved_by(&Motion { turn, shift }).unwrap(), target)
        };
        let (more, less) = (side(1.0), side(-1.0));
        (0..3).for_each(|i| slopes[(i, k)] = (more[i] - less[i]) / (2.0 * h));
    }
    let by_differences = slopes * factor * factor.transpose() * slopes.transpose();
    let predicted = sight_of(ct_from_tool, &factor, &aim(target.mm(), 5.0))
        .predicted
        .unwrap();
    let [[a, b], [c, d]] = predicted.ellipse.covariance_mm2;
    let along = (predicted.along_95_mm / 1.959_963_984_540_054).powi(2);
    // h^2 / 6 x 500 mm and eps x 500 mm / h are 1e-8 of a slope below 500; twice that times 6 slopes and variances below 1e-2 x 500.
    let entries = [(0, 0, a), (0, 1, b), (1, 0, c), (1, 1, d), (2, 2, along)];
    for (i, j, entry) in entries {
        assert!(
            (entry - by_differences[(i, j)]).abs() < 1e-6,
            "{i} {j}: {entry} {}",
            by_differences[(i, j)]
        );
    }
}

/// Poses at the edge of the verdict: the target is as small as ON TARGET allows. The true aim has to lie in it in 94.9 of 100 draws, for
/// errors of every shape, for turns about a place far away, and far from the origin of the CT.
#[test]
fn on_target_is_true_of_the_draws_at_its_edge() {
    let mut said = 0;
    for seed in 0..24 {
        let chance = Chance::new(11, seed);
        let far = [0.0, 300.0, 1e4][seed as usize % 3];
        let tip = [far * 0.6, -far * 0.64, far * 0.48];
        let ct_from_tool = pose([0, 1, 2].map(|k| chance.normal(k)), tip);
        let turn = [1e-4, 3e-3, 3e-2, 0.3][seed as usize / 3 % 4];
        // About the aim itself, the first order of a turn is nothing, and the second order all there is.
        let centre = if seed % 2 == 0 { tip } else { [0.0; 3] };
        let shift = if seed < 12 { 0.3 } else { 1e-3 };
        let factor = factor(seed, centre, turn, shift);
        let offset = Point::new(
            0.4 * chance.normal(5),
            0.4 * chance.normal(6),
            4.0 + 0.4 * chance.normal(7),
        );
        let target = ct_from_tool * offset;
        let aim = |radius_mm: f64| Aim {
            stop_mm: 4.0,
            ..aim(target.mm(), radius_mm)
        };
        let says = |radius: f64| sight_of(ct_from_tool, &factor, &aim(radius)).verdict == Verdict::OnTarget;
        let (mut no, mut yes) = (1e-6, 9e5);
        if !says(yes) {
            continue;
        }
        for _ in 0..100 {
            let middle = 0.5 * (no + yes);
            if says(middle) { yes = middle } else { no = middle }
        }
        said += 1;
        let held = (0..DRAWS).filter(|&draw| {
            let aim = drawn(&ct_from_tool, &factor, draw) * Point::new(0.0, 0.0, 4.0);
            aim.distance(target) <= yes
        });
        let share = held.count() as f64 / DRAWS as f64;
        assert!(
            share > 0.949 - binomial(0.949),
            "{seed}: {share} within {yes} mm, turn {turn}, far {far}"
        );
    }
    assert!(said >= 20, "{said}");
}

/// First order alone would have said ON TARGET, and been wrong: turns about the aim of a degree, ten metres from the origin.
#[test]
fn on_target_does_not_rest_on_first_order_where_that_is_not_enough() {
    let tip = [6e3, -6.4e3, 4.8e3];
    let here = pose([0.2, 0.1, 0.0], tip);
    let sight = look(here, Covariance::Upper(about(tip, 0.02, 1e-3)), &aim(tip, 1.0)).unwrap();
    let predicted = sight.predicted.unwrap();
    assert!(sight.miss_length_mm + predicted.ball_95_mm < 0.1 && predicted.remainder_mm > 1.0);
    assert!(sight.verdict != Verdict::OnTarget, "{sight:?}");
}

/// Inside the cylinder of radius and depth, outside the ball: its corner is not the target.
#[test]
fn the_corner_of_the_cylinder_about_the_target_is_not_on_target() {
    let sight = look(
        pose([0.0; 3], [4.0, 0.0, 6.0]),
        Covariance::Exact,
        &aim([0.0, 0.0, 10.0], 5.0),
    )
    .unwrap();
    assert!(sight.miss_length_mm < 5.0 && sight.to_go_mm < 5.0);
    assert_eq!(sight.verdict, Verdict::OnCourse);
}

#[test]
fn an_unknown_error_is_never_on_target() {
    let here = || pose([0.0; 3], [0.0; 3]);
    let unknown = |covariance| {
        let sight = look(here(), covariance, &aim([0.0; 3], 50.0)).unwrap();
        assert_eq!(sight.verdict, Verdict::ErrorUnknown, "{covariance:?}");
        sight.predicted.unwrap_err()
    };
    assert_eq!(unknown(Covariance::Missing), Unknown::Missing);
    // A sample that has no covariance carries zeros; some carry a sign.
    assert_eq!(unknown(Covariance::Upper([0.0; 21])), Unknown::Zero);
    assert_eq!(unknown(Covariance::Upper([-0.0; 21])), Unknown::Zero);
    let good = about([0.0; 3], 1e-3, 0.3);
    for at in 0..21 {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300] {
            let mut upper = good;
            upper[at] = bad;
            unknown(Covariance::Upper(upper));
        }
    }
    // Variances of a metre squared a million times over, and such that squares overflow.
    for size in [1e7, 1e100, 1e150, 1e154, 1e160] {
        let reason = unknown(Covariance::Upper(about([0.0; 3], 1.0, size)));
        assert!(
            matches!(reason, Unknown::TooLarge | Unknown::NotACovariance(_)),
            "{size}: {reason}"
        );
    }
    // Not semidefinite: a correlation above 1.
    let mut skewed = good;
    skewed[16] = 2.0 * good[15];
    assert!(matches!(unknown(Covariance::Upper(skewed)), Unknown::NotACovariance(_)));
    assert_eq!(
        look(here(), Covariance::Upper(good), &aim([0.0; 3], 50.0))
            .unwrap()
            .verdict,
        Verdict::OnTarget
    );
}

#[test]
fn a_target_in_the_ellipse_is_within_error_and_one_beside_it_is_not() {
    // Errors of 1 mm alike in all directions: the ellipse is a circle of 2.4477 mm, larger than the target.
    let seen = |x: f64, z: f64| {
        let c = about([0.0; 3], 1e-9, 1.0);
        look(
            pose([0.0; 3], [x, 0.0, 0.0]),
            Covariance::Upper(c),
            &aim([0.0, 0.0, z], 1.0),
        )
        .unwrap()
        .verdict
    };
    assert_eq!(
        [seen(2.447, 9.0), seen(2.448, 9.0)],
        [Verdict::WithinError, Verdict::Steer]
    );
    assert_eq!(
        [seen(0.0, 0.0), seen(0.0, -0.99), seen(0.0, -1.01)],
        [Verdict::WithinError, Verdict::WithinError, Verdict::PastTarget]
    );
}

#[test]
fn words_and_shapes_tell_the_verdicts_apart() {
    for a in Verdict::ALL {
        for b in Verdict::ALL {
            assert_eq!(a == b, a.word() == b.word() && a.shape() == b.shape());
            assert!(a == b || (a.word() != b.word() && a.shape() != b.shape()));
        }
    }
}

proptest! {
    /// By other ways: the miss by the vector product, the error by the covariance of the place itself.
    #[test]
    fn on_target_never_where_the_true_sum_exceeds_the_radius(
        turn in prop::array::uniform3(-4.0..4.0), t in prop::array::uniform3(-400.0..400.0),
        off in prop::array::uniform3(-4.0..4.0), stop in 0.0..20.0, radius in 0.1..20.0,
        size in prop::sample::select(vec![1e-6, 1e-4, 1e-3, 1e-2]), shift in prop::sample::select(vec![1e-4, 0.1, 1.0, 5.0]),
        seed in 0_u64..1000,
    ) {
        let ct_from_tool = pose(turn, t);
        let target = ct_from_tool * Point::new(off[0], off[1], off[2] + stop);
        let factor = factor(seed, t, size, shift);
        let sight = sight_of(ct_from_tool, &factor, &Aim { stop_mm: stop, ..aim(target.mm(), radius) });
        let uncertain = Uncertain::new(ct_from_tool, factor * factor.transpose());
        let Ok(uncertain) = uncertain else { return Ok(()) };
        let error = (uncertain * (ct_from_tool.inverse() * target)).covariance();
        let axis = (ct_from_tool * geometry::Direction::<Tool>::Z).vector();
        let miss = (target - sight.tip).cross(axis).norm();
        // The variance across the axis that is largest, by a fan of directions.
        let worst = (0..180).map(|k| {
            let (sin, cos) = f64::from(k).to_radians().sin_cos();
            let d = nalgebra::Vector3::from((sight.right.vector() * cos + sight.up.vector() * sin).mm());
            d.dot(&(error * d))
        });
        let ellipse = (5.991_464 * worst.fold(0.0, f64::max)).sqrt();
        let to_go = (target - sight.tip).dot(axis) - stop;
        if sight.verdict == Verdict::OnTarget {
            prop_assert!(miss + ellipse <= radius + 1e-9 && to_go.abs() <= radius + 1e-9, "{sight:?}");
        }
        if matches!(sight.verdict, Verdict::OnTarget | Verdict::OnCourse) {
            prop_assert!(miss + ellipse <= radius + 1e-9, "{sight:?}");
        }
        // Growing the error never makes it good.
        let more = factor * 2.0;
        let grown = sight_of(ct_from_tool, &more, &Aim { stop_mm: stop, ..aim(target.mm(), radius) });
        prop_assert!(grown.verdict != Verdict::OnTarget || sight.verdict == Verdict::OnTarget);
    }
}
