//! The coefficients of the cubic B-spline that goes through the voxels.
//!
//! Along each axis, with voxels s mirrored about the outermost centres, the coefficients solve `(c[i-1] + 4 c[i] + c[i+1])
//! / 6 = s[i]`. Solved by one pass up and one down with the pole z = sqrt(3) - 2 (Unser, Aldroubi and Eden 1993; starting
//! values after Thevenaz, Blu and Unser 2000, here as the exact finite sum). Computed in f64 and kept in `T`.

use bus::run::free_memory_bytes;
use bus::volume::{Layout, VolumeView};
use scene::Filter;

use super::ResliceError;

const POLE: f64 = -0.267_949_192_431_122_7;
/// Lines that are filtered at a time: one cache line of f64, so that strided axes read whole lines.
const LANES: usize = 8;

/// The coefficients, laid out like voxels.
#[derive(Debug, Clone)]
pub(super) struct Spline<T> {
    pub(super) layout: Layout,
    pub(super) coefficients: Vec<T>,
    /// The address of the voxels, which is compared and never followed.
    address: usize,
}

/// How coefficients are kept.
pub(super) trait Kept: Copy + Default {
    fn keep(value: f64) -> Self;
    fn value(self) -> f64;
}

impl Kept for f32 {
    fn keep(value: f64) -> Self {
        value as f32
    }
    fn value(self) -> f64 {
        f64::from(self)
    }
}

impl Kept for f64 {
    fn keep(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
}

/// Refuses a volume whose coefficients in `T` would take more than half of the memory that is free.
///
/// # Errors
/// [`ResliceError::Memory`].
pub(super) fn check_memory<T>(volume: &VolumeView<'_>) -> Result<(), ResliceError> {
    let (needed, allowed) = (
        volume.layout.stored() * size_of::<T>() as u64,
        // Where the system does not say what is free, nothing is refused.
        free_memory_bytes().unwrap_or(u64::MAX) / 2,
    );
    if needed <= allowed {
        return Ok(());
    }
    Err(ResliceError::Memory {
        filter: Filter::BSpline,
        needed,
        allowed,
    })
}

impl<T: Kept> Spline<T> {
    /// Filters the volume; `alive` is called between slices.
    pub(super) fn new(volume: &VolumeView<'_>, alive: &mut dyn FnMut()) -> Self {
        let layout = volume.layout.clone();
        let coefficients = volume.voxels.iter().map(|hu| T::keep(f64::from(*hu))).collect();
        let mut spline = Self {
            layout,
            coefficients,
            address: volume.voxels.as_ptr() as usize,
        };
        for axis in 0..3 {
            alive();
            spline.filter_axis(axis, alive);
        }
        spline
    }

    /// The coefficient of a voxel.
    pub(super) fn at(&self, voxel: [u32; 3]) -> T {
        self.coefficients[self.layout.offset(voxel)]
    }

    /// Whether it was made of `volume`, as long as that lies in memory: another one beside it lies elsewhere. Where one may have gone and
    /// another come to its place, [`super::Resampler::prepare`] is due.
    pub(super) fn is_of(&self, volume: &VolumeView<'_>) -> bool {
        self.address == volume.voxels.as_ptr() as usize && self.layout == *volume.layout
    }

    fn filter_axis(&mut self, axis: usize, alive: &mut dyn FnMut()) {
        // Eight lines at a time, neighbours along x where that is not the axis itself.
        let (across, outer) = [(1, 2), (0, 2), (0, 1)][axis];
        let [along, across, outer] = [axis, across, outer].map(|a| self.layout.table(a));
        let mut lines = vec![[0.0; LANES]; along.len()];
        for &o in outer {
            for starts in across.chunks(LANES) {
                let place = |i: usize, lane: usize| (o + starts[lane] + along[i]) as usize;
                for (i, line) in lines.iter_mut().enumerate() {
                    for (lane, value) in line[..starts.len()].iter_mut().enumerate() {
                        *value = self.coefficients[place(i, lane)].value();
                    }
                }
                // Lanes beyond the last line hold what was there before: solved as well, but not stored.
                solve(&mut lines);
                for (i, line) in lines.iter().enumerate() {
                    for (lane, value) in line[..starts.len()].iter().enumerate() {
                        self.coefficients[place(i, lane)] = T::keep(*value);
                    }
                }
            }
            alive();
        }
    }
}

/// From values to coefficients, in place, eight lines at a time.
fn solve(line: &mut [[f64; LANES]]) {
    let n = line.len();
    if n == 1 {
        // One voxel mirrored is a constant, whose coefficients are itself.
        return;
    }
    let start = causal_start(line);
    // The two passes below make 1/6 of a constant: the coefficients of a constant are itself.
    let gain = (1.0 - POLE) * (1.0 - 1.0 / POLE);
    line[0] = start;
    for i in 1..n {
        let before = line[i - 1];
        for (value, before) in line[i].iter_mut().zip(before) {
            *value += POLE * before;
        }
    }
    let (before, last) = (line[n - 2], line[n - 1]);
    // The downward pass begins with its exact value for a line mirrored about its last centre.
    let end = POLE / (POLE * POLE - 1.0);
    line[n - 1] = std::array::from_fn(|lane| end * (POLE * before[lane] + last[lane]));
    for i in (0..n - 1).rev() {
        let after = line[i + 1];
        for (value, after) in line[i].iter_mut().zip(after) {
            *value = POLE * (after - *value);
        }
    }
    line.iter_mut().flatten().for_each(|value| *value *= gain);
}

/// The sum over the mirrored line, `sum over k of z^|k| s[k]` on one side: periodic with 2 n - 2.
fn causal_start(line: &[[f64; LANES]]) -> [f64; LANES] {
    let n = line.len();
    let mut sum = [0.0; LANES];
    // Beyond 40 voxels the pole's power is below 1e-22.
    let mut power = 1.0;
    for values in line.iter().take(40.min(n)) {
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += power * value;
        }
        power *= POLE;
    }
    if n >= 40 {
        return sum;
    }
    for values in line[1..n - 1].iter().rev() {
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += power * value;
        }
        power *= POLE;
    }
    sum.map(|sum| sum / (1.0 - power))
}

#[cfg(test)]
mod tests {
    use super::super::reference::mirrored;
    use super::*;

    /// The definition, checked at every voxel of lines of every short length and one long one.
    #[test]
    fn coefficients_give_back_the_voxels() {
        for n in (1..50).chain([500]) {
            let value = |i: usize| ((i * 7919 + 13) % 4001) as f64 - 2000.0;
            let mut line: Vec<[f64; LANES]> = (0..n).map(|i| [value(i); LANES]).collect();
            solve(&mut line);
            for i in 0..n as i64 {
                let c = |i: i64| line[mirrored(i, n as i64)][3];
                let back = (c(i - 1) + 4.0 * c(i) + c(i + 1)) / 6.0;
                // The filter amplifies at most threefold; a few dozen roundings of 6000.
                assert!(
                    (back - value(i as usize)).abs() < 40.0 * 6000.0 * f64::EPSILON,
                    "{n} {i}"
                );
            }
        }
    }
}
