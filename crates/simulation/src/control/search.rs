//! A line search that lets no energy rise.

use super::Potential;
use super::rounding::Rounding;

/// The part of the first-order decrease that a step must bring (Armijo).
const ARMIJO: f64 = 1e-4;
/// Halvings before a search gives up.
const MOST_HALVINGS: usize = 40;
/// Energies are compared to this relative rounding.
const ROUNDING: f64 = 1e-13;
/// Without any load forces are measured by so many times what rounding leaves of them.
const ROUNDED: f64 = 1e8;
/// Of the way to the first touch.
const BEFORE_TOUCH: f64 = 0.9;

/// Energy and gradient of a state.
#[derive(Debug, Clone)]
pub(super) struct Point {
    pub(super) energy: f64,
    pub(super) gradient: Vec<f64>,
}

/// The largest absolute value.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

impl Point {
    pub(super) fn of(potential: &impl Potential, a: &[f64]) -> Option<Self> {
        let mut gradient = vec![0.0; potential.size()];
        let energy = potential.gradient(a, &mut gradient)?;
        let finite = energy.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then_some(Self { energy, gradient })
    }

    /// The largest free force, and the largest outer force or reaction of what is fixed.
    ///
    /// Where there is neither, the largest force of a constraint, or where there is none either so much that 1e-8 of it is rounding.
    pub(super) fn balance(&self, potential: &impl Potential, a: &[f64]) -> (f64, f64) {
        let (mut residual, mut load) = (0.0_f64, 0.0_f64);
        for (i, (g, fixed)) in self.gradient.iter().zip(potential.fixed()).enumerate() {
            if *fixed {
                load = load.max(g.abs());
            } else {
                residual = residual.max(g.abs());
                load = load.max(potential.load(i).abs());
            }
        }
        let load = if load > 0.0 {
            load
        } else {
            let rounding = Rounding::of(potential, a).largest(potential.fixed());
            potential.reaction(a).max(ROUNDED * rounding)
        };
        (residual, load)
    }
}

impl Point {
    /// True where every free force is below `wanted` or below its rounding, 2^-52 `factor` times `sizes`.
    pub(super) fn within(&self, potential: &impl Potential, wanted: f64, sizes: &[f64], factor: f64) -> bool {
        let free = self.gradient.iter().zip(potential.fixed()).zip(sizes);
        free.filter(|((_, fixed), _)| !**fixed)
            .all(|((g, _), size)| g.abs() <= wanted.max(factor * f64::EPSILON * size))
    }
}

/// A step to try.
pub(super) struct Line<'a, P> {
    potential: &'a P,
    a: &'a [f64],
    at: &'a Point,
    step: Vec<f64>,
    /// Slope of the energy along the step, below zero.
    slope: f64,
    capped: bool,
    touches: bool,
}

/// A state that was accepted.
pub(super) struct Next {
    pub(super) a: Vec<f64>,
    pub(super) point: Point,
    t: f64,
}

impl<'a, P: Potential> Line<'a, P> {
    /// Shortens the step to the radius and to what may be passed.
    pub(super) fn new(potential: &'a P, a: &'a [f64], at: &'a Point, mut step: Vec<f64>, radius: f64) -> Self {
        let length = largest(&step);
        let capped = length > radius;
        if capped {
            step.iter_mut().for_each(|s| *s *= radius / length);
        }
        let reach = potential.reach(a, &step);
        let touches = reach < 1.0;
        if touches {
            step.iter_mut().for_each(|s| *s *= BEFORE_TOUCH * reach);
        }
        let slope = at.gradient.iter().zip(&step).map(|(g, s)| g * s).sum();
        Self {
            potential,
            a,
            at,
            step,
            slope,
            capped,
            touches,
        }
    }

    /// The first of the halved steps that lowers the energy enough; where energies differ by rounding only, that keeps
    /// it and flattens the slope (Hager and Zhang 2005).
    pub(super) fn search(&self, evaluations: &mut usize) -> Option<Next> {
        let mut t = 1.0;
        for _ in 0..MOST_HALVINGS {
            let a = self.moved(t);
            *evaluations += 1;
            if let Some(point) = self.point(&a, t) {
                let enough = point.energy <= self.at.energy + ARMIJO * t * self.slope;
                let slope: f64 = point.gradient.iter().zip(&self.step).map(|(g, s)| g * s).sum();
                if enough || (slope <= (2.0 * ARMIJO - 1.0) * self.slope && slope >= 0.9 * self.slope) {
                    return Some(Next { a, point, t });
                }
            }
            t *= 0.5;
        }
        None
    }

    /// Where the part `t` of the step leads: with its turns made whole where that way is free.
    fn moved(&self, t: f64) -> Vec<f64> {
        let part: Vec<f64> = self.step.iter().map(|s| t * s).collect();
        let turned = self.potential.turned(self.a, &part);
        let free = turned.filter(|step| self.potential.reach(self.a, step) >= 1.0);
        let step = free.unwrap_or(part);
        self.a.iter().zip(step).map(|(a, s)| a + s).collect()
    }

    /// The state at `t`, where its energy is not above that of the start. A whole step mostly does: its gradient is asked for at
    /// once, and its energy comes with it.
    fn point(&self, a: &[f64], t: f64) -> Option<Point> {
        let most = self.at.energy + self.rounding();
        if t < 1.0 && !self.potential.energy(a).is_some_and(|energy| energy <= most) {
            return None;
        }
        Point::of(self.potential, a).filter(|point| point.energy <= most)
    }

    fn rounding(&self) -> f64 {
        ROUNDING * self.at.energy.abs()
    }

    /// True for a step that nothing has shortened.
    pub(super) fn whole(&self, next: &Next) -> bool {
        next.t >= 1.0 && !self.capped && !self.touches
    }

    /// Wider after a full step that the radius cut, narrower after a short one.
    pub(super) fn next_radius(&self, next: &Next, radius: f64) -> f64 {
        match next.t {
            1.0 if self.capped && !self.touches => 2.0 * radius,
            t if t < 0.25 => (4.0 * t * largest(&self.step)).min(radius).max(1e-3 * radius),
            _ => radius,
        }
    }
}
