//! Which emitters are seen.

use super::super::sight::{Capsule, between_segments};
use super::super::{bodies, hand};
use super::*;
use scene::operating_room::Hand;

fn point(chance: &Chance, first: u64, size: f64) -> Point<Tracker> {
    let [x, y, z] = [0, 1, 2].map(|i| size * (2.0 * chance.uniform(first + i) - 1.0));
    Point::new(x, y, z)
}

#[test]
fn distances_of_segments_are_those_of_their_points() {
    const STEPS: usize = 200;
    for case in 0..300 {
        let chance = Chance::new(1, case);
        let [a, b, c] = [0, 3, 6].map(|first| point(&chance, first, 10.0));
        let d = match case % 5 {
            // Parallel, and of no length.
            0 => c + (b - a) * 0.7,
            1 => c,
            _ => point(&chance, 9, 10.0),
        };
        let along =
            |from: Point<Tracker>, to: Point<Tracker>| (0..=STEPS).map(move |i| from.lerp(to, i as f64 / STEPS as f64));
        let sampled = along(a, b)
            .flat_map(|p| along(c, d).map(move |q| p.distance(q)))
            .fold(f64::INFINITY, f64::min);
        let exact = between_segments([a, b], [c, d]);
        // The nearest sample is at most half a step from the nearest point, on each of the two.
        let coarse = (a.distance(b) + c.distance(d)) / (2.0 * STEPS as f64);
        assert!(
            exact <= sampled + 1e-12 && sampled <= exact + coarse,
            "{case}: {exact} {sampled}"
        );
        // A few roundings of numbers of 20 mm.
        assert!((exact - between_segments([c, d], [a, b])).abs() < 1e-13, "{case}");
    }
    let cross = |gap: f64| {
        let p = |x, y, z| Point::new(x, y, z);
        between_segments(
            [p(-1.0, 0.0, 0.0), p(1.0, 0.0, 0.0)],
            [p(0.0, -1.0, gap), p(0.0, 1.0, gap)],
        )
    };
    assert_eq!((cross(0.0), cross(0.25)), (0.0, 0.25));
}

#[test]
fn the_handle_hides_what_lies_behind_it() {
    let open = scene(QUIET, &format!("[tracker.room.marker]\ncone_deg = 180\n{NO_HANDLE}"));
    let handle = "[tracker.room.handle]\nradius_mm = 20\nto_mm = 300\n";
    let shut = scene(QUIET, &format!("[tracker.room.marker]\ncone_deg = 180\n{handle}"));
    let (mut hidden, mut near) = (0, 0);
    for seed in 0..300 {
        let script = Played::held(any_orientation(seed));
        let all = played(&open, script.clone(), seed).frame(0);
        let some = played(&shut, script, seed).frame(0);
        let tracker_from_tool = all.tracker_from_marker * room(&open).marker_from_tool;
        for sighting in &all.tool {
            let seen = some.tool.contains(sighting);
            // The way of the light in the tool's frame, sampled every 0.1 mm within 700 mm of the emitter; the axis is known there.
            let [emitter, eye] = [sighting.place, Point::new(0.0, 0.0, 0.0)].map(|p| tracker_from_tool.inverse() * p);
            let out = (eye - emitter).direction().unwrap();
            let nearest = (0..7000).map(|i| {
                let [x, y, z] = (emitter + out * (0.1 * f64::from(i))).mm();
                let beyond = (z + 180.0).max(-300.0 - z).max(0.0);
                x.hypot(y).hypot(beyond)
            });
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            // Half a step aside of the nearest point: less than 0.0025^2 / 20 mm, and never less than the truth.
            if (nearest - 20.0).abs() < 1e-3 {
                near += 1;
            } else {
                assert_eq!(seen, nearest > 20.0, "{seed}: {nearest}");
            }
            hidden += usize::from(!seen);
        }
    }
    println!("the handle hid {hidden} of {} emitters", 300 * 24);
    assert!(hidden > 100 && near < 10, "{hidden} {near}");
}

/// How often each number of emitters is seen, over all orientations alike.
fn numbers_seen(tables: &str, orientations: u64) -> Vec<usize> {
    let scene = scene(QUIET, tables);
    let mut counts = vec![0; 25];
    for seed in 0..orientations {
        counts[played(&scene, Played::held(any_orientation(seed)), seed)
            .frame(0)
            .tool
            .len()] += 1;
    }
    counts
}

#[test]
fn a_ball_of_24_shows_a_quarter_of_its_emitters() {
    let n = 4000;
    let counts = numbers_seen(NO_HANDLE, n);
    let share = |k: usize| counts[k] as f64 / n as f64;
    let mean: f64 = (0..25).map(|k| k as f64 * share(k)).sum();
    let variance: f64 = (0..25).map(|k| (k as f64 - mean).powi(2) * share(k)).sum();
    let with_handle = numbers_seen("", n);
    println!("emitters seen of 24, in {n} orientations, without and with the handle:");
    for k in (0..25).filter(|&k| counts[k] + with_handle[k] > 0) {
        println!("{k:2}: {:5} {:5}", counts[k], with_handle[k]);
    }
    // An emitter at 50 mm is seen from 2300 mm, to first order of their ratio, up to the angle of cosine c + (1 - c^2) 50 / 2300
    // about its direction. The centre is 286 mm from the middle, which changes the mean distance by less than 1 %.
    let cosine = 0.5 + 0.75 * 50.0 / 2300.0;
    let expected = 24.0 * (1.0 - cosine) / 2.0;
    // Five standard errors, and second orders: 24 (50 / 2300)^2.
    let allowed = 5.0 * (variance / n as f64).sqrt() + 0.012;
    assert!((mean - expected).abs() < allowed, "{mean} {expected} {allowed}");
    assert_eq!(counts[..3].iter().sum::<usize>(), 0, "{counts:?}");
    assert_eq!(counts[11..].iter().sum::<usize>(), 0, "{counts:?}");
    let fewer = |k: usize| with_handle[..k].iter().sum::<usize>();
    assert!((4..8).all(|k| fewer(k) >= counts[..k].iter().sum()), "{with_handle:?}");
}

#[test]
fn every_eye_must_see_an_emitter_within_view_and_range() {
    let seen = |localizer: &str| -> Vec<usize> {
        let scene = scene(&format!("{QUIET}\n{localizer}"), "");
        let room = played(&scene, Played::held(any_orientation(3)), 1);
        room.frame(0).tool.iter().map(|s| s.emitter).collect()
    };
    let one = seen("");
    assert!(one.len() >= 3);
    let [left, right] = ["[[-900, 0, 0]]", "[[900, 0, 0]]"].map(|eyes| seen(&format!("eyes_mm = {eyes}")));
    let both = seen("eyes_mm = [[-900, 0, 0], [900, 0, 0]]");
    let common: Vec<usize> = left.iter().copied().filter(|e| right.contains(e)).collect();
    assert_eq!(both, common);
    assert!(both.len() < left.len() || both.len() < right.len());
    // The ball is within 300 mm of the middle, which lies 2300 mm ahead.
    assert_eq!(seen("view_deg = 10"), one);
    assert_eq!(seen("nearest_mm = 1900\nfarthest_mm = 2700"), one);
    for none in ["view_deg = 1", "nearest_mm = 2700", "farthest_mm = 1900"] {
        assert!(seen(none).is_empty(), "{none}");
    }
}

#[test]
fn the_hand_comes_and_goes_and_hides_some() {
    let tables = "[tracker.room.hand]\nradius_mm = 50\nevery_s = 3\nfor_s = 1\n[tracker.room.marker]\ncone_deg = 180\n";
    let without = approached(
        &scene(QUIET, &format!("[tracker.room.marker]\ncone_deg = 180\n{NO_HANDLE}")),
        1,
    );
    let with = approached(&scene(QUIET, &format!("{tables}{NO_HANDLE}")), 1);
    let (mut hidden, mut comings) = (0, std::collections::BTreeSet::new());
    for seq in 0..1800 {
        let (all, some) = (without.frame(seq).tool, with.frame(seq).tool);
        let away = seq % 180 >= 60;
        if away {
            assert_eq!(all, some, "{seq}");
        }
        if some.len() < all.len() {
            comings.insert(seq / 180);
        }
        hidden += all.len() - some.len();
    }
    println!(
        "the hand hid emitters in {} of 10 comings, {hidden} in 600 frames",
        comings.len()
    );
    assert!(comings.len() >= 3, "{comings:?}");
}

#[test]
fn the_hand_goes_around_the_marker_and_touches_no_emitter() {
    let hand = Hand {
        radius_mm: 45.0,
        every_s: 3.0,
        for_s: 1.0,
    };
    let scene = scene("", "");
    let body = approached(&scene, 1).chain(middle()).unwrap().marker;
    let reach = bodies::reach_mm(&body);
    assert!((reach - 50.0).abs() < 1e-12);
    let place = |t_s| hand::place(&hand, reach, 9, t_s);
    assert_eq!((place(-0.1), place(1.0), place(2.999)), (None, None, None));
    let step = 1e-3;
    for i in 0..999 {
        let t_s = 3.0 + f64::from(i) * step;
        let (here, next) = (place(t_s).unwrap(), place(t_s + step).unwrap());
        assert!(body.emitters().iter().all(|e| e.place.distance(here) > 54.9));
        // Once around a circle of 105 mm in a second.
        assert!(here.distance(next) < 1.001 * std::f64::consts::TAU * 105.0 * step);
    }
    assert!(
        place(0.5).unwrap().distance(place(3.5).unwrap()) > 1.0,
        "another way each time"
    );
}

#[test]
fn what_has_no_width_hides_nothing() {
    let p = Point::new(0.0, 0.0, 100.0);
    assert_eq!(Capsule::new(p, p, 0.0), None);
    let ball = Capsule::new(p, p, 10.0).unwrap();
    let eye = Point::new(0.0, 0.0, 0.0);
    assert!(ball.hides(eye, Point::new(0.0, 0.0, 200.0)));
    assert!(ball.hides(eye, Point::new(0.0, 0.0, 91.0)), "inside it");
    assert!(!ball.hides(eye, Point::new(0.0, 0.0, 89.0)), "before it");
    assert!(!ball.hides(eye, Point::new(30.0, 0.0, 200.0)));
}
