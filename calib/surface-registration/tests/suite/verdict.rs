//! Each limit of a verdict by itself: a right registration of a box, with one number changed to what may just be, to what may not, and to none.

use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};
use surface_registration::{
    Field, Limits, Options, Points, Refusal, Spacing, Start, Surface, SurfacePoint, SurfaceRegistration, register,
};

use crate::shapes::cuboid;

type Found = SurfaceRegistration<Ct, Tracker>;

const HALF_MM: [f64; 3] = [60.0, 40.0, 25.0];
const TARGET: [f64; 3] = [5.0, -5.0, 10.0];
const NOISE_MM: f64 = 0.4;

/// Points on all faces of the box; those of `wrong` lie so far outside of it.
fn touched(count: u64, wrong: &[(u64, f64)], seed: u64) -> Found {
    let (corners, triangles) = cuboid(HALF_MM, 12);
    let surface = Surface::<Ct>::new(&corners, &triangles).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let chance = Chance::new(seed, 0);
    let truth = Rigid::<Ct, Tracker>::from_rotation_vector(Vector::new(0.05, -0.02, 0.04), Vector::new(3.0, -2.0, 4.0))
        .unwrap();
    let touched = |i: u64| {
        let axis = (i % 3) as usize;
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut p = [0, 1, 2].map(|k: u64| HALF_MM[k as usize] * (1.9 * chance.uniform(8 * i + k) - 0.95));
        let outside_mm = wrong.iter().find(|(at, _)| *at == i).map_or(0.0, |(_, mm)| *mm);
        p[axis] = side * (HALF_MM[axis] + outside_mm + NOISE_MM * chance.normal(8 * i + 4));
        SurfacePoint::<Tracker>::touched(truth.inverse() * Point::new(p[0], p[1], p[2]), NOISE_MM)
    };
    let points = Points::new(&(0..count).map(touched).collect::<Vec<_>>(), None, 0.0).unwrap();
    let start = Start::Guess {
        pose: Rigid::identity(),
        turn_rad: 0.1,
        shift_mm: 6.0,
    };
    let mut options = Options::default();
    options.priors.bone_mm = 0.0;
    register(&surface, &field, &points, &start, &options).unwrap()
}

fn judged(found: &Found) -> Vec<Refusal> {
    let [x, y, z] = TARGET;
    Limits::default().judge(found, &[Point::new(x, y, z)])
}

/// A number of a registration, what it may just be and what it may not, and the refusal that says so.
type Row = (&'static str, fn(&mut Found, f64), [f64; 2], fn(&Refusal) -> bool);

const ROWS: [Row; 9] = [
    (
        "hits",
        |f, v| f.hits = v as usize,
        [3.0, 2.0],
        |r| matches!(r, Refusal::Hits { found: 2, least: 3, .. }),
    ),
    (
        "settled",
        |f, v| f.is_settled = v > 0.0,
        [1.0, 0.0],
        |r| *r == Refusal::NotSettled,
    ),
    (
        "searched",
        |f, v| f.seeds = v as usize,
        [1.0, 0.0],
        |r| *r == Refusal::NotSearched,
    ),
    (
        "share",
        |f, v| f.share_kept = v,
        [0.5, 0.499],
        |r| matches!(r, Refusal::Share { .. }),
    ),
    (
        "kept",
        |f, v| f.kept = v,
        [15.0, 14.9],
        |r| matches!(r, Refusal::Kept { .. }),
    ),
    (
        "facing away",
        |f, v| f.share_facing_away = v,
        [0.15, 0.151],
        |r| matches!(r, Refusal::FacingAway { .. }),
    ),
    (
        "beyond",
        |f, v| f.share_beyond = v,
        [0.3, 0.301],
        |r| matches!(r, Refusal::Beyond { .. }),
    ),
    (
        "landmarks",
        |f, v| f.landmark_ratio = Some(v),
        [5.0, 5.01],
        |r| matches!(r, Refusal::Landmarks { .. }),
    ),
    // 3 deviations of 0.02, and of 0.8 mm.
    (
        "depths",
        |f, v| f.depth_scale = v * f.priors.depth_scale,
        [3.0, 3.01],
        |r| matches!(r, Refusal::Prior { .. }),
    ),
];

#[test]
fn each_limit_refuses_what_is_beyond_it_and_what_is_no_number_and_nothing_else() {
    let found = touched(120, &[], 1);
    assert_eq!(judged(&found), []);
    for (name, set, [allowed, refused], is_it) in ROWS {
        let with = |value: f64| {
            let mut changed = found.clone();
            set(&mut changed, value);
            judged(&changed)
        };
        assert_eq!(with(allowed), [], "{name}");
        let refusals = with(refused);
        assert!(matches!(&refusals[..], [one] if is_it(one)), "{name}: {refusals:?}");
        // Counts and yes or no are never no number.
        if !["hits", "settled", "searched"].contains(&name) {
            let refusals = with(f64::NAN);
            assert!(refusals.iter().any(is_it), "{name}: {refusals:?}");
        }
    }
}

/// Eighteen points, of which two lie far outside, and a target beside the bone: where one more would put it off by more than 2 mm, that is said.
#[test]
fn one_more_gross_error_among_few_points_is_said() {
    let beside = Point::new(0.0, 0.0, 150.0);
    let is_said = |count: u64, wrong: &[(u64, f64)], seed: u64| {
        let refusals = Limits::default().judge(&touched(count, wrong, seed), &[beside]);
        let is_it = |refusal: &Refusal| matches!(refusal, Refusal::GrossError { left_out: 1.., .. });
        refusals.iter().any(is_it)
    };
    let wrong = [(3, 9.0), (10, 12.0)];
    for seed in 0..6 {
        let all = [
            is_said(18, &wrong, seed),
            is_said(18, &[], seed),
            is_said(240, &wrong, seed),
        ];
        // Nor without a sign of one, nor where there are points enough that one more does little.
        assert_eq!(all, [true, false, false], "{seed}");
    }
}
