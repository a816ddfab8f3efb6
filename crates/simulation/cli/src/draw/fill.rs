//! Filling triangles with a number that runs linearly over them.

use picture::{Canvas, Rgb};

use super::colour::Ramp;

/// A corner: pixel, and the number there.
pub(super) type Corner = ([f64; 2], f64);

/// Fills a triangle, pixel centres inside it, turned either way.
pub(super) fn triangle(canvas: &mut Canvas, frame: &[f64; 4], ramp: &Ramp, corners: [Corner; 3]) {
    let [(p, a), (q, b), (r, c)] = corners;
    let cross = |o: [f64; 2], u: [f64; 2], v: [f64; 2]| (u[0] - o[0]) * (v[1] - o[1]) - (u[1] - o[1]) * (v[0] - o[0]);
    let area = cross(p, q, r);
    if !area.is_finite() || area == 0.0 {
        return;
    }
    let bounds = |axis: usize, low: f64, high: f64| {
        let (least, most) = (p[axis].min(q[axis]).min(r[axis]), p[axis].max(q[axis]).max(r[axis]));
        (least.max(low).ceil() as i64, most.min(high - 1.0).floor() as i64)
    };
    let ((left, right), (top, bottom)) = (bounds(0, frame[0], frame[2]), bounds(1, frame[1], frame[3]));
    let width = i64::from(canvas.width());
    // A hair beyond the edge, so that neighbours leave no gap.
    let slack = -1e-6;
    for y in top.max(0)..=bottom {
        for x in left.max(0)..=right {
            let at = [x as f64, y as f64];
            let (wp, wq) = (cross(q, r, at) / area, cross(r, p, at) / area);
            let wr = 1.0 - wp - wq;
            if wp >= slack && wq >= slack && wr >= slack {
                let Rgb(red, green, blue) = super::ink(ramp.colour(a * wp + b * wq + c * wr));
                let first = ((y * width + x) * 4) as usize;
                if let Some(pixel) = canvas.rgba_mut().get_mut(first..first + 3) {
                    pixel.copy_from_slice(&[red, green, blue]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_fill_a_square_without_a_gap() {
        for turned in [false, true] {
            let mut canvas = Canvas::new(30, 30);
            let ramp = Ramp::from_zero(1.0);
            let corner = |x: f64, y: f64| ([x, y], 0.5);
            let (a, b, c, d) = (
                corner(3.3, 4.1),
                corner(22.7, 5.9),
                corner(21.2, 24.4),
                corner(2.2, 23.3),
            );
            let frame = [0.0, 0.0, 30.0, 30.0];
            let order = |t: [Corner; 3]| if turned { [t[2], t[1], t[0]] } else { t };
            triangle(&mut canvas, &frame, &ramp, order([a, b, c]));
            triangle(&mut canvas, &frame, &ramp, order([a, c, d]));
            let Rgb(r, g, bl) = super::super::ink(ramp.colour(0.5));
            let filled = canvas.rgba().chunks_exact(4).filter(|p| p[..3] == [r, g, bl]).count();
            // Shoelace: area 362.6; the pixels on the border decide by their centres.
            assert!(filled.abs_diff(363) < 25, "{filled}");
            let row: Vec<bool> = (0..30).map(|x| canvas.rgba()[(14 * 30 + x) * 4] == r).collect();
            let first = row.iter().position(|f| *f).unwrap();
            let last = row.iter().rposition(|f| *f).unwrap();
            assert!(row[first..=last].iter().all(|f| *f), "{row:?}");
        }
    }

    #[test]
    fn what_is_far_away_or_no_number_costs_nothing() {
        let mut canvas = Canvas::new(4, 4);
        let frame = [0.0, 0.0, 4.0, 4.0];
        let ramp = Ramp::from_zero(1.0);
        triangle(
            &mut canvas,
            &frame,
            &ramp,
            [([1e12, 0.0], 0.0), ([2e12, 0.0], 0.0), ([1e12, 3e12], 0.0)],
        );
        triangle(
            &mut canvas,
            &frame,
            &ramp,
            [([f64::NAN, 0.0], 0.0), ([1.0, 0.0], 0.0), ([0.0, 1.0], 0.0)],
        );
        assert!(canvas.rgba().chunks_exact(4).all(|p| p[..3] == [0, 0, 0]));
    }
}
