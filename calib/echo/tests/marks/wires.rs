//! Dots and their names in images whose truth is known.

use crate::made::{COLUMNS, Made, ROWS};
use echo::{Dot, DotOptions, Drawing, Grey, WiresError, WiresOptions, dots, label};

type V3 = [f64; 3];

/// Three N whose lowest is narrower: the arrangement of PLUS's fCal phantom 2.0.
const THREE_N: [[V3; 2]; 9] = [
    [[30.0, 0.0, 20.0], [30.0, 40.0, 20.0]],
    [[55.0, 0.0, 20.0], [35.0, 40.0, 20.0]],
    [[60.0, 0.0, 20.0], [60.0, 40.0, 20.0]],
    [[30.0, 0.0, 10.0], [30.0, 40.0, 10.0]],
    [[35.0, 0.0, 10.0], [55.0, 40.0, 10.0]],
    [[60.0, 0.0, 10.0], [60.0, 40.0, 10.0]],
    [[35.0, 0.0, 0.0], [35.0, 40.0, 0.0]],
    [[55.0, 0.0, 0.0], [40.0, 40.0, 0.0]],
    [[60.0, 0.0, 0.0], [60.0, 40.0, 0.0]],
];
const PIXEL: [f64; 2] = [0.095, 0.085];

/// Where an image that is turned by `angles` (about the beam, about the rows, in its own plane) about a place half-way
/// along the wires cuts each of them, pixels.
fn cuts(wires: &[[V3; 2]], angles: V3, depth: f64) -> Vec<Option<[f64; 2]>> {
    let [beam, tilt, roll] = angles;
    // Rows against x and columns against z, as the probe looks down on the phantom from above.
    let rotate = |p: V3| {
        let [x, y, z] = p;
        let (x, z) = (x * roll.cos() - z * roll.sin(), x * roll.sin() + z * roll.cos());
        let (y, z) = (y * tilt.cos() - z * tilt.sin(), y * tilt.sin() + z * tilt.cos());
        [x * beam.cos() - y * beam.sin(), x * beam.sin() + y * beam.cos(), z]
    };
    let axes = [
        rotate([-1.0, 0.0, 0.0]),
        rotate([0.0, 0.0, -1.0]),
        rotate([0.0, 1.0, 0.0]),
    ];
    let middle = [45.0, depth, 10.0];
    let along = |axis: V3, p: V3| (0..3).map(|k| axis[k] * (p[k] - middle[k])).sum::<f64>();
    wires
        .iter()
        .map(|[front, back]| {
            let (a, b) = (along(axes[2], *front), along(axes[2], *back));
            let share = a / (a - b);
            let at = [0, 1, 2].map(|k| front[k] + share * (back[k] - front[k]));
            let px = [
                along(axes[0], at) / PIXEL[0] + 320.0,
                along(axes[1], at) / PIXEL[1] + 230.0,
            ];
            let is_in = (0.0..=1.0).contains(&share)
                && (25.0..COLUMNS as f64 - 25.0).contains(&px[0])
                && (25.0..ROWS as f64 - 25.0).contains(&px[1]);
            is_in.then_some(px)
        })
        .collect()
}

struct Scene {
    made: Made,
    truth: Vec<Option<[f64; 2]>>,
}

/// An image of the phantom with `missing` wires left out and `extra` blobs anywhere, in a medium.
fn scene(seed: u64, missing: usize, extra: usize, medium: f64, speckle: f64) -> Scene {
    let mut made = Made::new(seed);
    let angles = [
        made.between(-0.3, 0.3),
        made.between(-0.3, 0.3),
        made.between(-0.2, 0.2),
    ];
    let depth = made.between(12.0, 28.0);
    let mut truth = cuts(&THREE_N, angles, depth);
    for _ in 0..missing {
        let k = (made.share() * 9.0) as usize;
        truth[k] = None;
    }
    made.medium(medium);
    for at in truth.clone().into_iter().flatten() {
        let (wide, high) = (made.between(5.0, 10.0), made.between(2.5, 4.5));
        let height = made.between(90.0, 400.0);
        made.dot(at, [wide, high], height, speckle);
    }
    for _ in 0..extra {
        let at = [made.between(30.0, 610.0), made.between(30.0, 450.0)];
        let (wide, height) = (made.between(4.0, 14.0), made.between(60.0, 250.0));
        made.dot(at, [wide, 3.0], height, speckle);
    }
    Scene { made, truth }
}

fn found(made: &Made) -> Vec<Dot> {
    let grey = made.grey();
    dots(&Grey::new(COLUMNS, ROWS, &grey).unwrap(), &DotOptions::default())
}

/// How many names are right, wrong, and how many cuts have none; `None` where the image is refused.
fn judged(scene: &Scene) -> Option<[usize; 3]> {
    let dots = found(&scene.made);
    let drawing = Drawing::new(&THREE_N).unwrap();
    let labelled = label(&dots, &drawing, &WiresOptions::default()).ok()?;
    let mut count = [0; 3];
    for (wire, dot) in &labelled.pairs {
        let [u, v] = dots[*dot].px;
        // Half a dot's width: nearer than this it is that wire's light.
        let is_right = scene.truth[*wire].is_some_and(|[x, y]| (u - x).abs() < 12.0 && (v - y).abs() < 6.0);
        count[usize::from(!is_right)] += 1;
    }
    count[2] = scene.truth.iter().flatten().count() - count[0];
    Some(count)
}

/// Blobs that lie where a wire could be, within 0.5 mm, cannot be told from it in one image: a few of 360 names.
#[test]
fn names_are_right_or_there_are_none() {
    // Wires missing, blobs too many; the least right and the most wrong names of 40 images, the most images refused.
    for (missing, extra, right, wrong, most_refused) in [
        (0, 0, 360, 0, 0),
        (0, 6, 340, 4, 2),
        (2, 0, 130, 0, 24),
        (2, 6, 110, 4, 28),
        (4, 8, 0, 9, 40),
    ] {
        let (mut sums, mut refused) = ([0; 3], 0);
        for seed in 0..40 {
            match judged(&scene(1000 + seed, missing, extra, 12.0, 0.3)) {
                Some(count) => (0..3).for_each(|k| sums[k] += count[k]),
                None => refused += 1,
            }
        }
        println!("missing {missing}, extra {extra}: right, wrong, none {sums:?}, {refused} of 40 refused");
        let is_held = sums[0] >= right && sums[1] <= wrong && refused <= most_refused;
        assert!(is_held, "missing {missing}, extra {extra}: {sums:?}, {refused} refused");
    }
}

/// The error that is told holds the truth for dots that stand alone, bright or saturated.
#[test]
fn centres_are_within_their_error() {
    let (mut within, mut all, mut worst) = (0, 0, 0.0_f64);
    for seed in 0..30 {
        let scene = scene(5000 + seed, 0, 0, 6.0, 0.3);
        let dots = found(&scene.made);
        for [x, y] in scene.truth.iter().flatten() {
            let off = |dot: &Dot| (dot.px[0] - x).hypot(dot.px[1] - y);
            let near = dots.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
            for (a, truth) in [x, y].into_iter().enumerate() {
                let ratio = (near.px[a] - truth).abs() / near.sigma_px[a];
                worst = worst.max((near.px[a] - truth).abs());
                within += usize::from(ratio <= 1.96);
                all += 1;
            }
        }
    }
    println!("{within} of {all} within 1.96 deviations, at most {worst:.2} pixels off");
    // 95 % of 540, less three deviations of that count (15).
    assert!(within >= 498, "{within} of {all}");
    assert!(worst < 4.0, "{worst}");
}

#[test]
fn dots_that_touch_are_two_and_say_so() {
    let mut made = Made::new(9);
    made.dot([300.0, 200.0], [6.0, 3.0], 200.0, 0.0);
    made.dot([324.0, 200.0], [6.0, 3.0], 150.0, 0.0);
    made.dot([500.0, 300.0], [6.0, 3.0], 150.0, 0.0);
    let dots = found(&made);
    assert_eq!(dots.len(), 3, "{dots:?}");
    for dot in &dots {
        assert_eq!(dot.is_cut, dot.px[0] < 400.0, "{dot:?}");
        // A dot that is cut says that its centre may be off by its own width.
        assert!(dot.is_cut == (dot.sigma_px[0] > 4.0), "{dot:?}");
    }
}

#[test]
fn a_symmetric_drawing_needs_to_know_which_way_rows_run() {
    // Two N of one width: seen from behind they look alike.
    let wires: Vec<[V3; 2]> = THREE_N[..6].to_vec();
    let truth = cuts(&wires, [0.1, 0.1, 0.05], 20.0);
    let mut made = Made::new(3);
    for at in truth.iter().flatten() {
        made.dot(*at, [6.0, 3.0], 200.0, 0.0);
    }
    let dots = found(&made);
    let drawing = Drawing::new(&wires).unwrap();
    let options = WiresOptions {
        least: 4,
        ..WiresOptions::default()
    };
    let refused = label(&dots, &drawing, &options).unwrap_err();
    assert!(matches!(refused, WiresError::Ambiguous(_)), "{refused}");
    let known = WiresOptions {
        right: Some([-1.0, 0.0, 0.0]),
        down: Some([0.0, 0.0, -1.0]),
        ..options
    };
    let labelled = label(&dots, &drawing, &known).unwrap();
    assert_eq!(labelled.pairs.len(), 6, "{labelled:?}");
    for (wire, dot) in labelled.pairs {
        let [x, y] = truth[wire].unwrap();
        assert!((dots[dot].px[0] - x).hypot(dots[dot].px[1] - y) < 1.0);
    }
    let [right, down] = labelled.runs;
    assert!(right[0] < -0.9 && down[2] < -0.9, "{right:?} {down:?}");
}

#[test]
fn drawings_and_images_without_wires_are_refused() {
    let drawing = |wires: &[[V3; 2]]| Drawing::new(wires).unwrap_err().to_string();
    assert!(drawing(&THREE_N[..3]).contains("3 wires"));
    assert!(drawing(&[THREE_N[0], THREE_N[2], THREE_N[1], THREE_N[1]]).contains("2 parallel wires"));
    let mut bad = THREE_N;
    bad[4][1] = [f64::NAN; 3];
    assert!(drawing(&bad).contains("wire 4"));
    let mut made = Made::new(4);
    made.medium(30.0);
    let dots = found(&made);
    let good = Drawing::new(&THREE_N).unwrap();
    assert!(matches!(
        label(&dots, &good, &WiresOptions::default()),
        Err(WiresError::Few { .. })
    ));
}
