//! Points on one side of the bone that lie further outside of it than the others.

use geometry::Frame;
use nalgebra::{DMatrix, Matrix3, SVector, Vector3};

use super::chances::{greatest_square, of_many};
use super::{Linear, Scored, Trend, beyond_chance, square};
use crate::solve::Matrix8;

/// Shares of the points before a cut across a direction.
const CUTS: [f64; 3] = [0.25, 0.5, 0.75];
/// Tissue that residuals alone tell of is a mm or so: what they hardly hold is not taken for more.
const SIDE_MM: f64 = 1.0;
/// A side with fewer points is none.
const LEAST_SIDE: usize = 4;

/// A side that was looked at.
struct Looked {
    /// In the points' axes.
    way: Vector3<f64>,
    is_half: bool,
    scored: Scored<1>,
}

impl<F: Frame> Linear<'_, F> {
    /// The side that shows it most, and what it adds to the covariance; with it what was told of sides before.
    pub(super) fn side(&self) -> Option<(Trend, Matrix8)> {
        let looked = self.sides();
        let best = looked
            .iter()
            .max_by(|a, b| a.scored.deviations.total_cmp(&b.scored.deviations))?;
        let apart = apart(&looked);
        let deviations = of_many(best.scored.deviations, apart);
        let mm = best.scored.theta[0];
        // A half that lies too far inside is the other one that lies too far outside.
        let way = self.state.turn * best.way * if mm < 0.0 { -1.0 } else { 1.0 };
        let trend = Trend {
            deviations,
            mm: mm.abs(),
            towards: way.into(),
        };
        let shown = square(&(best.scored.answer * best.scored.theta));
        let shown = shown * beyond_chance(best.scored.f, greatest_square(apart));
        Some((trend, shown + told(&looked) * self.side_mm.powi(2)))
    }

    fn sides(&self) -> Vec<Looked> {
        let cloud = &self.points.cloud;
        let rows = &self.rows.rows;
        let places: Vec<Vector3<f64>> = rows.iter().map(|row| cloud.places[row.point]).collect();
        let mut looked = Vec::new();
        for way in ways(&places) {
            let each: Vec<f64> = places.iter().map(|p| way.dot(p)).collect();
            let mut along = each.clone();
            // Cut by shares of the points and not by mm, so that each part has points enough to tell.
            along.sort_by(f64::total_cmp);
            for share in CUTS {
                let before = (share * along.len() as f64) as usize;
                if before < LEAST_SIDE || before + LEAST_SIDE > along.len() {
                    continue;
                }
                let cut = along[before];
                // A mm further outside is a residual above 0; the two halves share it, as the offset is another matter.
                let z = rows.iter().zip(&each).map(|(row, along)| {
                    let half = if *along >= cut { -0.5 } else { 0.5 };
                    SVector::<f64, 1>::new(half * row.slope.fixed_rows::<3>(3).norm())
                });
                let z: Vec<SVector<f64, 1>> = z.collect();
                looked.extend(self.score(&z, SIDE_MM.powi(-2)).map(|scored| Looked {
                    way,
                    is_half: share == 0.5,
                    scored,
                }));
            }
        }
        looked
    }
}

/// The 13 directions of the corners, edges and sides of a cube along the points' own axes.
fn ways(places: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let middle = places.iter().sum::<Vector3<f64>>() / places.len().max(1) as f64;
    let outer = places.iter().map(|p| (p - middle) * (p - middle).transpose());
    let axes = outer.sum::<Matrix3<f64>>().symmetric_eigen().eigenvectors;
    // Of 27 the middle one is none, and each one before it is opposite to one after it.
    let way = |i: i32| Vector3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
    (14..27).filter_map(|i| (axes * way(i)).try_normalize(0.0)).collect()
}

/// How many independent numbers these are worth: `(sum sqrt l)^2 / sum l` with `l` the eigenvalues of their correlation (Galwey 2009).
fn apart(looked: &[Looked]) -> f64 {
    let n = looked.len();
    let norm = |k: usize| looked[k].scored.left.iter().map(|z| z[0] * z[0]).sum::<f64>().sqrt();
    let norms: Vec<f64> = (0..n).map(norm).collect();
    let dot = |i: usize, j: usize| {
        let (a, b) = (&looked[i].scored.left, &looked[j].scored.left);
        let sum: f64 = a.iter().zip(b).map(|(a, b)| a[0] * b[0]).sum();
        sum / (norms[i] * norms[j]).max(f64::MIN_POSITIVE)
    };
    // Sides overlap: looks at the same points are worth fewer independent ones.
    let values = DMatrix::from_fn(n, n, dot).symmetric_eigenvalues();
    let roots: f64 = values.iter().map(|l| l.max(0.0).sqrt()).sum();
    let sum: f64 = values.iter().map(|l| l.max(0.0)).sum();
    (roots * roots / sum.max(f64::MIN_POSITIVE)).max(1.0)
}

/// What one mm on a half that chance chooses does: the mean over the directions.
fn told(looked: &[Looked]) -> Matrix8 {
    let halves: Vec<&Looked> = looked.iter().filter(|looked| looked.is_half).collect();
    let sum: Matrix8 = halves.iter().map(|half| square(&half.scored.answer)).sum();
    sum / halves.len().max(1) as f64
}
