//! The nearest of places, where one is within reach.

use std::collections::BTreeMap;

use nalgebra::Vector3;

/// Places in boxes as large as the reach.
pub(super) struct Nearest<'a> {
    reach: f64,
    boxes: BTreeMap<[i64; 3], Vec<(usize, &'a Vector3<f64>)>>,
}

impl<'a> Nearest<'a> {
    pub(super) fn new(places: impl Iterator<Item = (usize, &'a Vector3<f64>)>, reach: f64) -> Self {
        let mut boxes: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (number, at) in places {
            boxes.entry(of(at, reach)).or_default().push((number, at));
        }
        Self { reach, boxes }
    }

    /// Its number; `None` where none is within reach.
    pub(super) fn of(&self, x: &Vector3<f64>) -> Option<usize> {
        let own = of(x, self.reach);
        let mut best = (None, self.reach * self.reach);
        for k in 0..27 {
            let beside = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let at = std::array::from_fn(|a| own[a].saturating_add(beside[a]));
            for (number, place) in self.boxes.get(&at).into_iter().flatten() {
                let apart = (*place - x).norm_squared();
                if apart < best.1 {
                    best = (Some(*number), apart);
                }
            }
        }
        best.0
    }
}

fn of(at: &Vector3<f64>, side: f64) -> [i64; 3] {
    [0, 1, 2].map(|a| (at[a] / side).floor() as i64)
}
