//! From places in the scene to pixels, and back.

use nalgebra::Vector2;

/// What part of the scene a picture shows, and where on it. Ordinates grow upwards in the scene, downwards in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct View {
    /// The middle of what is shown.
    middle: Vector2<f64>,
    /// Its pixel.
    centre: [f64; 2],
    /// Pixels by length.
    pub(crate) scale: f64,
    /// Left, top, right, bottom pixel of what is drawn on.
    pub(crate) frame: [f64; 4],
}

impl View {
    /// Fits the box from `low` to `high` into a frame of pixels.
    pub(crate) fn new([low, high]: [Vector2<f64>; 2], frame: [f64; 4]) -> Self {
        let [left, top, right, bottom] = frame;
        let size = (high - low).map(|s| s.max(f64::MIN_POSITIVE));
        let scale = ((right - left) / size.x).min((bottom - top) / size.y);
        Self {
            middle: (low + high) * 0.5,
            centre: [0.5 * (left + right), 0.5 * (top + bottom)],
            scale,
            frame,
        }
    }

    /// The pixel of a place.
    pub(crate) fn pixel(&self, at: Vector2<f64>) -> [f64; 2] {
        let from = (at - self.middle) * self.scale;
        [self.centre[0] + from.x, self.centre[1] - from.y]
    }

    /// The place of a pixel.
    pub(crate) fn place(&self, [x, y]: [f64; 2]) -> Vector2<f64> {
        self.middle + Vector2::new(x - self.centre[0], self.centre[1] - y) / self.scale
    }

    /// The part of the frame that lies in `<x, normal> <= offset`, as pixels.
    pub(crate) fn half_plane(&self, normal: Vector2<f64>, offset: f64) -> Vec<[f64; 2]> {
        let [left, top, right, bottom] = self.frame;
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]].map(|p| self.place(p));
        let height = |p: &Vector2<f64>| p.dot(&normal) - offset;
        let mut clipped = Vec::new();
        for (k, p) in corners.iter().enumerate() {
            let q = &corners[(k + 1) % 4];
            let (a, b) = (height(p), height(q));
            if a <= 0.0 {
                clipped.push(self.pixel(*p));
            }
            if (a < 0.0) != (b < 0.0) {
                clipped.push(self.pixel(p + (q - p) * (a / (a - b))));
            }
        }
        clipped
    }
}

/// A round length near a fifth of what is shown: 1, 2 or 5 times a power of ten.
pub(crate) fn round_length(shown: f64) -> f64 {
    let raw = 0.2 * shown;
    let power = 10_f64.powf(raw.log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|d| d * power <= raw);
    digit.unwrap_or(1.0) * power
}

/// A number in a few characters.
pub(crate) fn short(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{x:.1e}");
    }
    let digits = (2 - size.log10().floor() as i32).clamp(0, 5) as usize;
    let text = format!("{x:.digits$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_pixels_are_inverse_and_upright() {
        let view = View::new(
            [Vector2::new(-1.0, 0.0), Vector2::new(3.0, 1.0)],
            [10.0, 20.0, 210.0, 220.0],
        );
        assert_eq!(view.scale, 50.0);
        assert_eq!(view.pixel(Vector2::new(1.0, 0.5)), [110.0, 120.0]);
        assert!(view.pixel(Vector2::new(1.0, 1.0))[1] < 120.0);
        let at = Vector2::new(0.3, 0.7);
        assert!((view.place(view.pixel(at)) - at).norm() < 1e-14);
    }

    #[test]
    fn a_half_plane_is_cut_to_the_frame() {
        let view = View::new(
            [Vector2::new(0.0, 0.0), Vector2::new(1.0, 1.0)],
            [0.0, 0.0, 100.0, 100.0],
        );
        let floor = view.half_plane(Vector2::y(), 0.25);
        let expected = [[100.0, 75.0], [100.0, 100.0], [0.0, 100.0], [0.0, 75.0]];
        assert_eq!(floor.len(), 4);
        assert!(
            floor
                .iter()
                .zip(expected)
                .all(|(p, q)| (p[0] - q[0]).abs() + (p[1] - q[1]).abs() < 1e-9),
            "{floor:?}"
        );
        assert!(view.half_plane(Vector2::y(), -1.0).is_empty());
        assert_eq!(view.half_plane(Vector2::y(), 2.0).len(), 4);
    }

    #[test]
    fn numbers_are_short_and_lengths_round() {
        let all = [
            (0.0, "0"),
            (1.5, "1.5"),
            (0.012_345, "0.0123"),
            (123.456, "123"),
            (1.0, "1"),
            (-2.5e-6, "-2.5e-6"),
        ];
        for (x, text) in all {
            assert_eq!(short(x), text);
        }
        for (shown, round) in [(10.0, 2.0), (3.0, 0.5), (0.6, 0.1), (6e-9, 1e-9)] {
            assert!((round_length(shown) / round - 1.0_f64).abs() < 1e-12, "{shown}");
        }
    }
}
