//! How good a pose is at the tip, and how that looks on an image.

use std::f64::consts::TAU;

use bus::clock;
use bus::message::ToolPose;
use geometry::{Ct, Direction, Point, Rigid, SlicePlane, Tool, Uncertain};

/// The 95 % point of chi-squared with two degrees of freedom, `-2 ln 0.05`.
const CHI_SQUARED_95: f64 = 5.991_464_547_107_979;
/// Sides of the polygon that stands for an ellipse: it is off by 1 / 800 of its size.
const SIDES: usize = 64;

/// What a pose says of its own quality.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Predicted error at the tip, 95 %, mm; `None`: it is not known.
    tip_95_mm: Option<f64>,
    /// Covariance of the tip's place in the CT, mm^2, where the error is known.
    covariance_mm2: [[f64; 3]; 3],
    delay_ns: i64,
}

impl Accuracy {
    /// Of a message whose pose was found to be `pose`.
    pub fn of(message: &ToolPose, pose: Rigid<Ct, Tool>) -> Self {
        let at_tip = Uncertain::from_upper(pose, message.covariance)
            .map(|uncertain| (uncertain * Point::<Tool>::new(0.0, 0.0, 0.0)).covariance());
        let covariance_mm2 = at_tip.map_or([[0.0; 3]; 3], |c| {
            std::array::from_fn(|i| std::array::from_fn(|j| c[(i, j)]))
        });
        Self {
            tip_95_mm: message.tip_95_mm(),
            covariance_mm2,
            delay_ns: message.delay_ns,
        }
    }

    /// The error at the tip in words.
    pub(crate) fn words(&self) -> String {
        match self.tip_95_mm {
            // `±0.0 mm` would say that there is none.
            Some(mm) if mm < 0.05 => "tip < 0.1 mm (95 %)".to_owned(),
            Some(mm) if mm >= 9.95 => format!("tip ±{mm:.0} mm (95 %)"),
            Some(mm) => format!("tip ±{mm:.1} mm (95 %)"),
            None => "tip error not known".to_owned(),
        }
    }

    /// The delay of a smoothed pose in words.
    pub(crate) fn delay_words(&self) -> Option<String> {
        (self.delay_ns > 0).then(|| format!("SMOOTHED, {:.0} ms late", clock::ms(self.delay_ns)))
    }

    /// The ellipse on the image that holds the projection of the tip with 95 %, about the tip's pixel `tip`: a closed polygon.
    /// Where no covariance came with the prediction, the circle of its radius. `None` where nothing is known.
    pub(crate) fn ellipse(&self, plane: &SlicePlane, tip: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        let circle_mm = self.tip_95_mm?;
        let known = ellipse_95(&self.covariance_mm2, plane, tip);
        Some(known.unwrap_or_else(|| polygon(tip, [circle_mm / plane.pixel_mm(); 2], 0.0)))
    }
}

/// The ellipse on the image that holds the projection of a place with 95 %, about its pixel `at`: a closed polygon. `None` where its covariance, mm^2, is
/// none along the image.
pub(crate) fn ellipse_95(covariance_mm2: &[[f64; 3]; 3], plane: &SlicePlane, at: [f64; 2]) -> Option<Vec<[f64; 2]>> {
    let (right, down) = (plane.right(), plane.down());
    let between = |u, v| between(covariance_mm2, u, v);
    let [a, b, c] = [between(right, right), between(right, down), between(down, down)];
    // The axes: half the trace plus and minus the radius of Mohr's circle, the first at half its angle.
    let (mean, radius) = (0.5 * (a + c), (0.5 * (a - c)).hypot(b));
    let turn = 0.5 * b.atan2(0.5 * (a - c));
    let half = |variance: f64| (variance * CHI_SQUARED_95).sqrt() / plane.pixel_mm();
    (mean > 0.0).then(|| polygon(at, [half(mean + radius), half((mean - radius).max(0.0))], turn))
}

/// An ellipse about `at` with these half axes, pixels, the first turned by so much.
fn polygon(at: [f64; 2], [long, short]: [f64; 2], turn: f64) -> Vec<[f64; 2]> {
    let (turn_s, turn_c) = turn.sin_cos();
    let corner = |i: usize| {
        let (s, c) = (TAU * i as f64 / SIDES as f64).sin_cos();
        let (x, y) = (long * c, short * s);
        [at[0] + x * turn_c - y * turn_s, at[1] + x * turn_s + y * turn_c]
    };
    (0..=SIDES).map(corner).collect()
}

/// `u^T C v`, mm^2.
fn between(covariance_mm2: &[[f64; 3]; 3], u: Direction<Ct>, v: Direction<Ct>) -> f64 {
    let (u, v) = (u.components(), v.components());
    let row = |i: usize| (0..3).map(|j| covariance_mm2[i][j] * v[j]).sum::<f64>();
    (0..3).map(|i| u[i] * row(i)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(variances: [f64; 3]) -> ToolPose {
        let mut message = ToolPose {
            tip_mm: 0.93,
            flags: ToolPose::TIP_KNOWN,
            delay_ns: 35_000_000,
            ..ToolPose::EMPTY
        };
        for (place, variance) in [15, 18, 20].into_iter().zip(variances) {
            message.covariance[place] = variance;
        }
        message
    }

    fn plane() -> SlicePlane {
        let axes = [Direction::X, -Direction::Z];
        SlicePlane::centred(Point::new(0.0, 0.0, 0.0), axes, 0.5, [512, 512]).unwrap()
    }

    /// Width and height of a polygon, pixels.
    fn extent(polygon: &[[f64; 2]]) -> [f64; 2] {
        [0, 1].map(|i| {
            let values = || polygon.iter().map(|p| p[i]);
            values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
        })
    }

    #[test]
    fn the_ellipse_is_the_projection_of_the_covariance_at_true_scale() {
        let of = |message: &ToolPose| Accuracy::of(message, Rigid::identity()).ellipse(&plane(), [9.0, 7.0]);
        // Deviations 0.3 mm along x and 0.1 mm along z; y is not seen. Pixels of 0.5 mm, 2.4477 deviations to each side.
        let [width, height] = extent(&of(&message([0.09, 4.0, 0.01])).unwrap());
        let side = 2.0 * CHI_SQUARED_95.sqrt() / 0.5;
        // Corners of the polygon lie on the ellipse, its ends among them.
        assert!(
            (width - 0.3 * side).abs() < 1e-9 && (height - 0.1 * side).abs() < 1e-9,
            "{width} {height}"
        );
        let [width, height] = extent(&of(&message([0.0; 3])).unwrap());
        assert!((width - 2.0 * 0.93 / 0.5).abs() < 1e-9 && (height - width).abs() < 1e-9);
        assert_eq!(of(&ToolPose::EMPTY), None);
    }

    #[test]
    fn a_correlation_turns_the_ellipse() {
        let mut message = message([0.04, 0.0, 0.04]);
        // Between x and z: the long axis is x + z, which on this image goes to the right and up.
        message.covariance[17] = 0.03;
        let polygon = Accuracy::of(&message, Rigid::identity())
            .ellipse(&plane(), [0.0, 0.0])
            .unwrap();
        let [x, y] = polygon[0];
        let long = (0.07 * CHI_SQUARED_95).sqrt() / 0.5;
        assert!((x.hypot(y) - long).abs() < 1e-9 && (x + y).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn words_say_what_is_known() {
        let accuracy = Accuracy::of(&message([0.1; 3]), Rigid::identity());
        assert_eq!(accuracy.words(), "tip ±0.9 mm (95 %)");
        assert_eq!(accuracy.delay_words().unwrap(), "SMOOTHED, 35 ms late");
        let small = ToolPose {
            tip_mm: 0.04,
            ..message([0.1; 3])
        };
        assert_eq!(Accuracy::of(&small, Rigid::identity()).words(), "tip < 0.1 mm (95 %)");
        let unknown = Accuracy::of(&ToolPose::EMPTY, Rigid::identity());
        assert_eq!(
            (unknown.words().as_str(), unknown.delay_words()),
            ("tip error not known", None)
        );
        for bad in [f64::NAN, -1.0, f64::INFINITY] {
            let message = ToolPose {
                tip_mm: bad,
                ..message([0.1; 3])
            };
            assert_eq!(Accuracy::of(&message, Rigid::identity()).words(), "tip error not known");
        }
    }
}
