//! How a lens moves what a pinhole would show: polynomials of the place in the image.

use std::sync::LazyLock;

use nalgebra::{DMatrix, Matrix2, Vector2};

/// The highest degree, and how many products of powers there are up to it.
const DEGREE: usize = 7;
const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;
type Polynomial = [f64; TERMS];

/// What a lens is made of: radial fields of the third, fifth and seventh degree, two tangential ones, and its middle along x
/// and y.
pub(crate) const NUMBERS: usize = 7;
/// The radial fields come first.
pub(crate) const RADIAL: usize = 3;
/// Before the middle, the fields.
pub(crate) const FIELDS: usize = 5;

/// The place of `x^a y^b`.
const fn term(a: usize, b: usize) -> usize {
    // By degrees, and in each by the power of y: the terms below degree d are d (d + 1) / 2.
    (a + b) * (a + b + 1) / 2 + b
}

/// A vector field: `unit F((p - origin) / unit - middle)` pixels at the pixel `p`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Field([Polynomial; 2]);

/// What a pinhole shows at `p` is seen at `p` and the field there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Warp {
    origin: Vector2<f64>,
    unit: f64,
    /// The lens's own middle off the origin, units.
    middle: Vector2<f64>,
    /// Its first radial coefficient.
    first: f64,
    field: Field,
}

/// A map to the second order about a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jet {
    pub(crate) value: Vector2<f64>,
    pub(crate) slope: Matrix2<f64>,
    /// The slope's derivatives along x and y.
    pub(crate) bend: [Matrix2<f64>; 2],
}

/// A power times `x^a y^b`, or nothing.
fn times(polynomial: &Polynomial, a: usize, b: usize, factor: f64) -> Polynomial {
    let mut out = [0.0; TERMS];
    for i in 0..=DEGREE {
        for j in 0..=DEGREE - i {
            let value = polynomial[term(i, j)];
            if value != 0.0 {
                // The largest field, r^6 x, is of the seventh degree: no product leaves the table.
                out[term(i + a, j + b)] += factor * value;
            }
        }
    }
    out
}

fn sum(parts: &[Polynomial]) -> Polynomial {
    let mut out = [0.0; TERMS];
    parts
        .iter()
        .for_each(|p| out.iter_mut().zip(p).for_each(|(o, v)| *o += v));
    out
}

/// The radial fields `r^2 x`, `r^4 x`, `r^6 x`, and the tangential ones `r^2 q + 2 (q.x) x` along x and y (Brown 1966).
static LENS: LazyLock<[Field; FIELDS]> = LazyLock::new(|| {
    let mut one = [0.0; TERMS];
    one[0] = 1.0;
    let by_r2 = |p: &Polynomial| sum(&[times(p, 2, 0, 1.0), times(p, 0, 2, 1.0)]);
    let r2 = by_r2(&one);
    let r4 = by_r2(&r2);
    let r6 = by_r2(&r4);
    let radial = |r: &Polynomial| Field([times(r, 1, 0, 1.0), times(r, 0, 1, 1.0)]);
    let cross = times(&one, 1, 1, 2.0);
    [
        radial(&r2),
        radial(&r4),
        radial(&r6),
        Field([sum(&[r2, times(&one, 2, 0, 2.0)]), cross]),
        Field([cross, sum(&[r2, times(&one, 0, 2, 2.0)])]),
    ]
});

/// Powers of a place with their first and second derivatives: value, x, y, xx, xy, yy.
type Powers = [[f64; 6]; TERMS];

fn powers(x: Vector2<f64>) -> Powers {
    let mut out = [[0.0; 6]; TERMS];
    let row = |v: f64| {
        let mut all = [[0.0; 3]; DEGREE + 1];
        let mut power = 1.0;
        for k in 0..=DEGREE {
            all[k][0] = power;
            if k > 0 {
                // From the row before, (v^k)' = k v^(k - 1): no division by v, which may be 0.
                all[k][1] = k as f64 * all[k - 1][0];
                all[k][2] = k as f64 * all[k - 1][1];
            }
            power *= v;
        }
        all
    };
    // Value, slopes and second derivatives of x^a y^b from those of each factor.
    let (px, py) = (row(x.x), row(x.y));
    for a in 0..=DEGREE {
        for b in 0..=DEGREE - a {
            let (p, q) = (px[a], py[b]);
            out[term(a, b)] = [
                p[0] * q[0],
                p[1] * q[0],
                p[0] * q[1],
                p[2] * q[0],
                p[1] * q[1],
                p[0] * q[2],
            ];
        }
    }
    out
}

fn values(powers: &Powers, count: usize) -> Vec<f64> {
    powers[..count].iter().map(|p| p[0]).collect()
}

impl Field {
    /// Both coordinates with their derivatives.
    fn at(&self, powers: &Powers) -> [[f64; 6]; 2] {
        [0, 1].map(|k| {
            let mut out = [0.0; 6];
            for (c, p) in self.0[k].iter().zip(powers) {
                // A lens has odd degrees and the second alone: more than half of the coefficients are 0.
                if *c != 0.0 {
                    out.iter_mut().zip(p).for_each(|(o, v)| *o += c * v);
                }
            }
            out
        })
    }
}

impl Warp {
    /// None, about a place, in units of so many pixels.
    pub(crate) fn none(origin: Vector2<f64>, unit: f64) -> Self {
        Self {
            origin,
            unit,
            middle: Vector2::zeros(),
            first: 0.0,
            field: Field([[0.0; TERMS]; 2]),
        }
    }

    /// The same with a lens: its radial coefficients, what is of the second degree, and its middle off the origin, units.
    ///
    /// A radial field about another middle `m` is of the second degree, too: `-k1 (r^2 m + 2 (m.x) x)`. With what is of that
    /// degree in all, its tangential part and this, middle and tangential part do not go together.
    pub(crate) fn lens(&self, numbers: &[f64; NUMBERS]) -> Self {
        let mut field = Field([[0.0; TERMS]; 2]);
        let middle = Vector2::new(numbers[FIELDS], numbers[FIELDS + 1]);
        let mut parts = *numbers;
        (0..2).for_each(|k| parts[RADIAL + k] += numbers[0] * middle[k]);
        for (c, part) in parts.iter().zip(LENS.iter()) {
            for (to, from) in field.0.iter_mut().zip(&part.0) {
                to.iter_mut().zip(from).for_each(|(t, f)| *t += c * f);
            }
        }
        Self {
            field,
            middle,
            first: numbers[0],
            ..*self
        }
    }

    /// The same with powers of degree 2 and more in the place of a lens.
    fn smooth(&self, coefficients: &DMatrix<f64>) -> Self {
        let mut field = Field([[0.0; TERMS]; 2]);
        for (m, row) in coefficients.row_iter().enumerate() {
            (0..2).for_each(|k| field.0[k][m + term(2, 0)] = row[k]);
        }
        Self {
            field,
            middle: Vector2::zeros(),
            ..*self
        }
    }

    /// The polynomials of a degree up to [`DEGREE`], without those an affine map has, that move what a pinhole shows nearest to
    /// where it is seen; none where the places tell none.
    pub(crate) fn through(&self, pairs: &[(Vector2<f64>, Vector2<f64>)], degree: usize) -> Option<Self> {
        let count = term(0, degree) + 1;
        let rows = pairs.iter().flat_map(|(p, _)| values(&self.powers(*p), count));
        let rows = DMatrix::from_row_iterator(pairs.len(), count, rows);
        let off = pairs.iter().flat_map(|(p, at)| <[f64; 2]>::from((at - p) / self.unit));
        let off = DMatrix::from_row_iterator(pairs.len(), 2, off);
        // The affine terms are fitted and then left out: without them the others would take their part, which the
        // homography has.
        let found = (rows.transpose() * &rows).cholesky()?.solve(&(rows.transpose() * off));
        Some(self.smooth(&found.rows(term(2, 0), count - term(2, 0)).into_owned()))
    }

    fn powers(&self, p: Vector2<f64>) -> Powers {
        powers((p - self.origin) / self.unit - self.middle)
    }

    /// Where what a pinhole shows at `p` is seen.
    pub(crate) fn at(&self, p: Vector2<f64>) -> Vector2<f64> {
        let x = (p - self.origin) / self.unit - self.middle;
        // Without derivatives, which `jet` has: this is asked for at every point of every rim.
        let powers = |v: f64| {
            let mut all = [1.0; DEGREE + 1];
            (1..=DEGREE).for_each(|k| all[k] = all[k - 1] * v);
            all
        };
        let (px, py) = (powers(x.x), powers(x.y));
        let mut out = p;
        for d in 0..=DEGREE {
            for b in 0..=d {
                let power = self.unit * px[d - b] * py[b];
                let k = term(d - b, b);
                out += Vector2::new(self.field.0[0][k], self.field.0[1][k]) * power;
            }
        }
        out
    }

    /// The same with derivatives.
    pub(crate) fn jet(&self, p: Vector2<f64>) -> Jet {
        let [u, v] = self.field.at(&self.powers(p));
        // The field is unit F(x / unit): its slope is F' as it is, its second derivative F'' over the unit.
        let over = self.unit.recip();
        Jet {
            value: p + Vector2::new(u[0], v[0]) * self.unit,
            slope: Matrix2::new(1.0 + u[1], u[2], v[1], 1.0 + v[2]),
            bend: [
                Matrix2::new(u[3], u[4], v[3], v[4]) * over,
                Matrix2::new(u[4], u[5], v[4], v[5]) * over,
            ],
        }
    }

    /// The derivatives of value and slope by a lens's numbers.
    pub(crate) fn by_numbers(&self, p: Vector2<f64>) -> [(Vector2<f64>, Matrix2<f64>); NUMBERS] {
        let powers = self.powers(p);
        let one = |field: &Field| {
            let [u, v] = field.at(&powers);
            let value = Vector2::new(u[0], v[0]) * self.unit;
            (value, Matrix2::new(u[1], u[2], v[1], v[2]))
        };
        let jet = self.jet(p);
        // Moving the middle is moving the point the other way, but for the point itself.
        let moved = (jet.slope - Matrix2::identity()) * -self.unit;
        let (first, middle) = (self.first, self.middle);
        let second = [0, 1].map(|axis| one(&LENS[RADIAL + axis]));
        // `lens` adds k1 m to the tangential part: by k1 that gives the tangential fields times m, by m them times k1.
        let with = |value: Vector2<f64>, slope: Matrix2<f64>, [x, y]: [f64; 2]| {
            let value = value + second[0].0 * x + second[1].0 * y;
            (value, slope + second[0].1 * x + second[1].1 * y)
        };
        std::array::from_fn(|k| match k.checked_sub(FIELDS) {
            Some(axis) => {
                let (value, slope) = (moved.column(axis).into_owned(), jet.bend[axis] * -self.unit);
                with(value, slope, [0, 1].map(|a| if a == axis { first } else { 0.0 }))
            }
            None if k == 0 => {
                let (value, slope) = one(&LENS[0]);
                with(value, slope, middle.into())
            }
            None => one(&LENS[k]),
        })
    }
}

impl Jet {
    /// How the slope changes along a way.
    pub(crate) fn bent(&self, way: Vector2<f64>) -> Matrix2<f64> {
        self.bend[0] * way.x + self.bend[1] * way.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: [f64; NUMBERS] = [-0.2, 0.07, 0.03, 0.02, -0.01, 0.03, 0.01];

    fn none() -> Warp {
        Warp::none(Vector2::new(250.0, 260.0), 300.0)
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (warp, at, e) = (none().lens(&LENS), Vector2::new(120.0, 400.0), 1e-2);
        let jet = warp.jet(at);
        assert!((warp.at(at) - jet.value).norm() < 1e-10);
        for k in 0..2 {
            let step = Vector2::ith(k, e);
            let (up, down) = (warp.jet(at + step), warp.jet(at - step));
            let slope = (up.value - down.value) / (2.0 * e);
            // Third and fourth derivatives of some 1e-5 and 1e-7 a pixel, times the step squared by 6.
            assert!((slope - jet.slope.column(k)).norm() < 1e-8, "{k}");
            let bend = (up.slope - down.slope) / (2.0 * e);
            assert!((bend - jet.bend[k]).norm() < 1e-9, "{k}");
        }
        for k in 0..NUMBERS {
            let with = |by: f64| {
                let mut numbers = LENS;
                numbers[k] += by;
                none().lens(&numbers).jet(at)
            };
            let (up, down) = (with(5e-5), with(-5e-5));
            let (value, slope) = warp.by_numbers(at)[k];
            // Linear in the coefficients; the third derivative by the middle is some hundreds, times the step squared by 6.
            let off = ((up.value - down.value) / 1e-4 - value).norm();
            assert!(off < 2e-6, "{k} {off}");
            let off = ((up.slope - down.slope) / 1e-4 - slope).norm();
            assert!(off < 2e-8, "{k} {off}");
        }
    }

    #[test]
    fn polynomials_follow_a_lens() {
        let warp = none().lens(&[-0.2, 0.07, 0.0, 0.02, -0.01, 0.0, 0.0]);
        let place = |i: i32| Vector2::new(f64::from(40 * (i % 12) + 20), f64::from(40 * (i / 12) + 30));
        let pairs: Vec<_> = (0..144).map(|i| (place(i), warp.at(place(i)))).collect();
        let found = none().through(&pairs, 5).unwrap();
        for i in 0..144 {
            // The same polynomial: rounding times the condition of powers up to the fifth.
            assert!((found.at(place(i)) - warp.at(place(i))).norm() < 1e-8, "{i}");
        }
        assert!(none().through(&pairs[..12], 5).is_none());
    }
}
