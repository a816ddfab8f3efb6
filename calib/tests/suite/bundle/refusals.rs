//! What gives no marker is refused by name.

use super::*;
use nalgebra::Matrix3;

fn planted(seed: u64, views: usize) -> (Vec<Point<Marker>>, Vec<View>) {
    let truth = ball(24, 30.0);
    let mut random = Random::new(seed);
    let poses = poses(&mut random, views);
    let views = seen(&mut random, &truth, &poses, [SIGMA; 3]);
    (truth, views)
}

/// Exchanges two numbers in a view; false where it does not see both.
fn exchange(view: &mut View, i: usize, j: usize) -> bool {
    let at = |e: usize| view.iter().position(|s| s.0 == e);
    let (Some(a), Some(b)) = (at(i), at(j)) else {
        return false;
    };
    (view[a].0, view[b].0) = (j, i);
    true
}

#[test]
fn exchanged_emitters_are_named() {
    for seed in 0..10 {
        for count in [20, 50, 100] {
            let (_, mut views) = planted(300 + seed, count);
            if calibrate(&views, 24, &options()).is_err() {
                continue;
            }
            // The view with the most emitters is where the chain begins.
            let k = (0..count).max_by_key(|k| views[*k].len()).unwrap();
            let (i, j) = (views[k][0].0, views[k][3].0);
            assert!(exchange(&mut views[k], i, j));
            let refused = calibrate(&views, 24, &options()).unwrap_err();
            let Refused::Mislabelled(list) = &refused else {
                panic!("seed {seed}, {count} views: {refused}")
            };
            let mut named: Vec<_> = list.iter().map(|m| (m.emitter, m.seems, m.views.clone())).collect();
            named.sort_unstable();
            let mut expected = vec![(i, j, vec![k]), (j, i, vec![k])];
            expected.sort_unstable();
            assert_eq!(named, expected, "seed {seed}, {count} views: {refused}");
        }
    }
}

#[test]
fn exchanged_in_a_third_of_the_views() {
    let (_, mut views) = planted(41, 120);
    let mut hit = Vec::new();
    for (k, view) in views.iter_mut().enumerate().step_by(3) {
        if hit.len() < 12 && exchange(view, 4, 9) {
            hit.push(k);
        }
    }
    assert!(hit.len() >= 3, "{hit:?}");
    let refused = calibrate(&views, 24, &options()).unwrap_err();
    let Refused::Mislabelled(list) = &refused else {
        panic!("{refused}")
    };
    let named: Vec<_> = list.iter().map(|m| (m.emitter, m.seems, m.views.clone())).collect();
    assert_eq!(named, [(4, 9, hit.clone()), (9, 4, hit)], "{refused}");
    assert!(
        refused.to_string().contains("emitter 4 is at the place of emitter 9"),
        "{refused}"
    );
}

#[test]
fn exchanged_where_no_majority_can_tell() {
    let truth = [
        [0.0, 0.0, 0.0],
        [70.0, 5.0, 0.0],
        [10.0, 50.0, 8.0],
        [-40.0, 20.0, -15.0],
    ];
    let truth = truth.map(|[x, y, z]| Point::<Marker>::new(x, y, z));
    let mut random = Random::new(90);
    let poses = poses(&mut random, 20);
    let view = |p: &geometry::Rigid<Tracker, Marker>| -> View { truth.iter().map(|b| *p * *b).enumerate().collect() };
    let views: Vec<View> = poses.iter().map(view).collect();
    // In any view, the one where the chain begins too.
    for k in [0, 7, 19] {
        for (i, j) in [(0, 1), (0, 3), (2, 3)] {
            let mut views = views.clone();
            assert!(exchange(&mut views[k], i, j));
            let refused = calibrate(&views, 4, &options()).unwrap_err();
            let Refused::Mislabelled(list) = &refused else {
                panic!("{refused}")
            };
            let named: Vec<_> = list.iter().map(|m| (m.emitter, m.seems, m.views.clone())).collect();
            assert_eq!(named, [(i, j, vec![k]), (j, i, vec![k])], "{refused}");
        }
    }
}

#[test]
fn exchanged_in_every_view_is_told_by_the_drawing() {
    let (truth, mut views) = planted(42, 100);
    for view in &mut views {
        for s in view.iter_mut() {
            s.0 = match s.0 {
                4 => 9,
                9 => 4,
                e => e,
            };
        }
    }
    // Without a drawing it is a marker with these numbers.
    assert!(calibrate(&views, 24, &options()).is_ok());
    let drawn = Options {
        gauge: Gauge::Design {
            places: truth.iter().map(|p| Some(*p)).collect(),
            tolerance_mm: 1.0,
        },
        ..options()
    };
    let refused = calibrate(&views, 24, &drawn).unwrap_err();
    let Refused::Mislabelled(list) = &refused else {
        panic!("{refused}")
    };
    assert_eq!(
        list.iter().map(|m| (m.emitter, m.seems)).collect::<Vec<_>>(),
        [(4, 9), (9, 4)]
    );
}

fn mirror(view: &mut View) {
    for s in view.iter_mut() {
        let [x, y, z] = s.1.mm();
        s.1 = Point::new(-x, y, z);
    }
}

#[test]
fn mirrored_views_are_named_and_a_mirrored_marker_is_told_by_the_drawing() {
    let (truth, views) = planted(43, 60);
    let mut some = views.clone();
    some[7..12].iter_mut().for_each(mirror);
    let refused = calibrate(&some, 24, &options()).unwrap_err();
    assert_eq!(
        refused,
        Refused::Mirrored {
            views: (7..12).collect(),
            of: 60
        },
        "{refused}"
    );
    let mut all = views;
    all.iter_mut().for_each(mirror);
    assert!(calibrate(&all, 24, &options()).is_ok());
    let drawn = Options {
        gauge: Gauge::Design {
            places: truth.iter().map(|p| Some(*p)).collect(),
            tolerance_mm: 1.0,
        },
        ..options()
    };
    let refused = calibrate(&all, 24, &drawn).unwrap_err();
    assert!(
        matches!(refused, Refused::MirroredDesign { mirrored_mm, .. } if mirrored_mm < 0.2),
        "{refused}"
    );
}

#[test]
fn views_that_do_not_hang_together() {
    let (_, views) = planted(44, 80);
    // Two halves of the ball that never share three emitters: 0 to 12 and 11 to 23.
    let half = |k: usize, e: usize| if k.is_multiple_of(2) { e <= 12 } else { e >= 11 };
    let split: Vec<View> = views
        .iter()
        .enumerate()
        .map(|(k, v)| v.iter().copied().filter(|s| half(k, s.0)).collect())
        .collect();
    let refused = calibrate(&split, 24, &options()).unwrap_err();
    let Refused::Unconnected { bodies } = &refused else {
        panic!("{refused}")
    };
    let mut sorted = bodies.clone();
    sorted.sort();
    assert_eq!(sorted, [(0..=12).collect::<Vec<_>>(), (11..24).collect()], "{refused}");
}

#[test]
fn a_marker_that_bends() {
    let (truth, _) = planted(45, 1);
    let mut random = Random::new(46);
    let poses = poses(&mut random, 40);
    let mut views = Vec::new();
    for (k, pose) in poses.iter().enumerate() {
        // In every second view the ball is a tenth larger.
        let size = if k.is_multiple_of(2) { 1.0 } else { 1.1 };
        let grown: Vec<Point<Marker>> = truth
            .iter()
            .map(|p| {
                let [x, y, z] = p.mm();
                Point::new(x * size, y * size, z * size)
            })
            .collect();
        views.extend(seen(&mut random, &grown, &[*pose], [SIGMA; 3]));
    }
    let refused = calibrate(&views, 24, &options()).unwrap_err();
    let named = matches!(refused, Refused::Inconsistent { .. } | Refused::Outliers { .. });
    assert!(named, "{refused}");
}

#[test]
fn seldom_seen_emitters() {
    let (_, mut views) = planted(47, 60);
    for view in &mut views {
        view.retain(|s| s.0 != 5);
    }
    let mut seen = 0_usize;
    for view in &mut views {
        seen += view.iter().filter(|s| s.0 == 6).count();
        view.retain(|s| s.0 != 6 || seen <= 2);
    }
    let refused = calibrate(&views, 24, &options()).unwrap_err();
    assert_eq!(
        refused,
        Refused::Seldom {
            emitters: vec![(5, 0), (6, 2)],
            needed: 3
        }
    );
    let lenient = Options {
        allow_missing: true,
        ..options()
    };
    let found = calibrate(&views, 24, &lenient).unwrap();
    let missing: Vec<usize> = (0..24).filter(|i| found.emitters[*i].is_none()).collect();
    assert_eq!(missing, [5, 6]);
    assert!(found.covariance_of(5).is_none() && found.covariance_of(7).is_some() && found.residuals[6].is_none());
}

#[test]
fn lines_and_bad_numbers() {
    let line: Vec<Point<Marker>> = (0..4).map(|i| Point::new(0.1, 0.2, 20.0 * f64::from(i))).collect();
    let mut random = Random::new(48);
    let poses = poses(&mut random, 10);
    let views: Vec<View> = poses
        .iter()
        .map(|p| line.iter().enumerate().map(|(i, b)| (i, *p * *b)).collect())
        .collect();
    let lenient = Options {
        allow_missing: true,
        ..options()
    };
    let refused = calibrate(&views, 4, &lenient).unwrap_err();
    assert!(
        matches!(refused, Refused::Collinear { widest_mm, .. } if widest_mm < 1e-4),
        "{refused}"
    );
    let refused = calibrate(&[], 4, &lenient).unwrap_err();
    assert!(matches!(refused, Refused::Collinear { views: 0, .. }), "{refused}");
    let (_, good) = planted(49, 40);
    let mut bad = good.clone();
    bad[3][1].1 = Point::new(1.0, f64::NAN, 0.0);
    assert!(matches!(
        calibrate(&bad, 24, &options()),
        Err(Refused::NotFinite { view: 3, .. })
    ));
    let mut bad = good.clone();
    bad[2][1].0 = bad[2][0].0;
    assert!(matches!(
        calibrate(&bad, 24, &options()),
        Err(Refused::Twice { view: 2, .. })
    ));
    assert!(matches!(
        calibrate(&good, 20, &options()),
        Err(Refused::NoSuchEmitter { emitters: 20, .. })
    ));
    for sigma_mm in [0.0, f64::NAN, f64::INFINITY] {
        let noise = Localizer::Isotropic { sigma_mm };
        let refused = calibrate(&good, 24, &Options::new(noise)).unwrap_err();
        assert!(matches!(refused, Refused::BadNoise { .. }), "{refused}");
    }
    // Only the lower triangle is factorised.
    let mut each: Vec<Vec<Matrix3<f64>>> = good.iter().map(|view| vec![Matrix3::identity(); view.len()]).collect();
    each[1][0][(0, 2)] = f64::NAN;
    let refused = calibrate(&good, 24, &Options::new(Localizer::Each(each))).unwrap_err();
    assert!(matches!(refused, Refused::BadNoise { view: 1, .. }), "{refused}");
    let refused = calibrate(&good, 24, &Options::new(Localizer::Each(Vec::new()))).unwrap_err();
    assert!(
        matches!(refused, Refused::Unmatched { view: 0, found: 0, .. }),
        "{refused}"
    );
}

/// Two emitters exchanged from the middle of the recording on were accepted in 4 of 20 runs, both at one place: 21 mm off was stated as 0.03.
#[test]
fn exchanged_in_half_of_the_views_gives_no_emitter_the_place_of_another() {
    let mut named = 0;
    for seed in 0..40 {
        let (truth, mut views) = planted(1000 + seed, 100);
        for view in &mut views[50..] {
            for sighting in view.iter_mut() {
                sighting.0 = match sighting.0 {
                    3 => 4,
                    4 => 3,
                    other => other,
                };
            }
        }
        match calibrate(&views, 24, &options()) {
            Ok(found) => {
                let off = errors(&found.emitters, &truth);
                panic!("seed {seed}: {:.2} mm", rms(&off));
            }
            Err(Refused::OnePlace { .. } | Refused::Torn { .. }) => named += 1,
            Err(_) => {}
        }
    }
    assert!(named > 0);
}

/// An emitter whose last sightings lie off the place that the first give it is none that moved a little.
#[test]
fn an_emitter_that_moved_is_no_emitter_with_outliers() {
    let (_, mut views) = planted(77, 100);
    let of = |view: &View| view.iter().position(|s| s.0 == 7);
    let seen = views.iter().filter(|view| of(view).is_some()).count();
    let mut moved = 0;
    for view in views.iter_mut().rev() {
        if let Some(at) = of(view).filter(|_| 5 * moved < 2 * seen) {
            view[at].1 = view[at].1 + geometry::Vector::new(4.0, 4.0, 4.0);
            moved += 1;
        }
    }
    let refused = calibrate(&views, 24, &options()).unwrap_err();
    assert!(
        matches!(refused, Refused::Torn { emitter: 7, rejected, .. } if rejected == moved),
        "{refused}"
    );
}
