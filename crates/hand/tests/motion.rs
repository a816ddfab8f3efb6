//! Strokes, tremor, the tube in its entry, and errors, against closed forms.

use chance::Chance;
use geometry::{Ct, Direction, Point, Tool};
use guidance::sight::Covariance;
use hand::{Approach, Errors, Human, PEAK, Posture, Stroke, Task, Tremor, part, speed};

fn stroke() -> Stroke {
    Stroke {
        begin_s: 2.0,
        duration_s: 0.5,
        from: Posture {
            tilt: [0.1, -0.05],
            depth_mm: 10.0,
        },
        to: Posture {
            tilt: [0.0, 0.02],
            depth_mm: 40.0,
        },
    }
}

#[test]
fn a_stroke_goes_from_rest_to_rest_and_is_half_done_at_half_time() {
    assert_eq!([part(0.0), part(0.5), part(1.0)], [0.0, 0.5, 1.0]);
    assert_eq!([speed(0.0), speed(1.0)], [0.0, 0.0]);
    assert_eq!(speed(0.5), PEAK);
    let peak = (0..=1000).map(|k| speed(f64::from(k) / 1000.0)).fold(0.0, f64::max);
    assert_eq!(peak, PEAK);
    let stroke = stroke();
    assert_eq!(stroke.at(0.0), stroke.from);
    assert_eq!(stroke.at(9.0), stroke.to);
    assert!((stroke.at(2.25).depth_mm - 25.0).abs() < 1e-12);
}

#[test]
fn speed_is_the_derivative_and_no_other_end_has_a_jerk() {
    let h = 1e-4;
    for k in 1..100 {
        let u = f64::from(k) / 100.0;
        // Of a central difference: h^2 / 6 times the third derivative, which is at most 60; and rounding.
        let slope = (part(u + h) - part(u - h)) / (2.0 * h);
        assert!((slope - speed(u)).abs() < 10.0 * h * h + 1e-11, "{u}: {slope}");
        // The sixth derivative vanishes: that is what makes the mean square jerk least (Flash and Hogan 1985, equation
        // A.6).
        let d = 0.005;
        let weights = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
        let sixth: f64 = (0..7).map(|i| weights[i] * part(u + d * (i as f64 - 3.0))).sum();
        if (0.02..=0.98).contains(&u) {
            assert!(sixth.abs() < 1e-13, "{u}: {sixth}");
        }
    }
    // And so do speed and acceleration at both ends.
    for end in [h, 1.0 - h] {
        assert!((speed(end + h) - speed(end - h)).abs() / (2.0 * h) < 100.0 * h);
    }
}

#[test]
fn a_tremor_has_the_root_mean_square_and_the_band_that_are_said() {
    let (count, step_s) = (200_000, 0.003_7);
    for seed in 0..3 {
        let tremor = Tremor::new(0.07, [8.0, 12.0], Chance::new(seed, 0));
        for axis in 0..3 {
            let x: Vec<f64> = (0..count).map(|k| tremor.at(f64::from(k) * step_s)[axis]).collect();
            let rms = (x.iter().map(|x| x * x).sum::<f64>() / f64::from(count)).sqrt();
            // Over 740 s: what sines of frequencies 0.06 Hz apart at least leave, 2 A^2 / (2 pi 0.06 740), and their
            // own, far less.
            assert!((rms / 0.07 - 1.0).abs() < 0.02, "{rms}");
            let crossings = x.windows(2).filter(|w| w[0] <= 0.0 && w[1] > 0.0).count();
            let hz = crossings as f64 / (f64::from(count) * step_s);
            assert!((8.0..=12.0).contains(&hz), "{hz} Hz");
        }
    }
}

#[test]
fn a_tube_turns_about_its_entry_until_the_point_has_moved() {
    for number in 0..200 {
        let task = Task::draw(3, number, Approach::Oblique);
        let (way, start) = (task.way, task.start);
        let axis = way.axis(&start);
        let [right, up] = hand::upright_axes(axis);
        let beside = right * 3.0 + up * -2.0;
        let tilt = way.turned(&start, beside, 90.0);
        let to = Posture { tilt, ..start };
        let expected = way.entry() + axis * 90.0 + beside;
        // The point lies on the new axis.
        let off = (expected - way.entry()).cross(way.axis(&to).vector()).norm();
        assert!(off < 1e-12 * 90.0, "{off}");
        let back = way.moved(&start, way.of_hand(&start, &to));
        assert!((0..2).all(|k| (back.tilt[k] - to.tilt[k]).abs() < 1e-14));
        let pose = way.pose(&start).unwrap();
        let tip = pose * Point::<Tool>::new(0.0, 0.0, 0.0);
        assert!(tip.distance(way.entry() + axis * start.depth_mm) < 1e-12 * 200.0);
        assert!((pose * Direction::<Tool>::Z).dot(axis) > 1.0 - 1e-12);
        let tilted = (axis.cross((task.aim.target - way.entry()).direction().unwrap()))
            .norm()
            .asin();
        assert!((4.0..=8.0).contains(&tilted.to_degrees()), "{}", tilted.to_degrees());
    }
}

/// What is drawn is what is stated: the mean square over many frames.
#[test]
fn measured_poses_err_as_their_covariance_says() {
    let task = Task::draw(1, 1, Approach::InPlane);
    let errors = Errors::noisy(0.3);
    let pose = task.way.pose(&task.start).unwrap();
    let target = task.aim.target;
    let tip: Point<Ct> = pose * Point::<Tool>::new(0.0, 0.0, 0.0);
    let count = 20_000;
    let mut square = 0.0;
    for k in 0..count {
        let motion = errors.of_registration(target, Chance::new(7, k)) * errors.of_frame(tip, Chance::new(8, k));
        square += (motion * target).distance(target).powi(2) / count as f64;
    }
    let Covariance::Upper(upper) = errors.stated(pose, target) else {
        panic!("no covariance");
    };
    let stated = geometry::Uncertain::from_upper(pose, upper).unwrap() * (pose.inverse() * target);
    // Five standard errors of a mean square of at least one effective normal component: 5 sqrt(2 / n).
    assert!((square / stated.covariance().trace() - 1.0).abs() < 5.0 * (2.0 / count as f64).sqrt());
    let half = Errors {
        understated: 2.0,
        ..errors
    };
    let Covariance::Upper(less) = half.stated(pose, target) else {
        panic!("no covariance");
    };
    assert!((0..21).all(|k| (upper[k] - 4.0 * less[k]).abs() <= 1e-12 * upper[k].abs() + 1e-15));
    assert_eq!(Errors::NONE.stated(pose, target), Covariance::Exact);
}

/// 0.1 s for a bit of 2 / (4.13 x 0.07), whatever the length; pushing has a limit besides.
#[test]
fn strokes_take_as_long_as_is_said() {
    let human = Human::default();
    assert!((human.stroke_s(0.0) - 0.278_9).abs() < 1e-4, "{}", human.stroke_s(0.0));
    assert_eq!(human.stroke_s(1.0), human.stroke_s(0.0));
    assert_eq!(human.stroke_s(-40.0), 2.0);
    assert_eq!(Human::steady().stroke_s(0.0), human.stroke_s(0.0));
}
