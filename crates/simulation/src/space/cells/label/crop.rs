//! The part of a label map about a label.

use nalgebra::Vector3;

use super::super::field::Field;
use super::super::spline::Spline;
use super::{Facts, LabelMap};

/// A box of voxels that may reach beyond the map.
pub(super) struct Crop {
    /// First voxel of the label, last one, and how far the box goes beyond.
    first: [usize; 3],
    last: [usize; 3],
    margin: [usize; 3],
    pub(super) size: [usize; 3],
}

impl Crop {
    pub(super) fn of(map: &LabelMap<'_>, label: u16, margin: [usize; 3]) -> Option<Self> {
        let (mut first, mut last, mut any) = ([usize::MAX; 3], [0; 3], false);
        for (n, _) in map.labels.iter().enumerate().filter(|(_, l)| **l == label) {
            let at = [
                n % map.size[0],
                n / map.size[0] % map.size[1],
                n / map.size[0] / map.size[1],
            ];
            for k in 0..3 {
                first[k] = first[k].min(at[k]);
                last[k] = last[k].max(at[k]);
            }
            any = true;
        }
        any.then(|| Self {
            size: [0, 1, 2].map(|k| last[k] - first[k] + 1 + 2 * margin[k]),
            first,
            last,
            margin,
        })
    }

    fn each(&self) -> impl Iterator<Item = [usize; 3]> {
        let [a, b, c] = self.size;
        (0..a * b * c).map(move |n| [n % a, n / a % b, n / a / b])
    }

    pub(super) fn indicator(&self, map: &LabelMap<'_>, label: u16) -> Vec<bool> {
        let inside = |at: [usize; 3]| {
            let from = |k: usize| (at[k] + self.first[k]).checked_sub(self.margin[k]);
            let place = [from(0)?, from(1)?, from(2)?];
            (0..3).all(|k| place[k] < map.size[k]).then(|| map.at(place) == label)
        };
        self.each().map(|at| inside(at).unwrap_or(false)).collect()
    }

    pub(super) fn facts(&self, map: &LabelMap<'_>) -> Facts {
        Facts {
            cut: [0, 1, 2].map(|k| [self.first[k] == 0, self.last[k] + 1 == map.size[k]]),
            ..Facts::default()
        }
    }

    /// The centre of its first voxel.
    pub(super) fn origin(&self, map: &LabelMap<'_>) -> Vector3<f64> {
        map.origin + Vector3::from_fn(|k, _| map.spacing[k] * (self.first[k] as f64 - self.margin[k] as f64))
    }

    /// Voxels inside the label but not the region, and the other way round.
    pub(super) fn moved(&self, spline: &Spline, map: &LabelMap<'_>, inside: &[bool]) -> [usize; 2] {
        let origin = self.origin(map);
        let mut moved = [0, 0];
        for (at, inside) in self.each().zip(inside) {
            let place = origin + Vector3::from_fn(|k, _| map.spacing[k] * at[k] as f64);
            let within = spline.value(&place) < 0.0;
            moved[0] += usize::from(*inside && !within);
            moved[1] += usize::from(!*inside && within);
        }
        moved
    }
}
