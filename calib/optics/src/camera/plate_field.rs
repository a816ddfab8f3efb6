//! A plate whose discs lie off the paraboloid (9) by a smooth random field: in height, and in the plane.
//!
//! Over `(u, w)`, as in (9), each of the three offsets is a Gaussian field of the covariance
//! `t^2 exp(-d^2 / 2 l^2)` at distance `d`, as a sum of sines over a box a good reach wider than the discs (Solin and
//! Särkkä 2020, Hilbert space methods for reduced-rank Gaussian process regression):
//!
//! ```text
//! f(u, w) = t sum a_jk s_jk sin(p_j (u + U)) sin(q_k (w + V)),   p_j = pi j / 2 U,  q_k = pi k / 2 V,  a_jk ~ N(0, 1)
//! s_jk^2 = 2 pi l^2 / (U V) exp(-l^2 (p_j^2 + q_k^2) / 2)                                                      (11)
//! ```
//!
//! What other numbers say already is taken out of each wave, by least squares over the discs: of the height all up to
//! the second degree, which pose and paraboloid have, and of the places all up to the first, which pose, focal lengths
//! and the stated pitch have. Left in, the pitch along one axis and the focal length along the other trade freely.

use nalgebra::{DMatrix, DVector, Vector2, Vector3};

use super::paraboloid::Ruler;
use super::view::Station;

/// `l`, in units of half the grid's longer side.
pub const REACH: f64 = 0.6;
/// The box ends so many reaches beyond the discs: the sines are 0 there, and the field must not be.
const MARGIN_REACHES: f64 = 1.2;
/// Waves of a smaller share of the greatest variance are left out.
const LEAST_VARIANCE_SHARE: f64 = 1e-4;
/// Powers up to the second degree, and of them those up to the first.
const QUADRATIC_POWERS: usize = 6;
const LINEAR_POWERS: usize = 3;

/// The waves of (11), without what other numbers say.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Waves {
    ruler: Ruler,
    half: Vector2<f64>,
    /// `p_j`, `q_k` and `s_jk`.
    modes: Vec<(Vector2<f64>, f64)>,
    /// What of each wave the powers say, for the height and for the places.
    taken: [DMatrix<f64>; 2],
}

impl Waves {
    pub(super) fn of(stations: &[Station], ruler: Ruler) -> Self {
        let places = || stations.iter().flat_map(Station::places).map(|at| ruler.place(at));
        let half = places().fold(Vector2::zeros(), |most, p| most.sup(&p.abs()));
        let half = half.add_scalar(MARGIN_REACHES * REACH);
        let mut waves = Self {
            ruler,
            half,
            modes: modes(half),
            taken: [DMatrix::zeros(0, 0), DMatrix::zeros(0, 0)],
        };
        let places: Vec<Vector2<f64>> = places().collect();
        let plain = DMatrix::from_rows(&places.iter().map(|p| waves.plain(*p).transpose()).collect::<Vec<_>>());
        waves.taken = [QUADRATIC_POWERS, LINEAR_POWERS].map(|count| {
            let powers = DMatrix::from_fn(places.len(), count, |i, k| powers(places[i])[k]);
            // Discs in two rows do not hold all powers: the pseudo-inverse takes out what they do hold.
            let square = (powers.transpose() * &powers).pseudo_inverse(1e-12).unwrap_or_default();
            square * (powers.transpose() * &plain)
        });
        waves
    }

    /// How many.
    pub(super) fn count(&self) -> usize {
        self.modes.len()
    }

    fn plain(&self, p: Vector2<f64>) -> DVector<f64> {
        let at = p + self.half;
        let wave = |(turn, size): &(Vector2<f64>, f64)| size * (turn.x * at.x).sin() * (turn.y * at.y).sin();
        DVector::from_iterator(self.count(), self.modes.iter().map(wave))
    }

    /// The waves of the height and those of the places at a disc.
    pub(super) fn at(&self, at_mm: Vector2<f64>) -> [DVector<f64>; 2] {
        let p = self.ruler.place(at_mm);
        let (plain, powers) = (self.plain(p), powers(p));
        self.taken
            .each_ref()
            .map(|taken| &plain - taken.transpose() * DVector::from_column_slice(&powers[..taken.nrows()]))
    }

    /// The offset of a disc, mm: `coefficients` are those of the height, then those of the first and of the second axis.
    pub(super) fn offset(&self, at_mm: Vector2<f64>, coefficients: &DVector<f64>) -> Vector3<f64> {
        let ([lift, slide], m) = (self.at(at_mm), self.count());
        let part = |k: usize, wave: &DVector<f64>| wave.dot(&coefficients.rows(k * m, m));
        Vector3::new(part(1, &slide), part(2, &slide), part(0, &lift))
    }

    /// The stations with every disc moved by its offset.
    pub(super) fn moved(&self, stations: &[Station], coefficients: &DVector<f64>) -> Vec<Station> {
        let moved = |station: &Station| {
            let mut station = station.clone();
            for s in &mut station.sightings {
                s.place += self.offset(s.place.xy() + station.centre, coefficients);
            }
            station
        };
        stations.iter().map(moved).collect()
    }
}

/// The waves worth having in a box.
fn modes(half: Vector2<f64>) -> Vec<(Vector2<f64>, f64)> {
    let lowest = Vector2::repeat(std::f64::consts::FRAC_PI_2).component_div(&half);
    let share = |turn: &Vector2<f64>| (-0.5 * REACH * REACH * turn.norm_squared()).exp();
    // exp(-x^2 / 2) is LEAST_VARIANCE_SHARE at x = 4.3, and no wave has a longer side than that.
    let most = (4.3 / REACH / lowest.min()).ceil() as usize;
    let all = (1..=most).flat_map(|j| (1..=most).map(move |k| Vector2::new(j as f64, k as f64)));
    let scale = std::f64::consts::TAU * REACH * REACH / (half.x * half.y);
    all.map(|jk| jk.component_mul(&lowest))
        .filter(|turn| share(turn) >= LEAST_VARIANCE_SHARE)
        .map(|turn| (turn, (scale * share(&turn)).sqrt()))
        .collect()
}

/// 1, u, w, u^2, u w, w^2.
fn powers(p: Vector2<f64>) -> [f64; QUADRATIC_POWERS] {
    [1.0, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y]
}
