//! Residuals, their cost, and normal equations.

use fit::Step;
use nalgebra::Vector3;

use super::beyond::{Say, beyond_cost};
use super::equations::Sums;
use super::{Anchor, Matrix8, Priors, State, UNKNOWNS, Vector8};
use crate::points::Cloud;
use crate::{Field, Kernel};

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
        (d, n, self.is_beyond(p))
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
    /// Which points are taken for ones beyond an open border whatever their nearest place says; empty for none.
    pub(crate) beyond: &'a [bool],
    /// Steps shorter than this end it, mm.
    pub(crate) settled_mm: f64,
    /// Whether a step goes to the minimum of the residuals as they are linear here, with the weights that they have there, and not with
    /// those of here: worth it where distances are dear.
    pub(crate) is_dear: bool,
}

/// Normal equations at a state.
#[derive(Debug, Clone)]
pub(crate) struct At {
    pub(crate) matrix: Matrix8,
    pub(crate) slope: Vector8,
    /// The residuals that have a say, where [`Problem::is_dear`].
    rows: Vec<Row>,
    /// What is known before, alone.
    known: Option<(Matrix8, Vector8)>,
}

impl At {
    /// The normal equations of what is known before, where [`Problem::is_dear`].
    pub(crate) fn known(&self) -> Matrix8 {
        self.known.as_ref().map_or_else(Matrix8::zeros, |known| known.0)
    }
}

/// A residual as it is linear at a state.
#[derive(Debug, Clone, Copy)]
struct Row {
    deviations: f64,
    slope: Vector8,
    vote: f64,
}

/// Rounds of a step over linear residuals.
const INNER_ROUNDS: usize = 12;

impl<D: Distances> Problem<'_, D> {
    /// The residual of a point in deviations with its derivative, and whether it may have a say.
    #[inline]
    pub(crate) fn residual(&self, i: usize, state: &State) -> (f64, Vector8, Say) {
        let cloud = self.cloud;
        let beam = state.turn * cloud.deep[i];
        let arm = state.turn * cloud.places[i] - beam * state.scale;
        let sharp = self.sharp[i];
        let reach = self.kernel.reach() / sharp + state.offset.abs() + MOST_BEND_MM;
        let (d, n, is_open) = self.distances.look(i, &(arm + state.shift), reach);
        let w = arm.cross(&n);
        let slope = Vector8::from([w.x, w.y, w.z, n.x, n.y, n.z, -n.dot(&beam), -1.0]) * sharp;
        let is_open = is_open || self.beyond.get(i).copied().unwrap_or(false);
        let say = match self.facing {
            _ if is_open => Say::Beyond,
            Some(limit) if n.dot(&(state.turn * cloud.beams[i])) > limit => Say::FacesAway,
            _ => Say::Has,
        };
        let bend = self.bends.get(i).copied().unwrap_or(0.0);
        ((d - bend - state.offset) * sharp, slope, say)
    }

    /// The derivative of a point's residual by the unknowns, the distance's gradient being `n`.
    pub(crate) fn slope(&self, i: usize, state: &State, n: &Vector3<f64>) -> Vector8 {
        let beam = state.turn * self.cloud.deep[i];
        let arm = state.turn * self.cloud.places[i] - beam * state.scale;
        let w = arm.cross(n);
        Vector8::from([w.x, w.y, w.z, n.x, n.y, n.z, -n.dot(&beam), -1.0]) * self.sharp[i]
    }

    /// Cost and normal equations. The cost is in squares of deviations.
    pub(crate) fn sum(&self, state: &State) -> (f64, At) {
        let mut cost = 0.0;
        let mut sums = Sums::new();
        let mut rows = Vec::with_capacity(if self.is_dear { self.cloud.len() } else { 0 });
        let (mut known, mut beyond) = (0.0, 0.0);
        for i in 0..self.cloud.len() {
            let (s, j, say) = self.residual(i, state);
            let vote = self.cloud.votes[i];
            if say == Say::Beyond {
                beyond += vote;
                continue;
            }
            known += vote;
            if say == Say::FacesAway {
                // As dear as one infinitely far away: nothing is gained by turning a point's back to the bone.
                cost += vote * self.kernel.most();
                continue;
            }
            let (c, w) = self.kernel.at(s * s);
            cost += vote * c;
            let weight = vote * w;
            if weight > 0.0 {
                sums.add(&j, s, weight);
            }
            if self.is_dear {
                rows.push(Row {
                    deviations: s,
                    slope: j,
                    vote,
                });
            }
        }
        cost += beyond_cost(cost, known, beyond, self.kernel.most());
        let (matrix, slope) = sums.whole();
        let mut at = At {
            matrix,
            slope,
            rows,
            known: None,
        };
        if self.is_dear {
            let mut known = At {
                matrix: Matrix8::zeros(),
                slope: Vector8::zeros(),
                rows: Vec::new(),
                known: None,
            };
            self.known(state, &mut known);
            at.known = Some((known.matrix, known.slope));
        }
        cost += self.known(state, &mut at);
        (cost, at)
    }

    /// From a first step to the minimum of linear residuals: weights by the residuals where the step leads, and a step by those weights,
    /// until it stays. A step by the weights of where it began goes half of the way where many points are near the kernel's edge, and
    /// each costs the nearest places of all points.
    fn inner(&self, at: &At, first: Vector8) -> Option<Vector8> {
        let (known, pull) = at.known.as_ref()?;
        let mut step = first;
        for _ in 0..INNER_ROUNDS {
            let mut sums = Sums::new();
            for row in &at.rows {
                // Where the step of before leads, as the residual is linear: its weight is taken there, the equations stay those of here.
                let s = row.deviations + row.slope.dot(&step);
                let weight = row.vote * self.kernel.at(s * s).1;
                if weight > 0.0 {
                    sums.add(&row.slope, row.deviations, weight);
                }
            }
            let (matrix, slope) = sums.whole();
            let (mut matrix, mut slope) = (matrix + known, slope + pull);
            self.hold(&mut matrix, &mut slope);
            for k in 0..UNKNOWNS {
                matrix[(k, k)] += 1e-9;
            }
            let next = -matrix.cholesky()?.solve(&slope);
            let change = self.length(&(next - step));
            step = next;
            if change < 0.1 * self.settled_mm {
                break;
            }
        }
        Some(step)
    }

    /// Millimetres at the points: what a turn does at their radius, a scale at the depth of 50 mm.
    fn length(&self, step: &Vector8) -> f64 {
        let (turn, shift) = (step.fixed_rows::<3>(0).norm(), step.fixed_rows::<3>(3).norm());
        turn * self.cloud.radius_mm + shift + 50.0 * step[6].abs() + step[7].abs()
    }

    /// Gives each number that is held an equation of its own, which has nothing to do with the others.
    fn hold(&self, matrix: &mut Matrix8, slope: &mut Vector8) {
        for (place, sigma) in [(6, self.priors.depth_scale), (7, self.priors.offset_mm)] {
            if sigma <= 0.0 {
                matrix.row_mut(place).fill(0.0);
                matrix.column_mut(place).fill(0.0);
                matrix[(place, place)] = 1.0;
                slope[place] = 0.0;
            }
        }
    }

    /// The cost of what is known before.
    pub(crate) fn known_cost(&self, state: &State) -> f64 {
        let mut nowhere = At {
            matrix: Matrix8::zeros(),
            slope: Vector8::zeros(),
            rows: Vec::new(),
            known: None,
        };
        self.known(state, &mut nowhere)
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
            }
        }
        self.hold(&mut at.matrix, &mut at.slope);
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
        let mut step = -matrix.cholesky()?.solve(&at.slope);
        // Where that led up, the surface is not as linear as this, and plain steps follow.
        if self.is_dear && damping == 0.0 {
            step = self.inner(at, step).unwrap_or(step);
        }
        Some(Step {
            to: state.moved(&step)?,
            length: self.length(&step),
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
                beyond: &[],
                settled_mm: 1e-3,
                is_dear: false,
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
            beyond: &[],
            settled_mm: 1e-3,
            is_dear: false,
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
