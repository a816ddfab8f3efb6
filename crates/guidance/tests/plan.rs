//! The plan: what it accepts, changes and their taking back, its numbers, and what speaks against it.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use geometry::{Affine, Ct, Point, VolumeGrid};
use guidance::plan::{Concern, Confirmed, Edit, Editor, Measure, Plan, PlanError, Target, Trajectory, What, concerns};
use guidance::workflow::VolumeId;
use proptest::prelude::*;

fn p(x: f64, y: f64, z: f64) -> Point<Ct> {
    Point::new(x, y, z)
}

fn target(name: &str, centre: Point<Ct>, entry: Option<Point<Ct>>) -> Target {
    Target {
        name: name.to_owned(),
        centre,
        diameter_mm: 5.0,
        entry,
        stop_mm: 0.0,
    }
}

fn node() -> Target {
    target("node", p(0.0, 0.0, 0.0), Some(p(60.0, 80.0, 0.0)))
}

fn plan(targets: &[Target]) -> Plan {
    Plan {
        targets: targets.to_vec(),
        ..Plan::new(VolumeId([7; 32]))
    }
}

fn by_name() -> Confirmed {
    Confirmed {
        by: "Dr. A".to_owned(),
        at: "2026-11-25T12:00:00Z".to_owned(),
    }
}

#[test]
fn each_part_outside_its_domain_is_refused_by_name() {
    let with = |change: &dyn Fn(&mut Target)| {
        let mut changed = node();
        change(&mut changed);
        plan(&[changed]).checked().unwrap_err().to_string()
    };
    type Change<'a> = &'a dyn Fn(&mut Target);
    let cases: [(Change<'_>, &str); 14] = [
        (&|t| t.name = String::new(), "the target's name"),
        (&|t| t.name = " node".to_owned(), "the target's name"),
        (&|t| t.name = "a\nb".to_owned(), "the target's name"),
        (&|t| t.name = "é".repeat(21), "1 to 40 bytes"),
        (&|t| t.name = "a\u{200b}b".to_owned(), "the target's name"),
        (&|t| t.name = "\u{202e}ab".to_owned(), "the target's name"),
        (&|t| t.centre = p(f64::NAN, 0.0, 0.0), "centre of node: found NaN"),
        (&|t| t.centre = p(0.0, 1.1e4, 0.0), "centre of node: found 11000"),
        (
            &|t| t.entry = Some(p(0.0, 0.0, f64::INFINITY)),
            "entry of node: found inf",
        ),
        (
            &|t| t.diameter_mm = 0.0,
            "diameter of node: found 0; allowed: 0.1 to 200 mm",
        ),
        (&|t| t.diameter_mm = f64::NAN, "diameter of node: found NaN"),
        (
            &|t| t.stop_mm = -0.1,
            "stop distance of node: found -0.1; allowed: 0 to 500 mm",
        ),
        (&|t| t.entry = Some(t.centre), "its entry is 0.00 mm from its centre"),
        (
            &|t| t.stop_mm = 99.5,
            "its entry is 100.00 mm from its centre; the tube needs more than 100.5 mm",
        ),
    ];
    for (change, said) in cases {
        let found = with(change);
        assert!(found.contains(said), "{said:?}: {found}");
    }
    let twice = plan(&[node(), node()]).checked().unwrap_err();
    assert_eq!(twice, PlanError::NameTaken("node".to_owned()));
    let many: Vec<Target> = (0..65)
        .map(|i| target(&i.to_string(), p(0.0, 0.0, 0.0), None))
        .collect();
    assert!(
        plan(&many)
            .checked()
            .unwrap_err()
            .to_string()
            .contains("65 targets; at most 64")
    );
    let far = Measure::Distance([p(0.0, 0.0, 0.0), p(0.0, f64::NAN, 0.0)]);
    let measured = Plan {
        measures: vec![far],
        ..plan(&[])
    };
    assert!(measured.checked().unwrap_err().to_string().contains("a measured point"));
}

#[test]
fn a_confirmed_plan_changes_no_more() {
    let mut editor = Editor::new(plan(&[]));
    assert_eq!(editor.confirm(by_name()), Err(PlanError::NothingToConfirm));
    editor.edit(Edit::Add(node())).unwrap();
    let nobody = Confirmed {
        by: String::new(),
        ..by_name()
    };
    assert!(matches!(editor.confirm(nobody), Err(PlanError::Words { .. })));
    editor.confirm(by_name()).unwrap();
    let before = editor.clone();
    for edit in [
        Edit::Add(target("b", p(1.0, 1.0, 1.0), None)),
        Edit::Remove("node".to_owned()),
        Edit::Notes("x".to_owned()),
        Edit::Change("node".to_owned(), node()),
    ] {
        assert!(matches!(editor.edit(edit), Err(PlanError::Confirmed { .. })));
    }
    assert!(matches!(editor.undo(), Err(PlanError::Confirmed { .. })));
    assert!(matches!(editor.redo(), Err(PlanError::Confirmed { .. })));
    let said = editor.confirm(by_name()).unwrap_err().to_string();
    assert!(said.contains("confirmed by Dr. A at 2026-11-25"), "{said}");
    assert_eq!(editor, before);
}

#[test]
fn what_is_not_there_is_named_with_what_is() {
    let mut editor = Editor::new(plan(&[node()]));
    let said = editor.edit(Edit::Remove("Node".to_owned())).unwrap_err().to_string();
    assert!(said.contains("no target \"Node\"; there are node"), "{said}");
    let said = editor.edit(Edit::RemoveMeasure(0)).unwrap_err().to_string();
    assert!(said.contains("no measure 1; there are 0"), "{said}");
    assert_eq!(editor.undo(), Err(PlanError::NothingToUndo));
    assert_eq!(editor.redo(), Err(PlanError::NothingToRedo));
    // What changes nothing is nothing to be taken back.
    editor.edit(Edit::Change("node".to_owned(), node())).unwrap();
    assert_eq!(editor.depth(), [0, 0]);
}

fn edits() -> impl Strategy<Value = Edit> {
    let place = prop::array::uniform3(-200.0..200.0_f64);
    let name = "[a-d]";
    prop_oneof![
        (name, place.clone()).prop_map(|(n, [x, y, z])| Edit::Add(target(&n, p(x, y, z), None))),
        (name, name, place.clone())
            .prop_map(|(n, to, [x, y, z])| Edit::Change(n, target(&to, p(x, y, z), Some(p(0.0, 0.0, 300.0))))),
        name.prop_map(Edit::Remove),
        (place.clone(), place)
            .prop_map(|([a, b, c], [d, e, f])| Edit::Measure(Measure::Distance([p(a, b, c), p(d, e, f)]))),
        (0..3_usize).prop_map(Edit::RemoveMeasure),
        "[a-z]{0,3}".prop_map(Edit::Notes),
    ]
}

proptest! {
    /// Whatever was done, taking it back step by step gives each plan that there was, and doing it again the last.
    #[test]
    fn every_change_can_be_taken_back_and_made_again(edits in prop::collection::vec(edits(), 0..40)) {
        let mut editor = Editor::new(plan(&[]));
        let mut plans = vec![editor.plan().clone()];
        for edit in edits {
            let before = editor.plan().clone();
            match editor.edit(edit) {
                Ok(()) if *editor.plan() != before => plans.push(editor.plan().clone()),
                _ => prop_assert_eq!(editor.plan(), &before),
            }
            prop_assert!(editor.plan().clone().checked().is_ok());
        }
        let last = editor.plan().clone();
        for expected in plans.iter().rev().skip(1) {
            editor.undo().unwrap();
            prop_assert_eq!(editor.plan(), expected);
        }
        prop_assert_eq!(editor.undo(), Err(PlanError::NothingToUndo));
        for _ in 1..plans.len() {
            editor.redo().unwrap();
        }
        prop_assert_eq!(editor.plan(), &last);
        prop_assert_eq!(editor.redo(), Err(PlanError::NothingToRedo));
    }
}

#[test]
fn the_numbers_of_a_way_are_those_of_its_triangle() {
    let way = Trajectory::of(&Target {
        stop_mm: 10.0,
        ..node()
    })
    .unwrap();
    // 60-80-100: roundings of lengths of 100.
    assert!((way.depth_mm - 90.0).abs() < 1e-12 * 100.0);
    assert!(way.stop.distance(p(6.0, 8.0, 0.0)) < 1e-12 * 100.0);
    assert!(way.at(way.depth_mm).distance(way.stop) < 1e-12 * 100.0);
    assert_eq!(Trajectory::of(&target("free", p(0.0, 0.0, 0.0), None)), None);
}

/// LPS: +x is the patient's left, +y her back, +z her head.
#[test]
fn the_angles_of_a_way_are_to_the_patients_head_and_left() {
    let of = |entry| Trajectory::of(&target("n", p(0.0, 0.0, 0.0), Some(entry))).unwrap();
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    // Straight from front to back.
    let straight = of(p(0.0, -50.0, 0.0));
    near(straight.to_head_rad(), 0.0);
    near(straight.to_left_rad().unwrap(), 0.0);
    // From her right and front: towards her left.
    near(of(p(-50.0, -50.0, 0.0)).to_left_rad().unwrap(), FRAC_PI_4);
    // From her left and back, as a retroperitoneoscopy: towards her right and front.
    near(of(p(50.0, 50.0, 0.0)).to_left_rad().unwrap(), -3.0 * FRAC_PI_4);
    near(of(p(0.0, -50.0, -50.0)).to_head_rad(), FRAC_PI_4);
    near(of(p(0.0, -50.0, 50.0)).to_head_rad(), -FRAC_PI_4);
    // Along the body, where left and right mean nothing.
    near(of(p(0.0, 0.0, -50.0)).to_head_rad(), FRAC_PI_2);
    assert_eq!(of(p(0.0, 0.0, -50.0)).to_left_rad(), None);
}

#[test]
fn angles_are_exact_also_where_the_cosine_is_flat() {
    let origin = p(10.0, -20.0, 30.0);
    for exponent in 0..9 {
        let small = 10_f64.powi(-exponent);
        for angle in [small, PI - small] {
            let other = origin + (p(angle.cos(), angle.sin(), 0.0) - p(0.0, 0.0, 0.0)) * 100.0;
            let measure = Measure::Angle([origin + (p(50.0, 0.0, 0.0) - p(0.0, 0.0, 0.0)), origin, other]);
            // Coordinates of up to 130 mm are rounded to 1.5e-14, seen from 50 mm.
            assert!((measure.angle_rad().unwrap() - angle).abs() < 2e-15, "{angle}");
        }
    }
    assert_eq!(Measure::Angle([origin, origin, p(0.0, 0.0, 0.0)]).angle_rad(), None);
    let edge = Measure::Distance([p(0.0, 3.0, 0.0), p(4.0, 0.0, 0.0)]);
    assert_eq!((edge.distance_mm(), edge.angle_rad()), (Some(5.0), None));
}

/// 100 voxels of 1 mm along x and y, 50 of 2 mm along z, sheared as of a gantry that was tilted by atan(0.25).
fn grid() -> VolumeGrid {
    let rows = [[1.0, 0.0, 0.0, -50.0], [0.0, 1.0, 0.5, -50.0], [0.0, 0.0, 2.0, -50.0]];
    VolumeGrid::checked([100, 100, 50], Affine::from_rows(rows)).unwrap()
}

#[test]
fn what_lies_outside_the_ct_or_at_its_border_is_named() {
    let air = |_: Point<Ct>| Some(-1000);
    // Faces of y: the index y - z / 4 + 37.5 about, whose planes lie 1 / hypot(1, 0.25) mm apart.
    let grid = grid();
    let low = grid.ct_from_voxel() * Point::new(50.0, -0.5, 25.0);
    let inside = p(low.mm()[0], low.mm()[1] + 2.0, low.mm()[2]);
    let near = target("near", inside, None);
    let found = concerns(&plan(&[near]), &grid, &air);
    let [Concern::OnBorder { left_mm, radius_mm, .. }, Concern::NoEntry { .. }] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(*radius_mm, 2.5);
    assert!((left_mm - 2.0 / 1.0_f64.hypot(0.25)).abs() < 1e-12, "{left_mm}");
    let out = Plan {
        measures: vec![Measure::Distance([p(0.0, 0.0, 0.0), p(0.0, 0.0, 99.0)])],
        ..plan(&[target("out", p(500.0, 0.0, 0.0), Some(p(0.0, 0.0, -99.0)))])
    };
    let found = concerns(&out, &grid, &|p| grid.holds(p).then_some(-1000));
    let whats: Vec<What> = found
        .iter()
        .map(|concern| match concern {
            Concern::Outside { what, .. } => *what,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(whats, [What::Centre, What::Entry, What::Measure]);
    assert!(
        found[2].to_string().starts_with("distance 1: its measured point"),
        "{}",
        found[2]
    );
    // The ball just inside, and its centre outside by a hair.
    let whole = p(inside.mm()[0], inside.mm()[1] + 1.0, inside.mm()[2]);
    let found = concerns(&plan(&[target("whole", whole, None)]), &grid, &air);
    assert!(matches!(found[..], [Concern::NoEntry { .. }]), "{found:?}");
}

#[test]
fn bone_at_the_entry_and_on_the_way_is_told_with_its_place() {
    // A slab of bone for y from 20 to 24 mm, and a needle of it at the entry.
    let entry = p(0.0, 40.0, 0.0);
    let hu = |at: Point<Ct>| {
        let y = at.mm()[1];
        Some(if (20.0..=24.0).contains(&y) || at.distance(entry) < 0.3 {
            900
        } else {
            40
        })
    };
    let way = plan(&[target("n", p(0.0, 0.0, 0.0), Some(entry))]);
    let found = concerns(&way, &grid(), &hu);
    assert!(matches!(found[0], Concern::EntryInBone { hu: 900, .. }), "{found:?}");
    let parts = found[1..].iter().map(|concern| match concern {
        Concern::WayThroughBone {
            from_mm,
            to_mm,
            hu: 900,
            ..
        } => [*from_mm, *to_mm],
        other => panic!("{other:?}"),
    });
    // Two parts, and nothing said of the soft tissue between them. The way is looked at every 0.25 mm.
    let parts: Vec<[f64; 2]> = parts.collect();
    let expected = [[0.0, 0.3], [16.0, 20.0]];
    let is_near = |(a, b): (&[f64; 2], &[f64; 2])| (0..2).all(|k| (a[k] - b[k]).abs() <= 0.25);
    assert!(
        parts.len() == 2 && parts.iter().zip(&expected).all(is_near),
        "{parts:?}"
    );
    // A tube that stops before the slab does not meet it.
    let short = Target {
        stop_mm: 25.0,
        ..target("n", p(0.0, 0.0, 0.0), Some(p(0.0, 39.0, 0.0)))
    };
    assert_eq!(concerns(&plan(&[short]), &grid(), &hu), []);
}
