//! The iteration on problems whose least is known, and each of its ends.

use fit::{Damping, End, Limits, Made, Outcome, Problem, Rule, Step, least_squares, median};

const FACTORS: Rule = Rule::Factors {
    fall: 0.1,
    least: 1e-15,
    rise: 10.0,
    raised: 1e-6,
};
const DAMPING: Damping = Damping {
    start: 1e-3,
    rule: FACTORS,
    most: 1e16,
    singular: false,
};

/// Residuals of two numbers, and their derivatives.
type Residuals = fn([f64; 2]) -> ([f64; 2], [[f64; 2]; 2]);

/// `J^T J` and `-J^T r`.
type Equations = ([[f64; 2]; 2], [f64; 2]);

/// Two residuals of two numbers, to a step of `end`.
struct Pair {
    residuals: Residuals,
    end: f64,
    /// A step below this that leads up ends on a flat cost.
    flat: f64,
    /// A step below this ends without a look at where it leads.
    last: f64,
}

impl Pair {
    fn of(residuals: Residuals) -> Self {
        Self {
            residuals,
            end: 1e-14,
            flat: 0.0,
            last: 0.0,
        }
    }
}

impl Problem for Pair {
    type State = [f64; 2];
    type At = Equations;

    fn look(&self, x: &[f64; 2]) -> Option<(f64, Self::At)> {
        let (r, j) = (self.residuals)(*x);
        let product = |a: usize, b: usize| j[0][a] * j[0][b] + j[1][a] * j[1][b];
        let matrix = [[product(0, 0), product(0, 1)], [product(1, 0), product(1, 1)]];
        let vector = [0, 1].map(|k| -(j[0][k] * r[0] + j[1][k] * r[1]));
        Some((r[0] * r[0] + r[1] * r[1], (matrix, vector)))
    }

    fn step(&self, x: &[f64; 2], (m, v): &Self::At, damping: f64) -> Option<Step<[f64; 2]>> {
        let (a, b, c) = (m[0][0] * (1.0 + damping), m[0][1], m[1][1] * (1.0 + damping));
        let det = a * c - b * b;
        let step = [(c * v[0] - b * v[1]) / det, (a * v[1] - b * v[0]) / det];
        (det != 0.0).then(|| Step {
            to: [x[0] + step[0], x[1] + step[1]],
            length: step[0].hypot(step[1]),
            gain: step[0] * (v[0] + damping * m[0][0] * step[0]) + step[1] * (v[1] + damping * m[1][1] * step[1]),
        })
    }

    fn is_last(&self, step: &Step<[f64; 2]>, _: &Self::At, _: f64) -> bool {
        step.length < self.last
    }

    fn is_flat(&self, step: &Step<[f64; 2]>, _: f64) -> bool {
        step.length < self.flat
    }

    fn is_settled(&self, made: &Made<'_, [f64; 2], Self::At>) -> bool {
        made.length <= self.end
    }
}

/// Rosenbrock's valley, least at (1, 1): whole steps leave it.
fn valley([x, y]: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
    ([10.0 * (y - x * x), 1.0 - x], [[-20.0 * x, 10.0], [-1.0, 0.0]])
}

fn solved(problem: &Pair, start: [f64; 2], damping: Damping, steps: usize) -> Outcome<[f64; 2], Equations> {
    least_squares(problem, start, damping, Limits::steps(steps)).expect("a start that is possible")
}

#[test]
fn the_least_of_a_curved_valley_is_found_from_everywhere_by_both_rules() {
    let gained = Damping {
        rule: Rule::Gained { least: 1e-15 },
        ..DAMPING
    };
    for damping in [DAMPING, gained] {
        for i in 0..200 {
            // From 1e-4 to 1e4 away, to all sides.
            let (far, angle) = (10.0_f64.powf(f64::from(i % 9) - 4.0), f64::from(i));
            let start = [1.0 + far * angle.cos(), 1.0 + far * angle.sin()];
            let found = solved(&Pair::of(valley), start, damping, 10_000);
            // The residuals vanish there: steps end where they do, to the rounding of 1.
            let off = (found.state[0] - 1.0).hypot(found.state[1] - 1.0);
            assert!(off < 1e-12, "{start:?}: {found:?}");
            assert!(found.cost <= valley(start).0.iter().map(|r| r * r).sum::<f64>());
        }
    }
}

#[test]
fn each_end_has_its_name() {
    // A line of leasts: both residuals are of the sum.
    let line: Residuals = |[x, y]| ([x + y - 2.0, 2.0 * (x + y) - 4.0], [[1.0, 1.0], [2.0, 2.0]]);
    let none = Damping { start: 0.0, ..DAMPING };
    let singular = solved(&Pair::of(line), [5.0, 0.0], none, 10);
    assert_eq!(
        (singular.end, singular.state, singular.steps),
        (End::Singular, [5.0, 0.0], 0)
    );
    let damped = solved(&Pair::of(line), [5.0, 0.0], Damping { singular: true, ..none }, 100);
    // Damping of the diagonal goes the shortest way: both numbers by the same.
    assert!(
        (damped.state[0] - 3.5).hypot(damped.state[1] + 1.5) < 1e-8,
        "{damped:?}"
    );

    let few = solved(&Pair::of(valley), [-1.2, 1.0], DAMPING, 3);
    assert_eq!((few.end, few.steps), (End::OutOfSteps, 3));
    let settled = solved(&Pair::of(valley), [-1.2, 1.0], DAMPING, 1000);
    assert_eq!(settled.end, End::Settled);

    let last = Pair {
        last: 1e-3,
        ..Pair::of(valley)
    };
    let last = solved(&last, [-1.2, 1.0], DAMPING, 1000);
    assert_eq!(last.end, End::Last);
    // Cost and equations are those of the state before, as it says: the step went further down than that.
    assert!(
        valley(last.state).0.iter().map(|r| r * r).sum::<f64>() < last.cost,
        "{last:?}"
    );

    // Derivatives that point up: no step leads down.
    let wrong: Residuals = |[x, y]| ([x, y], [[-1.0, 0.0], [0.0, -1.0]]);
    let strict = |tries| Limits {
        flat: 1.0,
        ..Limits::tries(tries)
    };
    // Held back by 1e9, a step is still above the rounding of 1.
    let most = Damping { most: 1e9, ..DAMPING };
    let nowhere = least_squares(&Pair::of(wrong), [1.0, 2.0], most, strict(100)).unwrap();
    assert_eq!((nowhere.end, nowhere.state), (End::Nowhere, [1.0, 2.0]));
    let flat = Pair {
        flat: 10.0,
        ..Pair::of(wrong)
    };
    let flat = least_squares(&flat, [1.0, 2.0], most, strict(100)).unwrap();
    assert_eq!((flat.end, flat.state), (End::Flat, [1.0, 2.0]));
    let tries = least_squares(&Pair::of(wrong), [1.0, 2.0], most, strict(3)).unwrap();
    assert_eq!(tries.end, End::OutOfSteps);
}

/// Beyond 1 the residual is no number, and whole steps go there.
#[test]
fn a_cost_that_is_no_number_is_never_gone_to() {
    let logarithm: Residuals = |[x, y]| {
        let r = (1.0 - x).ln() + 2.0;
        ([r, y], [[-1.0 / (1.0 - x), 0.0], [0.0, 1.0]])
    };
    let start = [-50.0, 3.0];
    let problem = Pair::of(logarithm);
    let (_, at) = problem.look(&start).unwrap();
    let whole = problem.step(&start, &at, 0.0).unwrap().to;
    assert!(problem.look(&whole).unwrap().0.is_nan(), "{whole:?}");
    let found = solved(&problem, start, DAMPING, 200);
    let off = (found.state[0] - (1.0 - (-2.0_f64).exp())).hypot(found.state[1]);
    assert!(off < 1e-14, "{found:?}");
}

#[test]
fn the_start_may_be_impossible() {
    struct Nothing;
    impl Problem for Nothing {
        type State = ();
        type At = ();
        fn look(&self, (): &()) -> Option<(f64, ())> {
            None
        }
        fn step(&self, (): &(), (): &(), _: f64) -> Option<Step<()>> {
            None
        }
    }
    assert!(least_squares(&Nothing, (), DAMPING, Limits::tries(5)).is_none());
}

#[test]
fn damping_falls_by_what_was_gained() {
    let damping = Damping {
        rule: Rule::Gained { least: 1e-9 },
        ..DAMPING
    };
    let after = |ratio: f64| {
        let mut held = damping.held();
        held.lower(ratio);
        held.value / damping.start
    };
    // 1 - (2 ratio - 1)^3, between a tenth and twice.
    for (ratio, factor) in [(1.0, 0.1), (0.5, 1.0), (0.75, 0.875), (0.0, 2.0), (5.0, 0.1)] {
        assert!((after(ratio) - factor).abs() < 1e-12, "{ratio}");
    }
    let mut held = damping.held();
    held.raise();
    held.raise();
    // By 2, then by 4.
    assert!((held.value / damping.start - 8.0).abs() < 1e-12);
}

#[test]
fn a_median_is_the_upper_of_two_in_the_middle() {
    assert_eq!(median(vec![]), 0.0);
    assert_eq!(median(vec![3.0]), 3.0);
    assert_eq!(median(vec![5.0, 1.0, 4.0]), 4.0);
    assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), 3.0);
}

/// 0 times any factor is 0: the same step would be tried without end.
#[test]
fn damping_by_gain_rises_from_zero() {
    let damping = Damping {
        start: 0.0,
        rule: Rule::Gained { least: 0.0 },
        ..DAMPING
    };
    let mut held = damping.held();
    let tries = (0..100).take_while(|_| {
        held.raise();
        held.value <= damping.most
    });
    // By 2, 4, 8, ... from the least number: 2^(k (k + 1) / 2) passes 2^1022 and the bound at k = 46.
    assert!(tries.count() < 50);
}
