//! Who is next to whom among candidates.

use nalgebra::{Matrix2, Vector2};

use crate::grid::candidates::blob::Blob;

/// Neighbours that are looked at.
const MAX_NEIGHBOURS: usize = 14;
/// Areas of neighbours differ by at most this factor.
pub(in crate::grid) const ALIKE: f64 = 3.0;

pub(in crate::grid) fn alike(a: f64, b: f64, factor: f64) -> bool {
    // Symmetric in a and b, and false for a NaN.
    let ratio = a / b;
    ratio < factor && ratio * factor > 1.0
}

/// What is looked at of a candidate, side by side in memory.
pub(in crate::grid) struct Spot {
    pub(in crate::grid) at: Vector2<f64>,
    pub(in crate::grid) area: f64,
    pub(in crate::grid) index: usize,
}

/// Candidates in strips along x, in the order of their columns in each: who is near is looked for in a part of a few strips.
pub(in crate::grid) struct Order {
    strips: Vec<Vec<Spot>>,
    /// The height of a strip, pixels.
    tall: f64,
}

impl Order {
    /// As many strips as there would be rows, were the candidates in rows and columns.
    pub(in crate::grid) fn new(blobs: &[Blob]) -> Self {
        let count = (blobs.len() as f64).sqrt().ceil().max(1.0);
        let end = blobs.iter().map(|b| b.at.y).fold(0.0, f64::max) + 1.0;
        let mut order = Self {
            strips: (0..count as usize).map(|_| Vec::new()).collect(),
            tall: end / count,
        };
        for (index, blob) in blobs.iter().enumerate() {
            let (at, area, strip) = (blob.at, blob.area, order.strip(blob.at.y));
            order.strips[strip].push(Spot { at, area, index });
        }
        let by_x = |a: &Spot, b: &Spot| a.at.x.total_cmp(&b.at.x);
        order.strips.iter_mut().for_each(|s| s.sort_by(by_x));
        order
    }

    fn strip(&self, y: f64) -> usize {
        ((y / self.tall).max(0.0) as usize).min(self.strips.len() - 1)
    }

    /// Those at most so many pixels from a place along x, and some of those farther off along y.
    pub(in crate::grid) fn about(&self, at: Vector2<f64>, [wide, tall]: [f64; 2]) -> impl Iterator<Item = &Spot> {
        let strips = &self.strips[self.strip(at.y - tall)..=self.strip(at.y + tall)];
        strips.iter().flat_map(move |strip| {
            let from = strip.partition_point(|o| o.at.x < at.x - wide);
            let to = strip.partition_point(|o| o.at.x <= at.x + wide);
            &strip[from..to]
        })
    }
}

/// The nearest candidates of like size, in the measure that makes the disc a circle: how far, and the way to each.
pub(in crate::grid) struct Nearest<'a> {
    blob: &'a Blob,
    index: usize,
    measure: &'a Matrix2<f64>,
    /// A way of length 1 goes at most so far along x, and along y.
    widest: f64,
    tallest: f64,
    near: Vec<(f64, Vector2<f64>)>,
}

impl<'a> Nearest<'a> {
    pub(in crate::grid) fn of(
        blobs: &'a [Blob],
        order: &Order,
        measure: &'a Matrix2<f64>,
        index: usize,
    ) -> Vec<(f64, Vector2<f64>)> {
        let blob = &blobs[index];
        let [widest, tallest] = [0, 1].map(|k| blob.shape[(k, k)].sqrt());
        let mut all = Self {
            blob,
            index,
            measure,
            widest,
            tallest,
            near: Vec::with_capacity(MAX_NEIGHBOURS + 1),
        };
        let own = order.strip(blob.at.y);
        let (above, below) = order.strips.split_at(own);
        all.strip(&order.strips[own]);
        // Strip by strip away from its own, the nearer first, until the next is too far off on its side.
        for k in 1..order.strips.len() {
            let to_below = (own + k) as f64 * order.tall - blob.at.y;
            let to_above = blob.at.y - (own as f64 - k as f64 + 1.0) * order.tall;
            let sides = [
                (below.get(k), to_below),
                (own.checked_sub(k).and_then(|i| above.get(i)), to_above),
            ];
            let mut any = false;
            for (strip, off) in sides {
                if let Some(strip) = strip.filter(|_| off <= all.most() * all.tallest) {
                    all.strip(strip);
                    any = true;
                }
            }
            if !any {
                break;
            }
        }
        all.near
    }

    /// Those of a strip, from its own column to both sides.
    fn strip(&mut self, strip: &[Spot]) {
        // To the right first, then from the nearest on the left: the bound falls fast, and each side ends early.
        let (left, right) = strip.split_at(strip.partition_point(|o| o.at.x < self.blob.at.x));
        self.visit(right.iter());
        self.visit(left.iter().rev());
    }

    /// Those on one side, the nearest along x first.
    fn visit<'b>(&mut self, side: impl Iterator<Item = &'b Spot>) {
        let measure = self.measure;
        let mut most = self.most();
        for spot in side {
            let d = spot.at - self.blob.at;
            // All ways of length l in the measure lie in a box of half sides l sqrt(S_xx) and l sqrt(S_yy).
            if d.x.abs() > most * self.widest {
                break;
            }
            if d.y.abs() > most * self.tallest || spot.index == self.index || !alike(spot.area, self.blob.area, ALIKE) {
                continue;
            }
            let l = (d.transpose() * measure * d)[0].sqrt();
            if l < most {
                let place = self.near.partition_point(|n| n.0 < l);
                self.near.insert(place, (l, d));
                self.near.truncate(MAX_NEIGHBOURS);
                most = self.most();
            }
        }
    }

    /// Beyond this nothing is among the nearest.
    fn most(&self) -> f64 {
        self.near.get(MAX_NEIGHBOURS - 1).map_or(f64::MAX, |n| n.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some of all sizes and shapes, from a plain generator.
    fn some(count: u32) -> Vec<Blob> {
        let unit = |k: u32| f64::from(k.wrapping_mul(2_654_435_761).rotate_left(9) ^ k) / f64::from(u32::MAX);
        let one = |i: u32| {
            let [x, y, a, b, c] = [1, 2, 3, 4, 5].map(|k| unit(17 * i + k).fract());
            Blob {
                at: Vector2::new(500.0 * x, 300.0 * y),
                shape: Matrix2::new(4.0 + 30.0 * a, 3.0 * (b - 0.5), 3.0 * (b - 0.5), 2.0 + 9.0 * b),
                area: 20.0 + 60.0 * c,
                depth: 50.0,
                cut: false,
            }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn the_nearest_are_those_of_all_candidates() {
        for count in [1, 2, 13, 16, 200] {
            let blobs = some(count);
            let order = Order::new(&blobs);
            for (i, blob) in blobs.iter().enumerate() {
                let measure = blob.shape.try_inverse().unwrap_or_default();
                let others = blobs.iter().enumerate().filter(|(j, _)| *j != i);
                let like = others.filter(|(_, b)| alike(b.area, blob.area, ALIKE));
                let way = |b: &Blob| ((b.at - blob.at).transpose() * measure * (b.at - blob.at))[0].sqrt();
                let mut all: Vec<f64> = like.map(|(_, b)| way(b)).collect();
                all.sort_by(f64::total_cmp);
                all.truncate(MAX_NEIGHBOURS);
                let near: Vec<f64> = Nearest::of(&blobs, &order, &measure, i).iter().map(|n| n.0).collect();
                assert_eq!(near, all, "{i} of {count}");
            }
        }
    }

    #[test]
    fn about_a_place_are_all_that_lie_there() {
        let blobs = some(200);
        let order = Order::new(&blobs);
        for at in [[250.0, 150.0], [-20.0, 5.0], [499.0, 400.0]].map(Vector2::from) {
            let inside = |b: &Vector2<f64>| (b - at).x.abs() <= 60.0 && (b - at).y.abs() <= 25.0;
            let mut found: Vec<usize> = order
                .about(at, [60.0, 25.0])
                .filter(|s| inside(&s.at))
                .map(|s| s.index)
                .collect();
            found.sort_unstable();
            let all: Vec<usize> = (0..200).filter(|i| inside(&blobs[*i].at)).collect();
            assert_eq!(found, all);
        }
    }
}
