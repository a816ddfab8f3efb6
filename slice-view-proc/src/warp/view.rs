//! The plane as numbers.

use geometry::SlicePlane;

/// From the CT's frame to columns, rows and mm behind the plane, and back.
#[derive(Debug)]
pub(super) struct View {
    origin: [f64; 3],
    axes: [[f64; 3]; 3],
    pub(super) pixel_mm: f64,
    pub(super) size: [f64; 2],
}

impl View {
    pub(super) fn of(plane: &SlicePlane) -> Self {
        let axes = [plane.right(), plane.down(), plane.into_screen()];
        Self {
            origin: plane.origin().mm(),
            axes: axes.map(|axis| axis.components()),
            pixel_mm: plane.pixel_mm(),
            size: plane.size().map(f64::from),
        }
    }

    #[inline(always)]
    pub(super) fn seen(&self, place: [f32; 3]) -> [f64; 3] {
        let (right, down) = (self.along(0, place), self.along(1, place));
        [right / self.pixel_mm, down / self.pixel_mm, self.along(2, place)]
    }

    /// Mm behind the plane: the same bits as those of [`Self::seen`].
    #[inline(always)]
    pub(super) fn behind(&self, place: [f32; 3]) -> f64 {
        self.along(2, place)
    }

    #[inline(always)]
    fn along(&self, axis: usize, place: [f32; 3]) -> f64 {
        let ([a, b, c], [x, y, z]) = (self.axes[axis], self.origin);
        a * (f64::from(place[0]) - x) + b * (f64::from(place[1]) - y) + c * (f64::from(place[2]) - z)
    }

    #[inline(always)]
    pub(super) fn place(&self, column: usize, row: usize) -> [f64; 3] {
        let (x, y) = (column as f64 * self.pixel_mm, row as f64 * self.pixel_mm);
        let ([a, b, c], [right, down, _]) = (self.origin, &self.axes);
        [
            a + right[0] * x + down[0] * y,
            b + right[1] * x + down[1] * y,
            c + right[2] * x + down[2] * y,
        ]
    }

    /// The places of pixels of a row from `first` on, as [`Self::place`] has them.
    #[inline(always)]
    pub(super) fn fill(&self, first: usize, row: usize, places: &mut [[f32; 3]]) {
        let y = row as f64 * self.pixel_mm;
        let origin: [f64; 24] = std::array::from_fn(|k| self.origin[k % 3]);
        let right: [f64; 24] = std::array::from_fn(|k| self.axes[0][k % 3]);
        let down: [f64; 24] = std::array::from_fn(|k| self.axes[1][k % 3] * y);
        let step: [f64; 24] = std::array::from_fn(|k| (k / 3) as f64);
        let (eights, rest) = places.as_chunks_mut::<8>();
        for (k, eight) in eights.iter_mut().enumerate() {
            let from = (first + 8 * k) as f64;
            let flat: &mut [f32] = eight.as_flattened_mut();
            for ((((place, origin), right), down), step) in
                flat.iter_mut().zip(&origin).zip(&right).zip(&down).zip(&step)
            {
                *place = (origin + right * ((from + step) * self.pixel_mm) + down) as f32;
            }
        }
        let from = first + 8 * eights.len();
        for (column, place) in (from..).zip(rest) {
            *place = self.place(column, row).map(|x| x as f32);
        }
    }

    /// The columns of a row whose places lie in a box, and some at its borders.
    #[inline(always)]
    pub(super) fn within(&self, [low, high]: [[f64; 3]; 2], row: usize) -> [usize; 2] {
        let from = self.place(0, row);
        let mut ends = [0.0_f64, self.size[0]];
        for a in 0..3 {
            let step = self.axes[0][a] * self.pixel_mm;
            let (first, last) = ((low[a] - from[a]) / step, (high[a] - from[a]) / step);
            // Along the box's face the quotients are of no use.
            if step.abs() > 1e-6 * self.pixel_mm {
                ends = [ends[0].max(first.min(last) - 1.0), ends[1].min(first.max(last) + 2.0)];
            }
        }
        [ends[0] as usize, ends[1].max(0.0) as usize]
    }
}
