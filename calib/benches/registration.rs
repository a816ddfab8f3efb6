//! What a registration costs and what it gets wrong: each method beside nalgebra's singular value decomposition.
//!
//! `cargo bench -p calib --bench registration`. Sets of 24 points with noise, well posed and slender; the methods take
//! turns, so that a noisy machine treats them alike. Times are the lowest quartile of the rounds, nanoseconds per call.
//! The error is the worst angle to the plain `Svd` method's rotation, in units of 2^-53 times the condition; that
//! method itself is held to the 50-digit optima by the tests. nalgebra has two decompositions: `Matrix3::svd`, which
//! works on the squared matrix, and the iteration of its dynamic matrices.
//!
//! Then the ladder: error against time of whole fits from conditions of 1 to 1e12, where the true rotation is known
//! exactly, into `out/bench/registration.csv` and `registration.png`.

#![allow(
    clippy::print_stderr,
    clippy::print_stdout,
    reason = "the table is what this program is for"
)]

#[path = "registration/ladder.rs"]
mod ladder;
#[path = "registration/plot.rs"]
mod plot;
#[path = "../../benches/shared/trade.rs"]
mod trade;

use std::hint::black_box;

use calib::registration::{Fit, Method, Moments, Pairs, fit};
use geometry::{Ct, Point, Tracker};
use nalgebra::{DMatrix, Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

const POINTS: usize = 24;
const SETS: usize = 64;
const ROUNDS: usize = 400;

struct Set {
    to: Vec<Point<Ct>>,
    from: Vec<Point<Tracker>>,
}

/// Numbers in -1..1, the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.next(), self.next(), self.next())
    }

    fn set(&mut self, width: f64, noise: f64) -> Set {
        let r = Rotation3::from_scaled_axis(self.vector() * 3.0);
        let shape = Vector3::new(50.0, 50.0 * width, 50.0 * width);
        let from: Vec<Vector3<f64>> = (0..POINTS).map(|_| self.vector().component_mul(&shape)).collect();
        let to: Vec<Vector3<f64>> = from
            .iter()
            .map(|b| r * b + self.vector() * noise + Vector3::new(900.0, -300.0, 100.0))
            .collect();
        Set {
            to: to.iter().map(|v| Point::new(v.x, v.y, v.z)).collect(),
            from: from.iter().map(|v| Point::new(v.x, v.y, v.z)).collect(),
        }
    }
}

impl Set {
    fn pairs(&self) -> Pairs<'_, Ct, Tracker> {
        Pairs::new(&self.to, &self.from).expect("as many points on both sides")
    }

    /// `Psi`, for the solvers of others.
    fn psi(&self) -> Matrix3<f64> {
        let of = |p: [f64; 3]| Vector3::from(p);
        let mean = |v: &[Vector3<f64>]| v.iter().sum::<Vector3<f64>>() / v.len() as f64;
        let to: Vec<_> = self.to.iter().map(|p| of(p.mm())).collect();
        let from: Vec<_> = self.from.iter().map(|p| of(p.mm())).collect();
        let (a, b) = (mean(&to), mean(&from));
        let terms = to.iter().zip(&from).map(|(p, q)| (p - a) * (q - b).transpose());
        terms.sum::<Matrix3<f64>>() / POINTS as f64
    }
}

/// Arun's rotation by nalgebra's decomposition of a 3 x 3 matrix.
fn nalgebra_svd(psi: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = psi.svd(true, true);
    proper(svd.u.unwrap_or_default(), svd.v_t.unwrap_or_default())
}

/// The same through nalgebra's general algorithm.
fn nalgebra_dynamic(psi: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = DMatrix::from_column_slice(3, 3, psi.as_slice()).svd(true, true);
    let part = |m: Option<DMatrix<f64>>| m.map_or_else(Matrix3::zeros, |m| Matrix3::from_column_slice(m.as_slice()));
    proper(part(svd.u), part(svd.v_t))
}

fn proper(mut u: Matrix3<f64>, v_t: Matrix3<f64>) -> Matrix3<f64> {
    if (u * v_t).determinant() < 0.0 {
        u.column_mut(2).neg_mut();
    }
    u * v_t
}

fn matrix([w, x, y, z]: [f64; 4]) -> Matrix3<f64> {
    let q = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    q.to_rotation_matrix().into_inner()
}

#[allow(
    clippy::disallowed_methods,
    reason = "a benchmark measures time; nothing is stamped with it"
)]
fn nanoseconds(mut work: impl FnMut()) -> f64 {
    let began = std::time::Instant::now();
    work();
    began.elapsed().as_nanos() as f64
}

type Work<'a> = Box<dyn FnMut() + 'a>;

/// The lowest quartile of each contestant's time per set.
fn race(contestants: &mut [(String, Work<'_>)]) -> Vec<f64> {
    let mut times = vec![Vec::with_capacity(ROUNDS); contestants.len()];
    for _ in 0..ROUNDS {
        for (i, (_, work)) in contestants.iter_mut().enumerate() {
            times[i].push(nanoseconds(&mut *work) / SETS as f64);
        }
    }
    let quartile = |mut list: Vec<f64>| {
        list.sort_by(f64::total_cmp);
        list[list.len() / 4]
    };
    times.into_iter().map(quartile).collect()
}

/// Does the work on each item, out of the optimiser's sight.
fn each<T, R>(items: &[T], work: impl Fn(&T) -> R) {
    for item in items {
        let _unused = black_box(work(black_box(item)));
    }
}

fn main() {
    if let Some(trade) = trade::Trade::wanted() {
        return ladder::trade(&trade);
    }
    println!("n = {POINTS}, {SETS} sets, lowest quartile of {ROUNDS} rounds; errors in 2^-53 x condition");
    for (name, width, noise) in [
        ("noise 0.1 of 50 mm", 1.0, 0.1),
        ("noise 20 of 50 mm", 1.0, 20.0),
        ("width 1 %, noise 0.01 mm", 0.01, 0.01),
        ("width 0.001 %", 1e-5, 0.0),
    ] {
        table(name, width, noise);
    }
    let rungs = ladder::measure();
    print!("{}", ladder::summary(&rungs));
    match plot::write(&rungs) {
        Ok(folder) => println!("written: registration.csv and registration.png in {}", folder.display()),
        Err(error) => {
            eprintln!("registration: error: {error}");
            std::process::exit(1);
        }
    }
}

fn table(name: &str, width: f64, noise: f64) {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let sets: Vec<Set> = (0..SETS).map(|_| random.set(width, noise)).collect();
    let moments: Vec<Moments> = sets.iter().map(|s| Moments::of(s.pairs()).expect("a cloud")).collect();
    let psis: Vec<Matrix3<f64>> = sets.iter().map(Set::psi).collect();
    let (sets, psis, moments) = (&sets[..], &psis[..], &moments[..]);
    let mut contestants: Vec<(String, Work<'_>)> = Vec::new();
    for method in Method::ALL {
        let work = move || each(moments, |m| m.solve(method));
        contestants.push((format!("{method:?}, moments to rotation"), Box::new(work)));
    }
    let others: [(&str, Work<'_>); 5] = [
        ("nalgebra Matrix3::svd", Box::new(|| each(psis, nalgebra_svd))),
        ("nalgebra DMatrix svd", Box::new(|| each(psis, nalgebra_dynamic))),
        ("points to moments", Box::new(|| each(sets, |s| Moments::of(s.pairs())))),
        (
            "fit: points to transform",
            Box::new(|| each(sets, |s| fit(s.pairs(), Method::Newton))),
        ),
        ("points to rotation, nalgebra", Box::new(|| each(sets, whole_nalgebra))),
    ];
    contestants.extend(others.map(|(name, work)| (name.to_owned(), work)));
    let times = race(&mut contestants);
    println!("\n{name}\n{:<36}{:>10}{:>14}", "", "ns", "worst error");
    for (i, (contestant, _)) in contestants.iter().enumerate() {
        let error = error(i, sets, psis).map_or(String::new(), |e| format!("{e:.1e}"));
        println!("{contestant:<36}{:>10.0}{error:>14}", times[i]);
    }
}

fn whole_nalgebra(set: &Set) -> Matrix3<f64> {
    nalgebra_svd(&set.psi())
}

/// The worst error of contestant `i`, where it is a solver.
fn error(i: usize, sets: &[Set], psis: &[Matrix3<f64>]) -> Option<f64> {
    let solve = |set: &Set, psi: &Matrix3<f64>| -> Option<Matrix3<f64>> {
        match i.checked_sub(Method::ALL.len()) {
            None => Some(rotation(&fit(set.pairs(), Method::ALL[i]).ok()?)),
            Some(0) => Some(nalgebra_svd(psi)),
            Some(1) => Some(nalgebra_dynamic(psi)),
            Some(_) => None,
        }
    };
    let ratio = |(set, psi): (&Set, &Matrix3<f64>)| {
        let best = fit(set.pairs(), Method::Svd).ok()?;
        let angle = (solve(set, psi)? - rotation(&best)).norm() / 2.0_f64.sqrt();
        Some(angle / (0.5 * f64::EPSILON * best.condition()))
    };
    let ratios: Option<Vec<f64>> = sets.iter().zip(psis).map(ratio).collect();
    Some(ratios?.into_iter().fold(0.0, f64::max))
}

fn rotation(fit: &Fit<Ct, Tracker>) -> Matrix3<f64> {
    matrix(fit.transform.quaternion())
}
