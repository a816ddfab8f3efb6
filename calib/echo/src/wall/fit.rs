//! A line through rows, with Tukey's biweight.

/// `v = at + slope (u - about)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    about: f64,
    at: f64,
    pub(super) slope: f64,
    /// Deviation of one row about the line.
    pub(super) off: f64,
    /// Sum of the weights, and of the weighted squares of `u - about`.
    sums: [f64; 2],
}

impl Fit {
    /// The line of places (u, v), two or more at different u; rows that are `most` off have no weight.
    pub(super) fn of(places: &[[f64; 2]], most: f64) -> Self {
        let mut weights = vec![1.0; places.len()];
        let mut fit = Self::weighted(places, &weights);
        // The bound is fixed, so the weights settle within a few rounds; 10 leave nothing that matters.
        for _ in 0..10 {
            weights = places.iter().map(|[u, v]| biweight((v - fit.row(*u)) / most)).collect();
            fit = Self::weighted(places, &weights);
        }
        fit
    }

    fn weighted(places: &[[f64; 2]], weights: &[f64]) -> Self {
        let sum = |of: &dyn Fn(&[f64; 2]) -> f64| places.iter().zip(weights).map(|(p, w)| w * of(p)).sum::<f64>();
        let total = sum(&|_| 1.0).max(1e-12);
        let (about, at) = (sum(&|p| p[0]) / total, sum(&|p| p[1]) / total);
        let square = sum(&|p| (p[0] - about).powi(2)).max(1e-12);
        let slope = sum(&|p| (p[0] - about) * (p[1] - at)) / square;
        let left = sum(&|p| (p[1] - at - slope * (p[0] - about)).powi(2));
        // Two numbers of the line are taken from the rows.
        let free = (total - 2.0).max(1.0);
        Self {
            about,
            at,
            slope,
            off: (left / free).sqrt(),
            sums: [total, square],
        }
    }

    /// The line's row at a column.
    pub(super) fn row(&self, u: f64) -> f64 {
        self.at + self.slope * (u - self.about)
    }

    /// Its standard deviation.
    pub(super) fn row_sigma(&self, u: f64) -> f64 {
        let [total, square] = self.sums;
        self.off * (1.0 / total + (u - self.about).powi(2) / square).sqrt()
    }
}

/// Tukey's biweight: 1 at 0, 0 from 1 on.
fn biweight(x: f64) -> f64 {
    if x.abs() < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}
