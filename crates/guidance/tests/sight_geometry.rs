//! Depth, miss, angle, sides, phases and refusals of the sight.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};

use geometry::{Ct, Direction, Point, Rigid, Tool, Vector};
use guidance::sight::{
    Aim, Covariance, Input, NoSight, Phase, Pose, Refused, SightAxes, Thresholds, ToolShape, Verdict, sight,
};
use proptest::prelude::*;
use support::{THRESHOLDS, TOOL, about, aim, look, pose, tool_axes};

fn numbers(size: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-size..size)
}

/// Every number of a sight that does not depend on where the origin of `Ct` is.
fn invariants(ct_from_tool: Rigid<Ct, Tool>, upper: [f64; 21], aim: &Aim) -> Vec<f64> {
    let sight = look(ct_from_tool, Covariance::Upper(upper), aim).unwrap();
    let (line, predicted) = (sight.line.unwrap(), sight.predicted.unwrap());
    let mut numbers = vec![sight.depth_mm, sight.to_go_mm, sight.miss_length_mm];
    numbers.extend(sight.miss_mm);
    numbers.extend(line.entry_mm);
    numbers.extend([line.angle_rad, line.entry_depth_mm, line.off_line_mm]);
    numbers.extend(predicted.ellipse.half_axes_mm);
    numbers.extend([predicted.along_95_mm, predicted.ball_95_mm]);
    numbers
}

proptest! {
    #[test]
    fn depth_and_miss_rebuild_the_target(
        turn in numbers(4.0), t in numbers(1e4), target in numbers(1e4), tip in numbers(300.0), axis in numbers(1.0),
    ) {
        let Some(axis) = Vector::<Tool>::new(axis[0], axis[1], axis[2]).direction() else { return Ok(()) };
        let ct_from_tool = pose(turn, t);
        let tool = ToolShape { tip_in_tool: Point::new(tip[0], tip[1], tip[2]), axis_in_tool: axis };
        let out = (ct_from_tool * axis).components();
        // Any two perpendicular directions, right-handed with the axis.
        let helper = if out[0].abs() < 0.8 { Vector::new(1.0, 0.0, 0.0) } else { Vector::new(0.0, 1.0, 0.0) };
        let into = (ct_from_tool * axis).vector();
        let right = helper.cross(into).direction().unwrap();
        let down = into.cross(right.vector()).direction().unwrap();
        let pose = Pose::<()>::Valid { ct_from_tool, covariance: Covariance::Missing };
        let s = sight(pose, &tool, &aim(target, 5.0), &SightAxes { right, down }, &THRESHOLDS).unwrap();
        let rebuilt = s.tip + s.axis * s.depth_mm + s.right * s.miss_mm[0] + s.up * s.miss_mm[1];
        prop_assert!(rebuilt.distance(Point::new(target[0], target[1], target[2])) < 1e-12 * 3e4);
        // By Pythagoras, knowing nothing of the sight's axes.
        let distance = s.tip.distance(Point::new(target[0], target[1], target[2]));
        prop_assert!((s.miss_length_mm.hypot(s.depth_mm) - distance).abs() < 1e-12 * 3e4);
        prop_assert_eq!(s.verdict, Verdict::ErrorUnknown);
    }

    /// Everything is moved: pose, covariance, target, entry. What is seen stays.
    #[test]
    fn a_rigid_motion_of_everything_changes_nothing(
        turn in numbers(4.0), t in numbers(300.0), target in numbers(300.0), entry in numbers(300.0),
        by_turn in numbers(4.0), by in numbers(300.0),
    ) {
        let moved: Rigid<Ct, Ct> = Rigid::from_rotation_vector(
            Vector::new(by_turn[0], by_turn[1], by_turn[2]), Vector::new(by[0], by[1], by[2])).unwrap();
        let there = |p: [f64; 3]| moved * Point::new(p[0], p[1], p[2]);
        let ct_from_tool = pose(turn, t);
        let here = Aim { entry: Some(Point::new(entry[0], entry[1], entry[2])), stop_mm: 3.0, ..aim(target, 5.0) };
        let gone = Aim { target: there(target), entry: Some(there(entry)), ..here };
        // Alike in all directions, so that the turn does not change it.
        let before = invariants(ct_from_tool, about(t, 0.01, 0.3), &here);
        let after = invariants(moved * ct_from_tool, about(there(t).mm(), 0.01, 0.3), &gone);
        for (a, b) in before.iter().zip(&after) {
            // Lengths below 1000 mm. Variances are what is left of 1e-4 x (1200 mm)^2: 1e-13 mm^2 at most in 0.5 mm^2 and more,
            // and by the lever of 64 eps more.
            prop_assert!((a - b).abs() < 1e-9, "{before:?} {after:?}");
        }
    }
}

/// The image across the tool as the perpendicular view makes it: `up` shows up, made perpendicular to the tool.
fn perpendicular(ct_from_tool: &Rigid<Ct, Tool>, wanted: Direction<Ct>) -> SightAxes {
    let into = *ct_from_tool * Direction::<Tool>::Z;
    let up = (wanted.vector() - into * wanted.dot(into)).direction().unwrap();
    let right = (-up).cross(into).direction().unwrap();
    let down = into.cross(right).direction().unwrap();
    SightAxes { right, down }
}

/// The letter at the right edge of an image, of the six directions the nearest.
fn letter(right: Direction<Ct>) -> char {
    let c = right.components();
    let k = (0..3).max_by(|&a, &b| c[a].abs().total_cmp(&c[b].abs())).unwrap();
    [['L', 'R'], ['P', 'A'], ['S', 'I']][k][usize::from(c[k] < 0.0)]
}

#[test]
fn a_target_on_the_patients_left_is_on_the_side_of_the_letter_l() {
    // Towards the back, towards the front, towards the feet and obliquely.
    for turn in [
        [-FRAC_PI_2, 0.0, 0.0],
        [FRAC_PI_2, 0.0, 0.0],
        [PI, 0.0, 0.0],
        [-2.0, 0.1, -0.1],
    ] {
        let tip = [3.0, -40.0, 90.0];
        let ct_from_tool = pose(turn, tip);
        let up = if turn[0] == PI { -Direction::Y } else { Direction::Z };
        let axes = perpendicular(&ct_from_tool, up);
        let into = (ct_from_tool * Direction::<Tool>::Z).vector().mm();
        // 60 mm ahead, 10 mm to the patient's left: +x.
        let target = [0, 1, 2].map(|k| tip[k] + 60.0 * into[k] + if k == 0 { 10.0 } else { 0.0 });
        let pose = Pose::<()>::Valid {
            ct_from_tool,
            covariance: Covariance::Missing,
        };
        let s = sight(pose, &TOOL, &aim(target, 5.0), &axes, &THRESHOLDS).unwrap();
        let l_is_right = match letter(axes.right) {
            'L' => true,
            'R' => false,
            other => panic!("{other}"),
        };
        assert_eq!(s.miss_mm[0] > 0.0, l_is_right, "{turn:?} {:?}", s.miss_mm);
        assert!(s.miss_mm[0].abs() > 9.0);
        // And where the image itself draws it.
        let plane = geometry::SlicePlane::centred(s.tip, [axes.right, axes.down], 0.5, [201, 201]).unwrap();
        let drawn = plane.project(Point::new(target[0], target[1], target[2]));
        assert!((drawn.x - 100.0 - s.miss_mm[0] / 0.5).abs() < 1e-9);
        assert!((100.0 - drawn.y - s.miss_mm[1] / 0.5).abs() < 1e-9);
        assert!((drawn.depth_mm - s.depth_mm).abs() < 1e-9);
    }
    // Towards the back with the head up one stands in front of the patient: her left is on the right.
    let back = pose([-FRAC_PI_2, 0.0, 0.0], [0.0; 3]);
    assert!((back * Direction::<Tool>::Z).components()[1] > 0.99);
    assert_eq!(letter(perpendicular(&back, Direction::Z).right), 'L');
}

/// Along +z with the sight's right -x and up +y: by hand.
#[test]
fn signs_are_as_stated() {
    let s = look(
        pose([0.0; 3], [0.0; 3]),
        Covariance::Exact,
        &Aim {
            stop_mm: 4.0,
            ..aim([-2.0, 3.0, 10.0], 5.0)
        },
    )
    .unwrap();
    assert_eq!((s.depth_mm, s.to_go_mm, s.miss_mm), (10.0, 6.0, [2.0, 3.0]));
    let past = look(
        pose([0.0; 3], [0.0, 0.0, 12.0]),
        Covariance::Exact,
        &aim([0.0, 0.0, 10.0], 1.0),
    )
    .unwrap();
    assert_eq!((past.depth_mm, past.verdict), (-2.0, Verdict::PastTarget));
    let beside = look(
        pose([0.0; 3], [7.0, 0.0, 10.0]),
        Covariance::Exact,
        &aim([0.0, 0.0, 10.0], 1.0),
    )
    .unwrap();
    assert_eq!((beside.depth_mm, beside.miss_mm), (0.0, [7.0, 0.0]));
}

#[test]
fn the_ends_of_the_domain_have_a_sight() {
    // The tip at the target, the axis through it, the target behind, and all of it 10 m away.
    for far in [0.0, 1e4, -1e4] {
        let at = |z: f64| {
            look(
                pose([0.0; 3], [far, far, far]),
                Covariance::Exact,
                &aim([far, far, far + z], 2.0),
            )
            .unwrap()
        };
        let here = at(0.0);
        assert_eq!(
            (here.depth_mm, here.miss_mm, here.verdict),
            (0.0, [0.0; 2], Verdict::OnTarget)
        );
        assert_eq!((at(50.0).miss_length_mm, at(50.0).verdict), (0.0, Verdict::OnCourse));
        assert_eq!((at(-50.0).depth_mm, at(-50.0).verdict), (-50.0, Verdict::PastTarget));
        assert_eq!(
            (at(-50.0).phase, at(50.0).phase, here.phase),
            (Phase::Align, Phase::Advance, Phase::Advance)
        );
    }
}

#[test]
fn phases_follow_the_thresholds() {
    let planned = Aim {
        entry: Some(Point::new(0.0, 0.0, 0.0)),
        ..aim([0.0, 0.0, 90.0], 5.0)
    };
    let phase = |turn: f64, t: [f64; 3]| look(pose([turn, 0.0, 0.0], t), Covariance::Missing, &planned).unwrap();
    assert_eq!(phase(0.0, [0.0, 0.0, -5.01]).phase, Phase::FindEntry);
    assert_eq!(phase(0.0, [0.0, 0.0, -5.0]).phase, Phase::Advance);
    assert_eq!(phase(0.0501, [0.0, 0.0, -5.0]).phase, Phase::Align);
    assert_eq!(phase(0.0499, [0.0, 0.0, 0.0]).phase, Phase::Advance);
    // Deeper than the entry, but beside the planned way.
    assert_eq!(phase(0.0, [5.01, 0.0, 40.0]).phase, Phase::FindEntry);
    assert_eq!(phase(0.0, [3.0, -4.0, 40.0]).phase, Phase::Advance);
    let line = phase(0.3, [3.0, 4.0, 40.0]).line.unwrap();
    assert!((line.angle_rad - 0.3).abs() < 1e-15 && (line.off_line_mm - 5.0).abs() < 1e-14);
    assert!((phase(PI, [0.0; 3]).line.unwrap().angle_rad - PI).abs() < 1e-15);
    // An angle whose cosine is 1 to the last digit.
    assert!((phase(1e-9, [0.0; 3]).line.unwrap().angle_rad - 1e-9).abs() < 1e-15);
}

#[test]
fn an_entry_at_the_target_is_refused() {
    for off in [0.0, 1e-4] {
        let aim = Aim {
            entry: Some(Point::new(1.0, 2.0, 3.0 + off)),
            ..aim([1.0, 2.0, 3.0], 5.0)
        };
        let refused = look(pose([0.0; 3], [0.0; 3]), Covariance::Exact, &aim).unwrap_err();
        assert!(matches!(refused, Refused::EntryIsTarget { .. }), "{refused}");
    }
}

#[test]
fn a_pose_that_is_lost_gives_its_reason_and_no_sight() {
    let axes = tool_axes(&Rigid::identity());
    let lost = sight(
        Pose::Lost("line of sight"),
        &TOOL,
        &aim([0.0; 3], 1.0),
        &axes,
        &THRESHOLDS,
    )
    .unwrap_err();
    assert_eq!(lost, NoSight::Lost("line of sight"));
    assert_eq!(lost.to_string(), "no sight: line of sight");
}

#[test]
fn axes_that_are_mirrored_or_of_another_pose_are_refused() {
    let ct_from_tool = pose([0.3, 0.2, 0.1], [1.0; 3]);
    let good = tool_axes(&ct_from_tool);
    let with = |axes: SightAxes| {
        let pose = Pose::<()>::Valid {
            ct_from_tool,
            covariance: Covariance::Exact,
        };
        sight(pose, &TOOL, &aim([1.0, 2.0, 30.0], 5.0), &axes, &THRESHOLDS)
    };
    assert!(with(good).is_ok());
    let mirrored = SightAxes {
        right: -good.right,
        down: good.down,
    };
    assert_eq!(with(mirrored), Err(NoSight::Refused(Refused::Mirrored)));
    let other = tool_axes(&pose([0.3, 0.2001, 0.1], [1.0; 3]));
    assert!(matches!(with(other), Err(NoSight::Refused(Refused::Skewed { .. }))));
    let alike = SightAxes {
        right: good.right,
        down: good.right,
    };
    assert!(matches!(with(alike), Err(NoSight::Refused(Refused::Skewed { .. }))));
}

/// One bad number at a time, in each place that takes one.
#[test]
fn what_is_no_number_or_out_of_its_domain_is_refused_by_name() {
    let tool = TOOL;
    let planned = Aim {
        entry: Some(Point::new(0.0, 0.0, -50.0)),
        ..aim([0.0; 3], 5.0)
    };
    let refused = |ct_from_tool, tool, aim, thresholds| {
        let axes = tool_axes(&Rigid::identity());
        let pose = Pose::<()>::Valid {
            ct_from_tool,
            covariance: Covariance::Exact,
        };
        match sight(pose, &tool, &aim, &axes, &thresholds) {
            Err(NoSight::Refused(Refused::NotFinite { what, .. } | Refused::OutOfRange { what, .. })) => what,
            other => panic!("{other:?}"),
        }
    };
    let here = Rigid::identity();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e6, -1e300] {
        let far = Rigid::from_parts(here.rotation(), Vector::new(0.0, bad, 0.0));
        assert_eq!(refused(far, tool, planned, THRESHOLDS), Input::Pose);
        let tip = ToolShape {
            tip_in_tool: Point::new(bad, 0.0, 0.0),
            ..tool
        };
        assert_eq!(refused(here, tip, planned, THRESHOLDS), Input::Tip);
        let target = Aim {
            target: Point::new(0.0, 0.0, bad),
            ..planned
        };
        assert_eq!(refused(here, tool, target, THRESHOLDS), Input::Target);
        let entry = Aim {
            entry: Some(Point::new(0.0, bad, 0.0)),
            ..planned
        };
        assert_eq!(refused(here, tool, entry, THRESHOLDS), Input::Entry);
        assert_eq!(
            refused(
                here,
                tool,
                Aim {
                    radius_mm: bad,
                    ..planned
                },
                THRESHOLDS
            ),
            Input::Radius
        );
        assert_eq!(
            refused(
                here,
                tool,
                Aim {
                    stop_mm: bad,
                    ..planned
                },
                THRESHOLDS
            ),
            Input::Stop
        );
        let corridor = Thresholds {
            corridor_mm: bad,
            ..THRESHOLDS
        };
        assert_eq!(refused(here, tool, planned, corridor), Input::Corridor);
        let align = Thresholds {
            align_rad: bad,
            ..THRESHOLDS
        };
        assert_eq!(refused(here, tool, planned, align), Input::Align);
    }
    for bad in [0.0, -0.0, -1.0] {
        assert_eq!(
            refused(
                here,
                tool,
                Aim {
                    radius_mm: bad,
                    ..planned
                },
                THRESHOLDS
            ),
            Input::Radius
        );
    }
    assert_eq!(
        refused(
            here,
            tool,
            Aim {
                stop_mm: -0.1,
                ..planned
            },
            THRESHOLDS
        ),
        Input::Stop
    );
}
