//! Planes and balls of bone: where they are met is a line of algebra.

use ultrasound::{Beams, Level, Met, Pose, Scene, Settings, Shape, truth};

use super::{PIXEL, bone_in, brightest, image, linear, mean, straight};

const SOFT: f64 = 100.0;
const LEVEL: Level = Level {
    bone_hu: 300.0,
    speed_ratio: 1.0,
    gel_mm: 2.5,
};

/// A ball of bone under the middle of the face; `aside` of the image's plane.
fn ball(radius: f64, depth: f64, aside: f64) -> impl Fn([f64; 3]) -> f64 {
    move |[x, y, z]| {
        let off = [x - 20.0, y - depth, z - aside];
        bone_in(SOFT, off.iter().map(|part| part * part).sum::<f64>().sqrt() - radius)
    }
}

/// Where a beam that runs down at x meets the ball, closed form.
fn met(radius: f64, depth: f64, aside: f64, x: f64) -> f64 {
    depth - (radius * radius - aside * aside - (x - 20.0).powi(2)).sqrt()
}

#[test]
fn a_ball_is_brightest_where_the_beam_meets_it() {
    let (shape, settings) = (linear(), Settings::shallow());
    for (radius, depth) in [(12.0, 35.0), (20.0, 42.0)] {
        let grey = image(&shape, &settings, &ball(radius, depth, 0.0), &straight());
        for column in (100..=300).step_by(5) {
            let x = column as f64 * PIXEL;
            let within = (x - 20.0).abs() / radius;
            // Up to 45 degrees of slant.
            if within > 0.7 {
                continue;
            }
            let truth = met(radius, depth, 0.0, x);
            let (row, level) = brightest(&shape, &grey, column, 40);
            let off = row as f64 * PIXEL - truth;
            // Half of the pulse, a pixel, and what the beam's thickness adds: it is followed to 2 deviations, where the
            // ball lies deeper by e^2 / (2 R cos^3); its rays' mean is that of one deviation, sideways and across.
            let slant = (1.0 - within * within).powf(1.5);
            let deviation = settings
                .elevation
                .width_at(truth)
                .hypot(settings.lateral.width_at(truth))
                / 2.355;
            let bound = settings.pulse_mm / 2.0 + PIXEL + deviation.powi(2) / (2.0 * radius * slant);
            assert!(off.abs() < bound, "x {x}: {off} mm from {truth}, bound {bound}");
            assert!(level > 120, "x {x}: grey {level}");
        }
    }
}

#[test]
fn bone_aslant_across_the_image_is_shown_thicker_and_not_elsewhere() {
    let (shape, settings) = (linear(), Settings::shallow());
    // A plane through (y = 30, z = 0), tilted about the image's rows.
    let thickness = |tilt: f64| {
        let (sine, cosine) = tilt.sin_cos();
        let body = move |[_, y, z]: [f64; 3]| bone_in(SOFT, (30.0 - y) * cosine + z * sine);
        let grey = image(&shape, &settings, &body, &straight());
        let columns = (60..=340).step_by(4);
        let rows = columns.clone().map(|column| {
            let line = (250..360).map(|row| f64::from(grey[row * shape.columns() + column]));
            // Down to 6 dB below the brightest, in grey.
            let edge = line.clone().fold(0.0, f64::max) - 6.02 / settings.range_db * 255.0;
            let over: Vec<usize> = line
                .enumerate()
                .filter(|(_, grey)| *grey >= edge)
                .map(|(row, _)| row)
                .collect();
            (over[0] + 250, over[over.len() - 1] + 250)
        });
        let (first, last): (Vec<usize>, Vec<usize>) = rows.unzip();
        let mean = |rows: &[usize]| rows.iter().sum::<usize>() as f64 / rows.len() as f64 * PIXEL;
        (mean(&first), mean(&last))
    };
    let (flat, slanted) = (thickness(0.0), thickness(0.7));
    // Sound at a deviation's distance meets the plane tan 0.7 times as far above or below: FWHM of the beam times that,
    // beside the pulse's own (widths of Gaussians add by their squares), and the pulse's ring below.
    let wide = settings.elevation.width_at(30.0) * 0.7_f64.tan();
    let closed = wide.hypot(settings.pulse_mm);
    let found = slanted.1 - slanted.0;
    // The rays end at 2 deviations and the roughness is drawn once: within a third.
    assert!(
        (found / closed - 1.0).abs() < 0.34,
        "{found} mm thick, {closed} by the closed form"
    );
    assert!(found > 1.5 * (flat.1 - flat.0), "{flat:?} {slanted:?}");
    // The middle stays within half a pulse of the truth, 30 mm, though its ring is below.
    let middle = (slanted.0 + slanted.1) / 2.0;
    assert!((middle - 30.0).abs() < settings.pulse_mm, "{middle}");
}

#[test]
fn below_bone_there_is_shadow() {
    let (shape, settings) = (linear(), Settings::shallow());
    // Bone to the left of x = 20, at 25 mm; the same tissue goes on to its right.
    let body = |[x, y, _]: [f64; 3]| bone_in(SOFT, (25.0 - y).max(x - 20.0));
    let grey = image(&shape, &settings, &body, &straight());
    let above = mean(&shape, &grey, 20..180, 100..220);
    let below = mean(&shape, &grey, 20..180, 400..490);
    let beside = mean(&shape, &grey, 230..380, 400..490);
    // Grey ends at 0, 13 dB below the tissue's: what is left of it in the shadow is noise and haze of 15 mm and more below.
    assert!(below < above / 6.0 && below < beside / 6.0, "{above} {below} {beside}");
    assert!((above - beside).abs() < 6.0, "{above} {beside}");
    // Shadow is not black at once: something repeats below the bone.
    assert!(mean(&shape, &grey, 20..180, 275..330) > below + 2.0);
}

/// What lies d deep is drawn d / ratio deep: the echo takes 2 d / c, and the scanner takes 1540 m/s for c.
#[test]
fn a_wrong_speed_of_sound_stretches_depths() {
    let shape = linear();
    for (speed, depth) in [(1480.0, 25.0), (1540.0, 25.0), (1580.0, 30.0)] {
        let time = 2.0 * depth / speed;
        let drawn = 1540.0 * time / 2.0;
        let settings = Settings {
            speed_ratio: speed / 1540.0,
            ..Settings::shallow()
        };
        let body = |[_, y, _]: [f64; 3]| bone_in(SOFT, depth - y);
        let grey = image(&shape, &settings, &body, &straight());
        let rows = (40..360)
            .step_by(8)
            .map(|column| brightest(&shape, &grey, column, 60).0);
        let found = rows.sum::<usize>() as f64 / 40.0 * PIXEL;
        assert!(
            (found - drawn).abs() < settings.pulse_mm / 2.0 + PIXEL,
            "{found} for {drawn} at {speed} m/s"
        );
        let level = Level {
            speed_ratio: settings.speed_ratio,
            ..LEVEL
        };
        let truth = truth(&Scene::of(&body), &straight(), &shape, &level, 5).unwrap();
        let Met::Bone(crossing) = truth.beams[2] else {
            panic!("{truth:?}")
        };
        assert!((crossing.shown_mm - drawn).abs() < 1e-5 && (crossing.depth_mm - depth).abs() < 1e-5);
        assert!((crossing.pixel[1] * PIXEL - drawn).abs() < 1e-5 && (crossing.pixel[0] - 200.0).abs() < 1e-9);
    }
}

#[test]
fn the_truth_is_the_closed_form() {
    let shape = linear();
    let (radius, depth, aside) = (12.0, 35.0, 4.0);
    let body = ball(radius, depth, aside);
    let truth = truth(&Scene::of(&body), &straight(), &shape, &LEVEL, 81).unwrap();
    let mut seen = 0;
    for (beam, met_here) in truth.beams.iter().enumerate() {
        let x = beam as f64 * 0.5;
        let closed = met(radius, depth, aside, x);
        match met_here {
            Met::Bone(crossing) => {
                seen += 1;
                // 0.1 mm / 2^20, but that the ball's ramp is flat at its rim.
                assert!((crossing.depth_mm - closed).abs() < 1e-5, "{crossing:?} {closed}");
                let normal = [x - 20.0, closed - depth, -aside].map(|part| part / radius);
                let incidence = normal[1].abs().acos();
                assert!(
                    (crossing.incidence - incidence).abs() < 1e-3,
                    "{crossing:?} {incidence}"
                );
            }
            Met::Nothing => assert!(closed.is_nan(), "x {x}: missed at {closed}"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(seen, 45, "of beams within 11.31 mm of the middle");
}

/// The same ball through a curved array, whose pose is turned and shifted: the ray meets it where the algebra says.
#[test]
fn a_curved_array_meets_a_ball_where_its_rays_do() {
    let beams = Beams::Convex {
        centre_mm: [40.0, -35.0],
        radius_mm: 40.0,
        half_angle: 0.6,
    };
    let shape = Shape::new([400, 400], [0.2; 2], beams, 70.0).unwrap();
    let settings = Settings {
        pulse_mm: 0.7,
        ..Settings::deep()
    };
    let (c, s) = (0.8, 0.6);
    let pose = Pose::new([10.0, -20.0, 5.0], [c, 0.0, s], [0.0, 1.0, 0.0]).unwrap();
    let centre = pose.place([43.0, 45.0]);
    let radius = 13.0;
    let body = move |place: [f64; 3]| {
        let off: f64 = (0..3).map(|i| (place[i] - centre[i]).powi(2)).sum();
        bone_in(SOFT, off.sqrt() - radius)
    };
    let grey = image(&shape, &settings, &body, &pose);
    let mut offs = Vec::new();
    for share in (0..60).map(|i| 0.2 + 0.01 * f64::from(i)) {
        let (face, direction) = shape.along(share, 0.0);
        // |face + t direction - centre|^2 = radius^2, the nearer root.
        let to = [43.0 - face[0], 45.0 - face[1]];
        let along = to[0] * direction[0] + to[1] * direction[1];
        let rest = radius * radius - (to[0] * to[0] + to[1] * to[1] - along * along);
        if rest < (0.75 * radius).powi(2) {
            continue;
        }
        let closed = along - rest.sqrt();
        let at = |depth: f64| {
            let pixel = shape.pixel_at(shape.along(share, depth).0);
            grey[pixel[1].round() as usize * 400 + pixel[0].round() as usize]
        };
        let depths = (0..400).map(|i| 8.0 + 0.1 * f64::from(i));
        let found = depths.max_by_key(|&depth| at(depth)).unwrap();
        offs.push(found - closed);
    }
    assert!(offs.len() > 15, "{}", offs.len());
    let deviation = settings.elevation.width_at(32.0).hypot(settings.lateral.width_at(32.0)) / 2.355;
    // A pixel's half diagonal comes twice: where the grey is read, and its own place.
    let bound = settings.pulse_mm / 2.0 + 0.3 + deviation.powi(2) / (2.0 * radius * 0.75_f64.powi(3));
    assert!(offs.iter().all(|off| off.abs() < bound), "{bound} {offs:?}");
}
