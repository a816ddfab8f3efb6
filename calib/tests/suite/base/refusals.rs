//! What gives no place is refused by name, with its numbers.

use super::*;
use crate::common::plate::{plate, radial};
use calib::base::{Drawing, Groove, Refused};
use geometry::Direction;

fn touched(drawing: &Drawing, seed: u64) -> Vec<Group<Tracker>> {
    let mut random = Random::new(seed);
    let truth = pose(&mut random);
    let touching = Touching {
        drawing,
        tip_radius: 0.0,
        sigma: SIGMA,
        counts: [20, 10],
    };
    touching.groups(&mut random, truth)
}

/// A groove along x at `y`.
fn along_x(y: f64) -> Groove {
    Groove {
        start: Point::new(-40.0, y, -4.0),
        end: Point::new(40.0, y, -4.0),
        half_angle_rad: 0.8,
    }
}

#[test]
fn three_parallel_grooves_leave_the_slide_along_them() {
    let refused = plate([-40.0, 0.0, 40.0].map(along_x)).unwrap_err();
    let Refused::Unsolvable { free, condition, .. } = refused else {
        panic!("{refused}")
    };
    assert!(
        free.shift[0].abs() > 1.0 - 1e-12 && condition > 1e7,
        "{free:?} {condition}"
    );
    let refused = plate([-40.0, 0.0, 40.0].map(along_x)).unwrap_err().to_string();
    assert!(refused.contains("slide along ("), "{refused}");
    // Two parallel and one across hold it; so does the third a little turned, but badly.
    let across = Groove {
        start: Point::new(0.0, -30.0, -4.0),
        end: Point::new(0.0, 30.0, -4.0),
        half_angle_rad: 0.8,
    };
    assert!(plate([along_x(-40.0), across, along_x(40.0)]).is_ok());
    let turned = |angle: f64| Groove {
        end: Point::new(-40.0 + 80.0 * angle.cos(), 80.0 * angle.sin(), -4.0),
        ..along_x(0.0)
    };
    assert!(plate([along_x(-40.0), turned(0.02), along_x(40.0)]).is_ok());
    assert!(matches!(
        plate([along_x(-40.0), turned(1e-5), along_x(40.0)]),
        Err(Refused::Unsolvable { .. })
    ));
    let weak = plate([along_x(-40.0), turned(0.02), along_x(40.0)]).unwrap();
    let refused = locate(&weak, &touched(&weak, 1), &Options::new(SIGMA)).unwrap_err();
    assert!(
        matches!(refused, Refused::Unsolvable { free, .. } if free.shift[0].abs() > 0.99),
        "{refused}"
    );
}

#[test]
fn a_star_without_labels_is_ambiguous() {
    let drawing = star();
    let groups = touched(&drawing, 2);
    let refused = locate(&drawing, &unlabelled(&groups), &Options::new(SIGMA)).unwrap_err();
    let Refused::Ambiguous {
        assignments, apart_mm, ..
    } = &refused
    else {
        panic!("{refused}")
    };
    // A third of a turn moves the ends, 60 mm out, by 104 mm.
    assert!((apart_mm - 60.0 * 3.0_f64.sqrt()).abs() < 1.0, "{refused}");
    assert_ne!(assignments[0], assignments[1]);
    // One label decides it.
    let mut one = unlabelled(&groups);
    one[2].feature = Some(Feature::Groove(1));
    let found = locate(&drawing, &one, &Options::new(SIGMA)).unwrap();
    assert_eq!(found.assignment, Feature::ALL);
}

/// Grooves of a plate are few: with a noise told large enough some of its places lie beside the touches' mirror image, and were accepted.
#[test]
fn mirrored_touches_are_refused() {
    let drawing = uneven();
    let mut mirrored = 0;
    for seed in 0..6 {
        for (axis, told) in [(0, 1.0), (0, 4.0), (1, 8.0), (2, 8.0)] {
            let mut groups = touched(&drawing, seed);
            let right = locate(&drawing, &unlabelled(&groups), &Options::new(told * SIGMA));
            // Nothing is said of those that are right but that two places fit, where so much noise is told.
            assert!(
                matches!(right, Ok(_) | Err(Refused::Ambiguous { .. })),
                "{seed} {told}: {:?}",
                right.err()
            );
            for touch in groups.iter_mut().flat_map(|g| &mut g.touches) {
                let mut mm = touch.mm();
                mm[axis] = -mm[axis];
                *touch = Point::new(mm[0], mm[1], mm[2]);
            }
            let refused = locate(&drawing, &unlabelled(&groups), &Options::new(told * SIGMA)).unwrap_err();
            mirrored += usize::from(matches!(refused, Refused::Mirrored { .. }));
        }
    }
    assert!(mirrored > 0);
}

/// Dirt of 1 mm in a groove was accepted in 100 of 100 runs, with 0.22 mm stated at the seat and 0.73 true; a ball of 1 mm that nobody told of in 50 of 50.
#[test]
fn a_feature_that_is_off_as_a_whole_is_named() {
    let drawing = uneven();
    let touching = |tip_radius: f64| Touching {
        drawing: &drawing,
        tip_radius,
        sigma: SIGMA,
        counts: [40, 40],
    };
    let mut dirty = 0;
    for seed in 0..20 {
        let mut random = Random::new(500 + seed);
        let truth = pose(&mut random);
        let mut groups = touching(0.0).groups(&mut random, truth);
        assert!(locate(&drawing, &groups, &Options::new(SIGMA)).is_ok(), "{seed}");
        let ball = touching(1.0).groups(&mut random, truth);
        let refused = locate(&drawing, &ball, &Options::new(SIGMA)).unwrap_err();
        assert!(matches!(refused, Refused::OneSide { .. }), "{seed}: {refused}");
        let up = truth * Point::new(0.0, 0.0, 1.0) - truth * Point::new(0.0, 0.0, 0.0);
        groups[1].touches.iter_mut().for_each(|touch| *touch = *touch + up);
        let refused = locate(&drawing, &groups, &Options::new(SIGMA));
        dirty += usize::from(matches!(refused, Err(Refused::OneSide { .. })));
    }
    assert_eq!(dirty, 20);
}

#[test]
fn touched_in_the_wrong_order() {
    let drawing = uneven();
    let mut groups = touched(&drawing, 3);
    (groups[1].feature, groups[2].feature) = (groups[2].feature, groups[1].feature);
    let refused = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap_err();
    let Refused::WrongOrder { said, found } = &refused else {
        panic!("{refused}")
    };
    let g = Feature::Groove;
    assert_eq!(*said, [Feature::Plane, g(1), g(0), g(2)]);
    assert_eq!(*found, Feature::ALL);
    assert!(
        refused
            .to_string()
            .contains("fit (plane, groove 0, groove 1, groove 2)"),
        "{refused}"
    );
    // The plane taken for a groove.
    let mut groups = touched(&drawing, 4);
    (groups[0].feature, groups[3].feature) = (groups[3].feature, groups[0].feature);
    let refused = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap_err();
    assert!(matches!(refused, Refused::WrongOrder { .. }), "{refused}");
}

#[test]
fn another_base_does_not_fit() {
    let groups = touched(&plate([0.0, 90.0, 200.0].map(|a| radial(a, 15.0, 60.0))).unwrap(), 5);
    let refused = locate(&uneven(), &groups, &Options::new(SIGMA)).unwrap_err();
    assert!(
        matches!(refused, Refused::NoFit { rejected, touches: 50, .. } if rejected > 10),
        "{refused}"
    );
    let mirrored: Vec<Group<Tracker>> = touched(&uneven(), 6)
        .into_iter()
        .map(|g| Group {
            touches: g
                .touches
                .iter()
                .map(|p| Point::new(-p.mm()[0], p.mm()[1], p.mm()[2]))
                .collect(),
            ..g
        })
        .collect();
    let refused = locate(&uneven(), &mirrored, &Options::new(SIGMA)).unwrap_err();
    assert!(
        matches!(refused, Refused::NoFit { noise_ratio, .. } if noise_ratio > 2.0),
        "{refused}"
    );
}

#[test]
fn bad_drawings() {
    let good = [0.0, 120.0, 240.0].map(|a| radial(a, 15.0, 60.0));
    let with = |groove: Groove| plate([good[0], groove, good[2]]).unwrap_err();
    for half_angle_rad in [0.0, -0.5, 1.6] {
        let refused = with(Groove {
            half_angle_rad,
            ..good[1]
        });
        assert!(matches!(refused, Refused::BadGroove { groove: 1, .. }), "{refused}");
    }
    let point = with(Groove {
        end: good[1].start,
        ..good[1]
    });
    assert!(
        matches!(
            point,
            Refused::BadGroove {
                groove: 1,
                length_mm: 0.0,
                ..
            }
        ),
        "{point}"
    );
    let [x, y, _] = good[1].start.mm();
    let upright = with(Groove {
        end: Point::new(x, y, 30.0),
        ..good[1]
    });
    assert!(
        matches!(
            upright,
            Refused::BadGroove {
                groove: 1,
                to_normal_rad: 0.0,
                ..
            }
        ),
        "{upright}"
    );
    let nan = with(Groove {
        end: Point::new(x, f64::NAN, 30.0),
        ..good[1]
    });
    assert_eq!(nan, Refused::DrawingNotFinite(Feature::Groove(1)));
    let nowhere = Drawing::new(Point::new(0.0, 0.0, f64::INFINITY), Direction::Z, good).unwrap_err();
    assert_eq!(nowhere, Refused::DrawingNotFinite(Feature::Plane));
}

#[test]
fn bad_touches_and_options() {
    let drawing = uneven();
    let groups = touched(&drawing, 7);
    let refusal = |groups: &[Group<Tracker>]| locate(&drawing, groups, &Options::new(SIGMA)).unwrap_err();
    assert_eq!(refusal(&groups[..3]), Refused::GroupCount { found: 3, most: 7 });
    let mut few = groups.clone();
    few[0].touches.truncate(2);
    assert_eq!(
        refusal(&few),
        Refused::TooFew {
            group: 0,
            found: 2,
            needed: 3
        }
    );
    let mut bad = groups.clone();
    bad[2].touches[4] = Point::new(0.0, f64::NAN, 0.0);
    assert!(matches!(refusal(&bad), Refused::NotFinite { group: 2, touch: 4, .. }));
    let mut bad = groups.clone();
    bad[2].feature = Some(Feature::Groove(3));
    assert_eq!(refusal(&bad), Refused::NoSuchGroove { group: 2, groove: 3 });
    // The plane touched along a line only.
    let mut line = groups.clone();
    let (a, b) = (line[0].touches[0], line[0].touches[1]);
    line[0].touches = (0..20).map(|i| a.lerp(b, f64::from(i) / 20.0)).collect();
    assert!(matches!(refusal(&line), Refused::NoFit { .. }), "{}", refusal(&line));
    for sigma in [0.0, -1.0, f64::NAN] {
        let refused = locate(&drawing, &groups, &Options::new(sigma)).unwrap_err();
        assert!(
            matches!(refused, Refused::BadOption { what: "the noise", .. }),
            "{refused}"
        );
    }
    let few: Vec<Point<Tracker>> = groups[0].touches[..3].to_vec();
    assert!(matches!(separate(&few, 1.2), Err(Refused::NoLine { touches: 3, .. })));
}
