//! What lies outside the examination is hatched: black would be taken for air.

use geometry::{SlicePlane, VolumeGrid};
use picture::{Canvas, Rgb};

/// The stripes and the ground between them: no grey of a slice, and too dark to draw the eye.
const STRIPE: Rgb = Rgb(64, 72, 96);
const GROUND: Rgb = Rgb(12, 14, 22);
/// From stripe to stripe along a row, and how wide one is, pixels.
const PERIOD: usize = 12;
const WIDTH: usize = 3;

/// Hatches the pixels of a slice of `thickness_mm` (0: a thin one) whose centre is outside the volume; through a slab, those that
/// are outside at its middle and at both its ends. The rule is that of sampling: an index v is inside where -1/2 <= v <= n - 1/2
/// on every axis.
pub(crate) fn hatch(canvas: &mut Canvas, plane: &SlicePlane, grid: &VolumeGrid, thickness_mm: f64) {
    let depths: &[f64] = if thickness_mm > 0.0 { &[-0.5, 0.0, 0.5] } else { &[0.0] };
    let width = canvas.width() as usize;
    for row in 0..canvas.height() as usize {
        let line = &mut canvas.rgba_mut()[row * width * 4..(row + 1) * width * 4];
        let inside = depths
            .iter()
            .map(|part| columns(plane, grid, row, part * thickness_mm, width));
        // Inside at one depth is enough. A box is convex: columns between those of two depths are inside at a depth between.
        let inside = inside
            .filter(|(from, to)| from < to)
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (from, to) = inside.unwrap_or((width, width));
        stripe(&mut line[..from * 4], row, 0);
        stripe(&mut line[to * 4..], row, to);
    }
}

/// Hatches the whole image: nothing is known of it.
pub(crate) fn hatch_all(canvas: &mut Canvas) {
    let width = canvas.width() as usize;
    for (row, line) in canvas.rgba_mut().chunks_exact_mut(width * 4).enumerate() {
        stripe(line, row, 0);
    }
}

/// The columns of `row` whose centres, moved by `depth_mm` into the screen, lie in the volume: the first, and the one behind the
/// last.
fn columns(plane: &SlicePlane, grid: &VolumeGrid, row: usize, depth_mm: f64, width: usize) -> (usize, usize) {
    let shift = plane.into_screen() * depth_mm;
    let at = |x: f64| (grid.voxel_from_ct() * (plane.point(x, row as f64) + shift)).mm();
    let (first, last) = (at(0.0), at(width as f64));
    let (mut low, mut high) = (0.0_f64, width as f64 - 1.0);
    for axis in 0..3 {
        let (start, step) = (first[axis], (last[axis] - first[axis]) / width as f64);
        let bounds = [-0.5, f64::from(grid.dims()[axis]) - 0.5];
        if step == 0.0 {
            if start < bounds[0] || start > bounds[1] {
                return (width, width);
            }
            continue;
        }
        let [a, b] = bounds.map(|bound| (bound - start) / step);
        low = low.max(a.min(b));
        high = high.min(a.max(b));
    }
    match low <= high {
        true => (low.ceil() as usize, (high.floor() as usize + 1).min(width)),
        false => (width, width),
    }
}

fn stripe(pixels: &mut [u8], row: usize, first: usize) {
    for (i, pixel) in pixels.chunks_exact_mut(4).enumerate() {
        let Rgb(r, g, b) = if (first + i + row) % PERIOD < WIDTH {
            STRIPE
        } else {
            GROUND
        };
        pixel.copy_from_slice(&[r, g, b, 255]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Affine, Direction, Point, Rigid, Tool, Vector};
    use proptest::prelude::*;

    fn is_hatched(canvas: &Canvas, x: usize, y: usize) -> bool {
        let at = (y * canvas.width() as usize + x) * 4;
        canvas.rgba()[at..at + 3] != [200; 3]
    }

    /// Whether the grid, 0.05 of a voxel larger on all sides, holds `p`.
    fn near(grid: &VolumeGrid, p: Point<geometry::Ct>) -> bool {
        let voxel = (grid.voxel_from_ct() * p).mm();
        voxel
            .into_iter()
            .zip(grid.dims())
            .all(|(v, n)| (-0.55..=f64::from(n) - 0.45).contains(&v))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Each pixel against the grid's own answer at its centre; of a slab of 4 mm, a walk along the line of sight.
        #[test]
        fn a_pixel_is_hatched_where_its_point_is_outside(
            turn in prop::array::uniform3(-3.0..3.0), centre in prop::array::uniform3(-30.0..60.0), slab in prop::bool::ANY,
        ) {
            let affine = Affine::from_rows([[1.0, 0.2, 0.0, 0.0], [0.0, 0.9, 0.0, 3.0], [0.0, 0.1, 2.0, -5.0]]);
            let grid = VolumeGrid::checked([40, 30, 12], affine).unwrap();
            let rigid: Rigid<geometry::Ct, Tool> =
                Rigid::from_rotation_vector(Vector::new(turn[0], turn[1], turn[2]), Vector::new(0.0, 0.0, 0.0)).unwrap();
            let axes = [rigid * Direction::<Tool>::X, rigid * Direction::<Tool>::Y];
            let centre = Point::new(centre[0], centre[1], centre[2]);
            let plane = SlicePlane::centred(centre, axes, 0.9, [64, 48]).unwrap();
            let mut canvas = Canvas::new(64, 48);
            canvas.fill([0.0, 0.0], [64.0, 48.0], Rgb(200, 200, 200), 255);
            let thickness = if slab { 4.0 } else { 0.0 };
            hatch(&mut canvas, &plane, &grid, thickness);
            for y in 0..48 {
                for x in 0..64 {
                    let at = plane.point(x as f64, y as f64);
                    let holds = |d: f64, e: f64| grid.holds(at + plane.into_screen() * d + Vector::new(e, e, e));
                    // Within 1e-9 mm of the border rounding decides.
                    let all = |inside: bool| move |d: f64| [-1e-9, 1e-9].iter().all(|e| holds(d, *e) == inside);
                    let depths = [-0.5, 0.0, 0.5].map(|part| part * thickness);
                    if depths.into_iter().any(all(true)) {
                        prop_assert!(!is_hatched(&canvas, x, y), "{x} {y}");
                    }
                    if !slab && all(false)(0.0) {
                        prop_assert!(is_hatched(&canvas, x, y), "{x} {y}");
                    }
                    let through = (-200..=200).map(|i| thickness * f64::from(i) / 400.0);
                    if slab && !is_hatched(&canvas, x, y) {
                        // Beside an edge of the box less than a step of 0.02 mm may be inside.
                        let near = through.into_iter().any(|d| near(&grid, at + plane.into_screen() * d));
                        prop_assert!(near, "{x} {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn far_planes_are_hatched_everywhere() {
        let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
        let grid = VolumeGrid::checked([10, 10, 10], affine).unwrap();
        for x in [1e3, 1e5, -1e5] {
            let plane =
                SlicePlane::centred(Point::new(x, 0.0, 0.0), [Direction::X, Direction::Y], 1.0, [32, 32]).unwrap();
            let mut canvas = Canvas::new(32, 32);
            canvas.fill([0.0, 0.0], [32.0, 32.0], Rgb(200, 200, 200), 255);
            hatch(&mut canvas, &plane, &grid, 0.0);
            assert!((0..32 * 32).all(|i| is_hatched(&canvas, i % 32, i / 32)), "{x}");
        }
    }
}
