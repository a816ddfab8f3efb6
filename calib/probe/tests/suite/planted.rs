//! Planted calibrations: images made by geometry alone, with noise that is known.

use chance::Chance;
use geometry::{Phantom, Point, Probe, Reference, Rigid, Uncertain, Vector};
use nalgebra::{Matrix6, Vector6};
use probe::{
    Mark, Options, PointNoise, PoseNoise, ProbeError, Seen, Track, Wire, Wires, calibrate, calibrate_by_wall, check,
    cross_validate,
};

/// What is planted. The image's frame is in mm from its first pixel.
struct World {
    probe_from_image: Rigid<Probe, geometry::Image>,
    pixel_mm: [f64; 2],
    reference_from_phantom: Rigid<Reference, Phantom>,
    wires: Wires,
    noise: Options,
    /// Columns and rows of the image.
    size: [f64; 2],
}

fn rigid<A, B>(w: [f64; 3], t: [f64; 3]) -> Rigid<A, B> {
    Rigid::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(t[0], t[1], t[2])).unwrap()
}

/// Three N patterns, 10 mm apart.
fn wires() -> Wires {
    let mut all = Vec::new();
    for (row, z) in [20.0, 10.0, 0.0].into_iter().enumerate() {
        let ends = [
            (30.0, 30.0),
            if row == 1 { (35.0, 55.0) } else { (55.0, 35.0) },
            (60.0, 60.0),
        ];
        for (front, back) in ends {
            all.push(Wire {
                name: format!("{}", all.len()),
                front: Point::new(front, 0.0, z),
                back: Point::new(back, 40.0, z),
            });
        }
    }
    Wires::new(all).unwrap()
}

impl World {
    fn new(pixel: f64) -> Self {
        let noise = Options {
            point: PointNoise {
                lateral_mm: 0.2,
                axial_mm: 0.1,
                elevation_mm: 0.4,
            },
            pose: PoseNoise {
                turn_rad: 0.001,
                shift_mm: 0.1,
            },
            ..Options::default()
        };
        Self {
            probe_from_image: rigid([0.3, -1.2, 0.8], [14.0, 50.0, -6.0]),
            pixel_mm: [pixel, 0.9 * pixel],
            reference_from_phantom: rigid([1.0, 0.4, -0.7], [20.0, -30.0, 45.0]),
            wires: wires(),
            noise,
            size: [45.0 / pixel, 40.0 / pixel],
        }
    }

    /// A pose of the probe at which the image lies in the phantom turned by `w` about its own axes, its middle at
    /// `y` along the wires.
    fn pose(&self, w: [f64; 3], y: f64, aside: [f64; 2]) -> Rigid<Reference, Probe> {
        // Image x along the phantom's x, image y down (phantom -z): z of the image along phantom y.
        let upright: Rigid<Phantom, geometry::Image> = rigid([-std::f64::consts::FRAC_PI_2, 0.0, 0.0], [0.0; 3]);
        let middle = Point::<geometry::Image>::new(
            0.5 * self.size[0] * self.pixel_mm[0],
            0.5 * self.size[1] * self.pixel_mm[1],
            0.0,
        );
        let tilted =
            Rigid::<Phantom, Phantom>::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(0.0, 0.0, 0.0))
                .unwrap();
        let turned = tilted * upright;
        let at = turned * middle;
        let to = Vector::<Phantom>::new(
            45.0 + aside[0] - at.mm()[0],
            y - at.mm()[1],
            10.0 + aside[1] - at.mm()[2],
        );
        let placed = Rigid::from_parts(turned.rotation(), turned.translation() + to);
        self.reference_from_phantom * placed * self.probe_from_image.inverse()
    }

    /// The pixel at which the image cuts a wire, off by noise; `None` beyond its ends.
    fn cut(&self, pose: &Rigid<Reference, Probe>, wire: &Wire, chance: Option<(Chance, u64)>) -> Option<[f64; 2]> {
        let image_from_phantom = (*pose * self.probe_from_image).inverse() * self.reference_from_phantom;
        let (a, b) = (
            (image_from_phantom * wire.front).mm(),
            (image_from_phantom * wire.back).mm(),
        );
        let draw = |k: u64| chance.map_or(0.0, |(c, at)| c.normal(at + k));
        // A thick slice shows the wire where it cuts a plane beside the middle one.
        let off = draw(0) * self.noise.point.elevation_mm;
        let share = (off - a[2]) / (b[2] - a[2]);
        let noise = [self.noise.point.lateral_mm, self.noise.point.axial_mm];
        let px = [0, 1].map(|k| (a[k] + share * (b[k] - a[k]) + noise[k] * draw(1 + k as u64)) / self.pixel_mm[k]);
        (0.0..=1.0).contains(&share).then_some(px)
    }

    /// The pose as the tracker tells it.
    fn told(&self, pose: Rigid<Reference, Probe>, chance: Chance) -> Rigid<Reference, Probe> {
        let PoseNoise { turn_rad, shift_mm } = self.noise.pose;
        let n = |k: u64, s: f64| chance.normal(9000 + k) * s;
        let turned = rigid::<Reference, Reference>([n(0, turn_rad), n(1, turn_rad), n(2, turn_rad)], [0.0; 3])
            .rotation()
            * pose.rotation();
        let shift = Vector::<Reference>::new(n(3, shift_mm), n(4, shift_mm), n(5, shift_mm));
        Rigid::from_parts(turned, pose.translation() + shift)
    }

    /// Frames at random tilts of up to `fan` rad, along the wires.
    fn frames(&self, count: u64, fan: f64, seed: Option<u64>) -> Vec<Seen> {
        let one = |i: u64| {
            let place = Chance::new(seed.unwrap_or(77), i);
            let even = |k: u64, most: f64| most * (2.0 * place.uniform(500 + k) - 1.0);
            let pose = self.pose(
                [even(0, fan), even(1, fan), even(2, fan)],
                20.0 + even(3, 12.0),
                [even(4, 3.0), even(5, 3.0)],
            );
            let noise = seed.map(|seed| Chance::new(seed, i));
            let mark = |(w, wire): (usize, &Wire)| {
                let px = self.cut(&pose, wire, noise.map(|c| (c, 10 * w as u64)))?;
                Some(Mark { wire: w, px })
            };
            Seen {
                number: i as u32,
                t_s: None,
                reference_from_probe: noise.map_or(pose, |c| self.told(pose, c)),
                marks: self.wires.all().iter().enumerate().filter_map(mark).collect(),
            }
        };
        (0..count).map(one).collect()
    }

    fn truth(&self, px: [f64; 2]) -> Point<Probe> {
        self.probe_from_image * Point::new(px[0] * self.pixel_mm[0], px[1] * self.pixel_mm[1], 0.0)
    }

    fn corners(&self) -> [[f64; 2]; 3] {
        [[0.0, 0.0], [self.size[0], 0.0], [0.5 * self.size[0], self.size[1]]]
    }
}

/// Without noise nothing is left but rounding: pixels of every size, many frames and the fewest, wide fans and
/// narrow ones.
#[test]
fn exact_points_give_the_planted_image() {
    for pixel in [0.05, 0.1, 0.5] {
        for (count, fan) in [(3, 0.5), (40, 0.6), (40, 0.09)] {
            let world = World::new(pixel);
            let frames = world.frames(count, fan, None);
            let exact = Uncertain::from(world.reference_from_phantom);
            let found = calibrate(&frames, &world.wires, &exact, None, &world.noise).unwrap();
            assert!(found.is_settled, "{pixel} {count} {fan}");
            for px in world.corners() {
                let off = found.place(px).point().distance(world.truth(px));
                // Steps below 1e-4 deviations of 0.1 mm or so end the rounds; the last lands far nearer.
                assert!(off < 1e-4, "{pixel} {count} {fan}: {off}");
            }
            for k in 0..2 {
                assert!((found.pixel_mm[k] / world.pixel_mm[k] - 1.0).abs() < 1e-5);
            }
        }
    }
}

/// Square of the error in the predicted covariance: chi-square of three.
fn squares(world: &World, found: &probe::ProbeCalibration) -> Vec<f64> {
    let one = |px: [f64; 2]| {
        let place = found.place(px);
        let off = nalgebra::Vector3::from(place.point().mm()) - nalgebra::Vector3::from(world.truth(px).mm());
        off.dot(&(place.covariance().try_inverse().unwrap() * off))
    };
    world.corners().map(one).to_vec()
}

/// The predicted ellipses hold the truth as often as they say; a phantom that is not where it is told to be is in
/// them, and more frames
/// do not make that less.
#[test]
fn predicted_errors_hold_the_planted_image() {
    // Tilts of 20 degrees tell both apart, so that the second row is nearly as good as the first.
    for (name, frames, fan, turn, shift) in [
        ("exact phantom", 40, 0.35, 0.0, 0.0),
        ("phantom off", 80, 0.35, 0.004, 0.3),
        ("phantom off, narrow fan", 80, 0.03, 0.004, 0.3),
    ] {
        let world = World::new(0.1);
        let (mut inside, mut sum, mut runs) = (0.0, 0.0, 0.0);
        let mut worst_mm = 0.0;
        for seed in 0..40 {
            let seen = world.frames(frames, fan, Some(1000 + seed));
            let chance = Chance::new(5, seed);
            let covariance =
                Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift).map(|s: f64| s * s));
            let n = |k: u64, s: f64| chance.normal(k) * s;
            let by = rigid::<Reference, Reference>(
                [n(0, turn), n(1, turn), n(2, turn)],
                [n(3, shift), n(4, shift), n(5, shift)],
            );
            let told = Uncertain::new(by * world.reference_from_phantom, covariance).unwrap();
            let found = calibrate(&seen, &world.wires, &told, None, &world.noise).unwrap();
            worst_mm = found.worst_mm();
            for square in squares(&world, &found) {
                inside += f64::from(u8::from(square < 7.814_727_903_251_179));
                sum += square;
                runs += 1.0;
            }
            // 0.9 to 1.1: four deviations of a ratio of 700 equations.
            assert!(
                (0.85..1.15).contains(&found.noise_ratio),
                "{name}: {}",
                found.noise_ratio
            );
        }
        let (coverage, mean) = (inside / runs, sum / runs);
        println!("{name}: {coverage:.3} within 95 %, mean square {mean:.2} of 3, worst {worst_mm:.3} mm");
        // 40 runs of three places that share one error: four deviations of 40 independent ones are 0.14.
        assert!(coverage > 0.86, "{name}: {coverage}");
        // Mean of 40 chi-squares of three: deviation 0.39; the frames' factor, at least 1, makes it smaller.
        assert!((1.2..4.4).contains(&mean), "{name}: {mean}");
        // Without tilts nothing tells the phantom's error of 0.3 mm along each axis from the image's: 80 frames do
        // not average it away.
        assert!(fan > 0.1 || worst_mm > 0.3 * 3.0_f64.sqrt() * 0.9, "{worst_mm}");
    }
}

/// Points anywhere in the image: a tenth, a third, and a half of all.
#[test]
fn gross_errors_are_let_go_of() {
    for share in [0.1, 0.3, 0.5] {
        let world = World::new(0.1);
        let mut seen = world.frames(60, 0.35, Some(3));
        let (mut wrong, mut all) = (0, 0);
        for (i, frame) in seen.iter_mut().enumerate() {
            for (k, mark) in frame.marks.iter_mut().enumerate() {
                let chance = Chance::new(91, (100 * i + k) as u64);
                all += 1;
                if chance.uniform(0) < share {
                    wrong += 1;
                    mark.px = [chance.uniform(1) * world.size[0], chance.uniform(2) * world.size[1]];
                }
            }
        }
        let exact = Uncertain::from(world.reference_from_phantom);
        let found = calibrate(&seen, &world.wires, &exact, None, &world.noise).unwrap();
        let worst = squares(&world, &found).into_iter().fold(0.0, f64::max);
        println!(
            "{share}: {wrong} of {all} wrong, kept {:.3}, worst square {worst:.2}, {:.3} mm",
            found.share_kept,
            found.worst_mm()
        );
        // 1e-4 of chi-squares of three are above 21; a few wrong points within reach of their wires pull a little.
        assert!(worst < 25.0, "{share}: {worst}");
        assert!(
            (found.share_kept - (1.0 - share)).abs() < 0.08,
            "{share}: {}",
            found.share_kept
        );
    }
}

/// A moving probe whose poses come late: the lag, with its sign.
#[test]
fn a_planted_lag_is_found_with_its_sign() {
    for lag in [-0.08, 0.0, 0.05] {
        let world = World::new(0.1);
        let at = |t: f64| {
            world.pose(
                [0.2 * (1.3 * t).sin(), 0.15 * (0.9 * t).cos(), 0.1 * (1.7 * t).sin()],
                20.0 + 10.0 * (0.8 * t).sin(),
                [0.0; 2],
            )
        };
        let timed: Vec<_> = (0..400)
            .map(|i| {
                (
                    f64::from(i) * 0.05,
                    world.told(at(f64::from(i) * 0.05), Chance::new(8, i as u64)),
                )
            })
            .collect();
        let track = Track::new(&timed, 0.08).unwrap();
        let frames: Vec<Seen> = (0..60)
            .map(|i| {
                let t = 1.0 + 0.3 * f64::from(i);
                // An image stamped t shows what the poses say at t + lag.
                let pose = at(t + lag);
                let cut = |(w, wire): (usize, &Wire)| {
                    let px = world.cut(&pose, wire, Some((Chance::new(12, i as u64), 10 * w as u64)))?;
                    Some(Mark { wire: w, px })
                };
                Seen {
                    number: i as u32,
                    t_s: Some(t),
                    reference_from_probe: track.at(t).unwrap(),
                    marks: world.wires.all().iter().enumerate().filter_map(cut).collect(),
                }
            })
            .collect();
        let mut options = world.noise;
        options.priors.lag_s = 0.2;
        let exact = Uncertain::from(world.reference_from_phantom);
        let found = calibrate(&frames, &world.wires, &exact, Some(&track), &options).unwrap();
        let told = found.lag.unwrap();
        println!("{lag}: {told:?}");
        assert!((told.lag_s - lag).abs() < 4.0 * told.sigma_s, "{lag}: {told:?}");
        assert!((0.0005..0.02).contains(&told.sigma_s), "{told:?}");
        assert_eq!(
            calibrate(&frames, &world.wires, &exact, None, &options).unwrap_err(),
            ProbeError::NoTrack
        );
        let raw = Track::new(&timed, 0.0).unwrap();
        let refused = calibrate(&frames, &world.wires, &exact, Some(&raw), &options).unwrap_err();
        assert_eq!(refused, ProbeError::NoWindow);
    }
}

/// Wires that took no part: what is right is within its error, and an image 1 mm off is told by them.
#[test]
fn an_independent_wire_tells_a_wrong_calibration() {
    let world = World::new(0.1);
    let exact = Uncertain::from(world.reference_from_phantom);
    let found = calibrate(
        &world.frames(40, 0.3, Some(4)),
        &world.wires,
        &exact,
        None,
        &world.noise,
    )
    .unwrap();
    let others = world.frames(20, 0.3, Some(5));
    let good = check(&found.known(), &others, &world.wires, &exact, None, &world.noise).unwrap();
    assert!((0.8..1.2).contains(&good.ratio), "{}", good.ratio);
    assert!(good.bias_mm < 0.25, "{}", good.bias_mm);
    // The phantom stands 1 mm aside: the same as an image that is 1 mm off.
    let aside = rigid::<Reference, Reference>([0.0; 3], [0.0, 1.0, 0.0]) * world.reference_from_phantom;
    let wrong = check(
        &found.known(),
        &others,
        &world.wires,
        &Uncertain::from(aside),
        None,
        &world.noise,
    )
    .unwrap();
    assert!(
        wrong.ratio > 2.0 && wrong.bias_mm > 0.5,
        "{} {}",
        wrong.ratio,
        wrong.bias_mm
    );
    // One wire alone, and what the fit says of itself by its own frames: the same distances.
    let one = Wires::to_check(vec![world.wires.all()[1].clone()]).unwrap();
    let mut alone = others.clone();
    for frame in &mut alone {
        frame.marks.retain(|mark| mark.wire == 1);
        frame.marks.iter_mut().for_each(|mark| mark.wire = 0);
    }
    let alone = check(&found.known(), &alone, &one, &exact, None, &world.noise).unwrap();
    assert!((0.6..1.4).contains(&alone.ratio), "{}", alone.ratio);
    let own = check(
        &found.known(),
        &world.frames(40, 0.3, Some(4)),
        &world.wires,
        &exact,
        None,
        &world.noise,
    )
    .unwrap();
    for (judged, fitted) in own.distances_mm.iter().zip(&found.points) {
        assert!((judged - fitted.distance_mm).abs() < 1e-9);
    }
    let halves = cross_validate(&others, &world.wires, &exact, None, &world.noise, |i| i % 2 == 0).unwrap();
    assert!(
        halves
            .mean_mm
            .iter()
            .zip(halves.own_mm)
            .all(|(judged, own)| *judged > 0.8 * own),
        "{halves:?}"
    );
}

/// What the frames do not hold has a large deviation, and its name.
#[test]
fn what_is_free_is_named() {
    let world = World::new(0.1);
    let exact = Uncertain::from(world.reference_from_phantom);
    let found = calibrate(
        &world.frames(40, 0.3, Some(4)),
        &world.wires,
        &exact,
        None,
        &world.noise,
    )
    .unwrap();
    let free = found.free();
    assert!(
        free[0].deviation_mm < 0.1 && free[7].deviation_mm < free[0].deviation_mm,
        "{}",
        free[0]
    );
    // Two frames side by side are fewer than three; three at one pose are one picture.
    let mut few = world.frames(2, 0.3, Some(4));
    let refused = |frames: &[Seen]| calibrate(frames, &world.wires, &exact, None, &world.noise).unwrap_err();
    assert_eq!(refused(&few), ProbeError::TooFewFrames { found: 2, needed: 3 });
    few.push(few[0].clone());
    few[1] = few[0].clone();
    assert!(matches!(refused(&few), ProbeError::OnePose { frames: 3, .. }));
    // A wall from one side, shifted only: turns are held by nothing but a line's slope.
    let normal = nalgebra::Vector3::new(0.2, -0.3, 0.9).normalize_or();
    let shifted = wall(&world, normal, 40, 1e-4, Some(3));
    match calibrate_by_wall(&shifted, None, &world.noise) {
        Ok(found) => {
            println!("wall, upright only: {}", found.free()[0]);
            assert!(found.free()[0].deviation_mm > 1.0, "{}", found.free()[0]);
        }
        Err(error) => println!("wall, upright only: {error}"),
    }
}

/// Each refusal with its numbers.
#[test]
fn bad_inputs_are_refused_by_name() {
    let world = World::new(0.1);
    let exact = Uncertain::from(world.reference_from_phantom);
    let frames = world.frames(20, 0.3, Some(4));
    let refused = |frames: &[Seen], wires: &Wires, options: &Options| {
        calibrate(frames, wires, &exact, None, options).unwrap_err().to_string()
    };
    let with = |px: [f64; 2], wire: usize| {
        let mut frames = frames.clone();
        frames[3].marks[2] = Mark { wire, px };
        refused(&frames, &world.wires, &world.noise)
    };
    assert!(with([f64::NAN, 3.0], 0).starts_with("frame 3, point 2: the pixel is (NaN, 3)"));
    assert!(with([1.0, 3.0], 9).starts_with("frame 3, point 2: wire 9 of 9"));
    let mut noise = world.noise;
    noise.point.axial_mm = 0.0;
    assert!(refused(&frames, &world.wires, &noise).starts_with("the axial noise, mm is 0; allowed is 0.001 to 10"));
    // Metres.
    let scaled = |factor: f64, turn: f64| {
        let wire = |w: &Wire| {
            let by = |p: Point<Phantom>| Point::new(p.mm()[0] * factor * turn, p.mm()[1] * factor, p.mm()[2] * factor);
            Wire {
                name: w.name.clone(),
                front: by(w.front),
                back: by(w.back),
            }
        };
        Wires::new(world.wires.all().iter().map(wire).collect())
    };
    assert!(
        scaled(1e-3, 1.0)
            .unwrap_err()
            .to_string()
            .contains("0.040 mm apart; 1 to 1000 mm are allowed (are these metres?)")
    );
    assert!(
        scaled(1.0, 0.0)
            .unwrap_err()
            .to_string()
            .starts_with("all 9 wires are parallel to 0.00 degrees")
    );
    // A phantom of another unit than the tracker: 30 times too large.
    let large = scaled(20.0, 1.0).unwrap();
    let error = calibrate(&frames, &large, &exact, None, &world.noise);
    let told = error
        .as_ref()
        .map_or_else(ToString::to_string, |found| format!("ratio {:.0}", found.noise_ratio));
    println!("20 times too large: {told}");
    assert!(error.map_or(true, |found| found.noise_ratio > 5.0), "{told}");
    // The depth was changed half-way: pixels of two sizes. The noise ratio tells.
    let other = World::new(0.13).frames(20, 0.3, Some(4));
    let mixed: Vec<Seen> = frames
        .iter()
        .zip(&other)
        .enumerate()
        .map(|(i, (a, b))| if i < 10 { a.clone() } else { b.clone() })
        .collect();
    let found = calibrate(&mixed, &world.wires, &exact, None, &world.noise).unwrap();
    println!(
        "depth changed: ratio {:.1}, kept {:.2}",
        found.noise_ratio, found.share_kept
    );
    assert!(found.noise_ratio > 2.0 || found.share_kept < 0.8);
}

/// A wall seen from all sides: the image with its error.
#[test]
fn a_wall_gives_the_image() {
    let world = World::new(0.1);
    let mut options = world.noise;
    options.priors.pixel_mm = Some((world.pixel_mm, 0.02));
    let normal = nalgebra::Vector3::new(0.2, -0.3, 0.9).normalize_or();
    let mut worst = 0.0;
    for seed in 0..6 {
        let frames = wall(&world, normal, 80, 0.6, Some(seed));
        let found = calibrate_by_wall(&frames, None, &options).unwrap();
        let square = squares(&world, &found).into_iter().fold(0.0, f64::max);
        println!(
            "wall {seed}: square {square:.1}, {:.3} mm, ratio {:.2}, {}",
            found.worst_mm(),
            found.noise_ratio,
            found.free()[0]
        );
        worst = f64::max(worst, square);
    }
    // 18 chi-squares of three: one in a hundred thousand is above 26.
    assert!(worst < 26.0, "{worst}");
}

trait NormalizeOr {
    fn normalize_or(self) -> Self;
}
impl NormalizeOr for nalgebra::Vector3<f64> {
    fn normalize_or(self) -> Self {
        self.try_normalize(0.0).unwrap()
    }
}

/// Images of a plane `n y = 30` of the reference at tilts of up to `fan` and a full turn about the normal: five
/// points of each line.
fn wall(world: &World, n: nalgebra::Vector3<f64>, count: u64, fan: f64, seed: Option<u64>) -> Vec<Seen> {
    let one = |i: u64| {
        let place = Chance::new(seed.unwrap_or(7) + 40, i);
        let even = |k: u64, most: f64| most * (2.0 * place.uniform(500 + k) - 1.0);
        // A frame at the wall, z along the normal, turned about it, then the image upright in it with the beam
        // against the normal.
        let z = Vector::<Reference>::new(n.x, n.y, n.z).direction().unwrap();
        let origin = Point::new(30.0 * n.x, 30.0 * n.y, 30.0 * n.z);
        let at: Rigid<Reference, Phantom> = Rigid::from_axes(origin, z, geometry::Direction::Y).unwrap();
        let spin = Rigid::<Phantom, Phantom>::from_rotation_vector(
            Vector::new(0.0, 0.0, even(0, 3.0)),
            Vector::new(even(3, 20.0), even(4, 20.0), 0.0),
        )
        .unwrap();
        let tilt = Rigid::<Phantom, Phantom>::from_rotation_vector(
            Vector::new(even(1, fan), even(2, fan), 0.0),
            Vector::new(0.0, 0.0, 0.0),
        )
        .unwrap();
        let upright: Rigid<Phantom, geometry::Image> = rigid(
            [-std::f64::consts::FRAC_PI_2, 0.0, 0.0],
            [-22.0, 0.0, 25.0 + even(5, 8.0)],
        );
        let reference_from_image = at * spin * tilt * upright;
        let pose = reference_from_image * world.probe_from_image.inverse();
        let noise = seed.map(|s| Chance::new(s, i));
        let mut marks = Vec::new();
        for k in 0..5_u64 {
            let x = 5.0 + 8.0 * k as f64;
            // n (A (x, y, off)) = 30 for y, off the distance of the slice that echoes.
            let draw = |d: u64| noise.map_or(0.0, |c| c.normal(10 * k + d));
            let off = draw(0) * world.noise.point.elevation_mm;
            let on = |y: f64| {
                n.dot(&nalgebra::Vector3::from(
                    (reference_from_image * Point::new(x, y, off)).mm(),
                )) - 30.0
            };
            let y = on(0.0) / (on(0.0) - on(1.0));
            let px = [
                (x + draw(1) * world.noise.point.lateral_mm) / world.pixel_mm[0],
                (y + draw(2) * world.noise.point.axial_mm) / world.pixel_mm[1],
            ];
            marks.push(Mark { wire: 0, px });
        }
        Seen {
            number: i as u32,
            t_s: None,
            reference_from_probe: noise.map_or(pose, |c| world.told(pose, c)),
            marks,
        }
    };
    (0..count).map(one).collect()
}
