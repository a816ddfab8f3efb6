//! Whole fits, from points to transform, of sets whose true rotation is known exactly: error beside time.
//!
//! The rotation has rational entries over a common denominator N, the points are whole multiples of N, so that both
//! clouds are exact in f64 and the planted rotation is the optimum without any rounding of the data. The clouds get
//! thinner until the condition is 1e12: one long axis, two short ones. The unit of the error is 2^-53 times the
//! condition: what rounding `Psi` once may cost.

use std::fmt::Write;

use calib::registration::{Method, fit};
use geometry::rotation::{Rotation, RotationMatrix};
use geometry::{Ct, Point, Tracker};
use nalgebra::Matrix3;

use super::trade::{Dial, Row, Trade, turns};
use super::{POINTS, Random, SETS, Set, Work, each, matrix, nalgebra_dynamic, nalgebra_svd, race, rotation};

/// Powers of ten of the conditions.
const CONDITIONS: std::ops::RangeInclusive<i32> = 0..=12;
/// Half the length of the clouds in units of the denominator: with denominators below 200 all sums stay below 2^53.
const LENGTH: f64 = 1e7;
/// An answer further off than this is none.
const LOST_RAD: f64 = 0.1;

/// A contestant.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Solver {
    Ours(Method),
    NalgebraFixed,
    NalgebraDynamic,
}

impl Solver {
    pub(crate) const ALL: [Self; 8] = {
        let mut all = [Self::NalgebraFixed; 8];
        let mut i = 0;
        while i < Method::ALL.len() {
            all[i] = Self::Ours(Method::ALL[i]);
            i += 1;
        }
        all[7] = Self::NalgebraDynamic;
        all
    };

    pub(crate) fn name(self) -> String {
        match self {
            Self::Ours(method) => format!("{method:?}"),
            Self::NalgebraFixed => "nalgebra Matrix3::svd".to_owned(),
            Self::NalgebraDynamic => "nalgebra DMatrix svd".to_owned(),
        }
    }

    /// As it is typed: small letters, parts joined by dashes.
    fn typed(self) -> String {
        let letter = |(i, c): (usize, char)| {
            let dash = if c.is_uppercase() && i > 0 { "-" } else { "" };
            format!("{dash}{}", c.to_lowercase())
        };
        self.name().chars().enumerate().map(letter).collect()
    }

    /// The rotation from the points; `None` where the solver refuses.
    fn solve(self, set: &Set) -> Option<Matrix3<f64>> {
        match self {
            Self::Ours(method) => Some(rotation(&fit(set.pairs(), method).ok()?)),
            Self::NalgebraFixed => Some(nalgebra_svd(&set.psi())),
            Self::NalgebraDynamic => Some(nalgebra_dynamic(&set.psi())),
        }
    }

    /// What is timed: from the points to rotation and translation.
    fn work(self, sets: &[Set]) {
        match self {
            Self::Ours(method) => each(sets, |set| fit(set.pairs(), method)),
            Self::NalgebraFixed => each(sets, |set| nalgebra_svd(&set.psi())),
            Self::NalgebraDynamic => each(sets, |set| nalgebra_dynamic(&set.psi())),
        }
    }
}

/// One solver on the sets of one condition.
pub(crate) struct Rung {
    pub(crate) solver: Solver,
    /// Median of the sets.
    pub(crate) condition: f64,
    pub(crate) time_ns: f64,
    /// Median and worst angle to the truth, radians; infinite where there was no answer.
    pub(crate) angle_rad: [f64; 2],
    /// The same over 2^-53 times the condition of each set.
    pub(crate) units: [f64; 2],
    /// Sets that the solver refused, or got wrong by more than 0.1 rad.
    pub(crate) lost: usize,
}

/// A set and its truth.
struct Planted {
    set: Set,
    truth: Rotation,
    condition: f64,
}

/// Every solver on every condition.
pub(crate) fn measure() -> Vec<Rung> {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let rungs = CONDITIONS.flat_map(|power| {
        let planted: Vec<Planted> = (0..SETS).map(|_| planted(&mut random, power)).collect();
        on_one_condition(planted)
    });
    rungs.collect()
}

/// The methods on clouds a thousand times as long as wide.
pub(crate) fn trade(trade: &Trade) {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let planted: Vec<Planted> = (0..SETS).map(|_| planted(&mut random, 6)).collect();
    let (truths, sets): (Vec<_>, Vec<_>) = planted.into_iter().map(|p| (p.truth, p.set)).unzip();
    let solvers = Method::ALL.map(Solver::Ours);
    let times = turns(trade.rounds(3, 200), solvers.len(), |k| solvers[k].work(&sets));
    let worst = |solver| {
        sets.iter()
            .zip(&truths)
            .map(|(set, truth)| off(solver, set, *truth))
            .fold(0.0, f64::max)
    };
    let row = |(solver, time): (Solver, f64)| -> Row { (solver.typed(), 1e9 * time / SETS as f64, worst(solver)) };
    let rows: Vec<Row> = solvers.into_iter().zip(times).map(row).collect();
    let dial = Dial {
        name: "registration-method",
        chosen: Solver::Ours(Method::default()).typed(),
        time_unit: "ns a registration of 24 pairs",
        error_unit: "rad",
        against: "worst angle of 64 to a rotation known exactly; clouds a thousand times as long as wide without noise",
    };
    trade.write(&dial, &rows);
}

fn on_one_condition(planted: Vec<Planted>) -> Vec<Rung> {
    let (truths, sets): (Vec<_>, Vec<_>) = planted.into_iter().map(|p| ((p.truth, p.condition), p.set)).unzip();
    let sets = &sets[..];
    let contestants =
        Solver::ALL.map(|solver| -> (String, Work<'_>) { (solver.name(), Box::new(move || solver.work(sets))) });
    let times = race(&mut Vec::from(contestants));
    let condition = median(truths.iter().map(|(_, condition)| *condition).collect());
    let rung = |(solver, time_ns): (Solver, f64)| {
        let angles: Vec<f64> = sets
            .iter()
            .zip(&truths)
            .map(|(set, (truth, _))| off(solver, set, *truth))
            .collect();
        let unit = |(angle, (_, condition)): (&f64, &(Rotation, f64))| angle / (0.5 * f64::EPSILON * condition);
        let units: Vec<f64> = angles.iter().zip(&truths).map(unit).collect();
        Rung {
            solver,
            condition,
            time_ns,
            lost: angles.iter().filter(|angle| **angle > LOST_RAD).count(),
            angle_rad: [median(angles.clone()), angles.into_iter().fold(0.0, f64::max)],
            units: [median(units.clone()), units.into_iter().fold(0.0, f64::max)],
        }
    };
    Solver::ALL.into_iter().zip(times).map(rung).collect()
}

pub(crate) fn median(mut list: Vec<f64>) -> f64 {
    list.sort_by(f64::total_cmp);
    list.get(list.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The angle to the truth, rad.
fn off(solver: Solver, set: &Set, truth: Rotation) -> f64 {
    let found = solver.solve(set).and_then(|m| {
        let rows = [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
        RotationMatrix::nearest(rows).ok()
    });
    found.map_or(f64::INFINITY, |nearest| nearest.matrix.rotation().distance(truth))
}

fn planted(random: &mut Random, power: i32) -> Planted {
    let q = whole_quaternion(random);
    let denominator: f64 = q.iter().map(|x| x * x).sum();
    // N times the rotation: whole numbers. Its columns are the axes of the cloud in `to`.
    let scaled = matrix(q.map(|x| x / denominator.sqrt())).map(|x| (x * denominator).round());
    let width = (LENGTH / (2.0 * 10.0_f64.powi(power)).sqrt()).min(LENGTH);
    let shape = [LENGTH, width, width];
    let mut local = || shape.map(|half| (half * random.next()).round());
    let cloud: Vec<[f64; 3]> = (0..POINTS).map(|_| local()).collect();
    let from = cloud.iter().map(|p| p.map(|x| x * denominator));
    let to = cloud.iter().map(|p| scaled * nalgebra::Vector3::from(*p));
    let set = Set {
        to: to.map(|v| Point::<Ct>::new(v.x, v.y, v.z)).collect(),
        from: from.map(|[x, y, z]| Point::<Tracker>::new(x, y, z)).collect(),
    };
    let truth = Rotation::from_quaternion(q).expect("a quaternion that is not zero");
    let condition = calib::registration::Moments::of(set.pairs()).expect("a cloud");
    let condition = condition.singular_values().condition();
    Planted { set, truth, condition }
}

/// Four whole numbers from -6 to 6, not all zero.
fn whole_quaternion(random: &mut Random) -> [f64; 4] {
    let q = [(); 4].map(|()| (6.0 * random.next()).round());
    if q.iter().all(|x| *x == 0.0) {
        [1.0, 0.0, 0.0, 0.0]
    } else {
        q
    }
}

/// Time and error of each solver over all conditions.
pub(crate) fn summary(rungs: &[Rung]) -> String {
    let mut text = format!(
        "\nwhole fits, conditions 1 to 1e12, exact data\n{:<24}{:>10}{:>10}{:>14}{:>14}{:>14}{:>8}\n",
        "", "ns", "slowest", "median units", "worst units", "worst rad", "lost"
    );
    for solver in Solver::ALL {
        let mine: Vec<&Rung> = rungs.iter().filter(|rung| rung.solver == solver).collect();
        let worst = |of: fn(&Rung) -> f64| mine.iter().map(|r| of(r)).fold(0.0, f64::max);
        let _ = writeln!(
            text,
            "{:<24}{:>10.0}{:>10.0}{:>14.2}{:>14.2e}{:>14.2e}{:>8}",
            solver.name(),
            median(mine.iter().map(|r| r.time_ns).collect()),
            worst(|r| r.time_ns),
            median(mine.iter().map(|r| r.units[0]).collect()),
            worst(|r| r.units[1]),
            worst(|r| r.angle_rad[1]),
            mine.iter().map(|r| r.lost).sum::<usize>()
        );
    }
    text
}
