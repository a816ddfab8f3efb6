//! Residuals, their cost, and normal equations.

use std::cell::Cell;

use fit::Step;
use geometry::Frame;
use nalgebra::Vector3;

use super::{Anchor, Matrix8, Priors, State, UNKNOWNS, Vector8};
use crate::points::Cloud;
use crate::{Field, Kernel, Surface};

/// No bend is taken for more than this, mm.
pub(crate) const MOST_BEND_MM: f64 = 1.0;

/// Where distances come from.
pub(crate) trait Distances {
    /// Signed distance, gradient, and whether nothing is known beyond the nearest place; `point` is the point's number. What is further
    /// than `reach_mm` need be known roughly only.
    fn look(&self, point: usize, p: &Vector3<f64>, reach_mm: f64) -> (f64, Vector3<f64>, bool);
}

impl Distances for Field {
    #[inline]
    fn look(&self, _: usize, p: &Vector3<f64>, _: f64) -> (f64, Vector3<f64>, bool) {
        let (d, n) = Field::look(self, p);
        (d, n, false)
    }
}

/// The surface itself, with the triangle that each point was nearest to the last time.
pub(crate) struct Exact<'a, F> {
    surface: &'a Surface<F>,
    field: &'a Field,
    hints: Vec<Cell<u32>>,
}

impl<'a, F: Frame> Exact<'a, F> {
    pub(crate) fn new(surface: &'a Surface<F>, field: &'a Field, points: usize) -> Self {
        Self {
            surface,
            field,
            hints: vec![Cell::new(0); points],
        }
    }
}

impl<F: Frame> Distances for Exact<'_, F> {
    fn look(&self, point: usize, p: &Vector3<f64>, reach_mm: f64) -> (f64, Vector3<f64>, bool) {
        // A nearest place that is far away is dear to find, and a point that has no say need not have it. Within a cell the field is
        // wrong by less than its diagonal.
        let (d, n) = self.field.look(p);
        if d.abs() > reach_mm + 1.8 * self.field.spacing().spacing_mm {
            return (d, n, false);
        }
        let hint = &self.hints[point];
        let Some(foot) = self.surface.foot(p, Some(hint.get())) else {
            return (f64::NAN, Vector3::zeros(), true);
        };
        hint.set(foot.triangle);
        let (d, n) = foot.signed(p);
        (d, n, foot.is_open)
    }
}

/// One stage of a fit.
pub(crate) struct Problem<'a, D> {
    pub(crate) cloud: &'a Cloud,
    pub(crate) distances: &'a D,
    pub(crate) anchors: &'a [Anchor],
    pub(crate) priors: &'a Priors,
    pub(crate) kernel: Kernel,
    /// Cosine between beam and outward normal from which on a point faces away and has no say; `None` asks for nothing.
    pub(crate) facing: Option<f64>,
    /// One over each point's deviation, 1/mm.
    pub(crate) sharp: &'a [f64],
    /// By how much each point lies outside of the surface on average because the surface bends, mm; empty where that is left out.
    pub(crate) bends: &'a [f64],
    /// Steps shorter than this end it, mm.
    pub(crate) settled_mm: f64,
}

/// Normal equations at a state.
#[derive(Debug, Clone)]
pub(crate) struct At {
    pub(crate) matrix: Matrix8,
    pub(crate) slope: Vector8,
}

impl<D: Distances> Problem<'_, D> {
    /// The residual of a point in deviations with its derivative, and whether it may have a say.
    #[inline]
    pub(crate) fn residual(&self, i: usize, state: &State) -> (f64, Vector8, bool) {
        let cloud = self.cloud;
        let beam = state.turn * cloud.deep[i];
        let arm = state.turn * cloud.places[i] - beam * state.scale;
        let sharp = self.sharp[i];
        let reach = self.kernel.reach() / sharp + state.offset.abs() + MOST_BEND_MM;
        let (d, n, is_open) = self.distances.look(i, &(arm + state.shift), reach);
        let w = arm.cross(&n);
        let slope = Vector8::from([w.x, w.y, w.z, n.x, n.y, n.z, -n.dot(&beam), -1.0]) * sharp;
        let faces = self
            .facing
            .is_none_or(|limit| n.dot(&(state.turn * cloud.beams[i])) <= limit);
        let bend = self.bends.get(i).copied().unwrap_or(0.0);
        ((d - bend - state.offset) * sharp, slope, faces && !is_open)
    }

    /// Cost and normal equations. The cost is in squares of deviations.
    pub(crate) fn sum(&self, state: &State) -> (f64, At) {
        let mut cost = 0.0;
        let mut upper = [0.0; 36];
        let mut slope = [0.0; UNKNOWNS];
        for i in 0..self.cloud.len() {
            let (s, j, has_say) = self.residual(i, state);
            let vote = self.cloud.votes[i];
            if !has_say {
                // As dear as one infinitely far away: nothing is gained by turning a point's back to the bone.
                cost += vote * self.kernel.most();
                continue;
            }
            let (c, w) = self.kernel.at(s * s);
            cost += vote * c;
            let weight = vote * w;
            if weight > 0.0 {
                let mut place = 0;
                for row in 0..UNKNOWNS {
                    let wj = weight * j[row];
                    slope[row] += wj * s;
                    for column in row..UNKNOWNS {
                        upper[place] += wj * j[column];
                        place += 1;
                    }
                }
            }
        }
        let mut at = whole(&upper, &slope);
        cost += self.known(state, &mut at);
        (cost, at)
    }

    /// Adds what is known before, and gives its cost.
    fn known(&self, state: &State, at: &mut At) -> f64 {
        let mut cost = 0.0;
        let numbers = [
            (6, state.scale, self.priors.depth_scale),
            (7, state.offset, self.priors.offset_mm),
        ];
        for (place, value, sigma) in numbers {
            if sigma > 0.0 {
                let sharp = 1.0 / (sigma * sigma);
                cost += value * value * sharp;
                at.matrix[(place, place)] += sharp;
                at.slope[place] += value * sharp;
            } else {
                // Held: an equation of its own that has nothing to do with the others.
                at.matrix.row_mut(place).fill(0.0);
                at.matrix.column_mut(place).fill(0.0);
                at.matrix[(place, place)] = 1.0;
                at.slope[place] = 0.0;
            }
        }
        for anchor in self.anchors {
            let arm = state.turn * anchor.from;
            let off = arm + state.shift - anchor.to;
            let sharp = 1.0 / (anchor.sigma_mm * anchor.sigma_mm);
            cost += off.norm_squared() * sharp;
            let cross = arm.cross_matrix();
            // off' = -[arm]x w + v.
            let mut block = at.matrix.fixed_view_mut::<3, 3>(0, 0);
            block += cross.transpose() * cross * sharp;
            let mut block = at.matrix.fixed_view_mut::<3, 3>(0, 3);
            block += cross * sharp;
            let mut block = at.matrix.fixed_view_mut::<3, 3>(3, 0);
            block -= cross * sharp;
            for k in 3..6 {
                at.matrix[(k, k)] += sharp;
            }
            let turn = arm.cross(&off) * sharp;
            let mut rows = at.slope.fixed_rows_mut::<3>(0);
            rows += turn;
            let mut rows = at.slope.fixed_rows_mut::<3>(3);
            rows += off * sharp;
        }
        cost
    }
}

fn whole(upper: &[f64; 36], slope: &[f64; UNKNOWNS]) -> At {
    let mut matrix = Matrix8::zeros();
    let mut place = 0;
    for row in 0..UNKNOWNS {
        for column in row..UNKNOWNS {
            matrix[(row, column)] = upper[place];
            matrix[(column, row)] = upper[place];
            place += 1;
        }
    }
    At {
        matrix,
        slope: Vector8::from(*slope),
    }
}

impl<D: Distances> fit::Problem for Problem<'_, D> {
    type State = State;
    type At = At;

    fn look(&self, state: &State) -> Option<(f64, At)> {
        let (cost, at) = self.sum(state);
        cost.is_finite().then_some((cost, at))
    }

    fn step(&self, state: &State, at: &At, damping: f64) -> Option<Step<State>> {
        let mut matrix = at.matrix;
        for k in 0..UNKNOWNS {
            // A direction that nothing holds has a zero here: the least that keeps the equations regular, in which nothing moves.
            matrix[(k, k)] += at.matrix[(k, k)] * damping + 1e-9;
        }
        let step = -matrix.cholesky()?.solve(&at.slope);
        let (turn, shift) = (step.fixed_rows::<3>(0).norm(), step.fixed_rows::<3>(3).norm());
        // Millimetres at the points: what a turn does at their radius, a scale at the depth of 50 mm.
        let length = turn * self.cloud.radius_mm + shift + 50.0 * step[6].abs() + step[7].abs();
        Some(Step {
            to: state.moved(&step)?,
            length,
            gain: -step.dot(&at.slope),
        })
    }

    fn is_last(&self, step: &Step<State>, _at: &At, damping: f64) -> bool {
        damping <= 1.0 && step.length < self.settled_mm
    }

    fn is_flat(&self, step: &Step<State>, _damping: f64) -> bool {
        step.length < self.settled_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::points::{Beam, BeamNoise, Points, SurfacePoint};
    use crate::solve::turned;
    use chance::Chance;
    use geometry::{Direction, Point, Tracker};

    /// A ball of 40 mm about the origin, in closed form.
    struct Ball;

    impl Distances for Ball {
        fn look(&self, _: usize, p: &Vector3<f64>, _: f64) -> (f64, Vector3<f64>, bool) {
            (p.norm() - 40.0, p / p.norm(), false)
        }
    }

    fn points() -> Points<Tracker> {
        let point = |i: u64| {
            let c = Chance::new(11, i);
            let [x, y, z] = [0, 1, 2].map(|k| 40.0 * c.normal(k));
            let beam = Beam {
                direction: geometry::Vector::new(c.normal(5), c.normal(6), 1.0)
                    .direction()
                    .unwrap(),
                depth_mm: Some(20.0 + 10.0 * c.uniform(9)),
            };
            let noise = BeamNoise {
                axial_mm: 0.5,
                lateral_mm: 1.0,
                elevation_mm: 1.5,
            };
            SurfacePoint::seen(Point::new(x, y, z), beam, Direction::X, noise)
        };
        Points::new(&(0..20).map(point).collect::<Vec<_>>(), None, 0.0).unwrap()
    }

    /// Central differences of the cost, with every part of it: residuals, both kernels, priors and landmarks.
    #[test]
    fn the_slope_is_that_of_the_cost() {
        let points = points();
        let sharp = vec![1.3; 20];
        let anchor = Anchor {
            from: Vector3::new(3.0, -20.0, 11.0),
            to: Vector3::new(30.0, 5.0, -9.0),
            sigma_mm: 4.0,
        };
        let priors = Priors::default();
        for kernel in [Kernel::Wide(20.0), Kernel::Tukey(30.0)] {
            let problem = Problem {
                cloud: &points.cloud,
                distances: &Ball,
                anchors: &[anchor],
                priors: &priors,
                kernel,
                facing: None,
                sharp: &sharp,
                bends: &[],
                settled_mm: 1e-3,
            };
            let state = State {
                turn: turned(&Vector3::new(0.3, -0.7, 1.1)),
                shift: Vector3::new(4.0, 2.0, -7.0),
                scale: 0.02,
                offset: 0.4,
            };
            let (_, at) = problem.sum(&state);
            for k in 0..UNKNOWNS {
                let h = if k < 3 { 1e-6 } else { 1e-5 };
                let mut step = Vector8::zeros();
                step[k] = h;
                let (ahead, back) = (state.moved(&step).unwrap(), state.moved(&-step).unwrap());
                let slope = (problem.sum(&ahead).0 - problem.sum(&back).0) / (2.0 * h);
                // A cost of some thousands is rounded by 1e-12 of itself: below 1e-2 of the slope's difference at 1e-6.
                assert!(
                    (slope - 2.0 * at.slope[k]).abs() < 1e-5 * (1.0 + slope.abs()) + 1e-2,
                    "{kernel:?} {k}: {slope} {}",
                    at.slope[k]
                );
            }
        }
    }

    #[test]
    fn a_number_whose_prior_is_zero_stays_where_it_is() {
        let points = points();
        let priors = Priors {
            depth_scale: 0.0,
            offset_mm: 0.0,
            ..Priors::default()
        };
        let sharp = vec![1.0; 20];
        let problem = Problem {
            cloud: &points.cloud,
            distances: &Ball,
            anchors: &[],
            priors: &priors,
            kernel: Kernel::Tukey(30.0),
            facing: None,
            sharp: &sharp,
            bends: &[],
            settled_mm: 1e-3,
        };
        let start = State {
            turn: turned(&Vector3::zeros()),
            shift: Vector3::new(4.0, 2.0, -7.0),
            scale: 0.0,
            offset: 0.0,
        };
        let (_, at) = problem.sum(&start);
        let step = fit::Problem::step(&problem, &start, &at, 1e-3).unwrap();
        assert!(step.to.shift != start.shift);
        assert_eq!((step.to.scale, step.to.offset), (0.0, 0.0));
    }
}
