//! The second derivatives of the present state, with points that press held at what they press: what small forces and motions do to it, and whether it
//! is a minimum.
//!
//! With `K` the second derivatives of all but the tube and bones, points that press keep no distance, `N u = 0`, and their normals turn as they go along
//! what they press: springs `s = -p A c` along the principal directions of its surface, by pressure, area and curvature, mostly below zero. With all these directions as the rows of `D`,
//!
//! ```text
//! u = K^-1 (f - D^T q),    (D K^-1 D^T + diag(0, 1/s)) q = D K^-1 f - (what is kept, 0)
//! ```
//!
//! `K` alone need not be positive definite: tissue that is pressed is often held by the tube alone. By Haynsworth's law of inertia the state is a minimum, with points that press
//! held, where the matrix of `q` has as many negative eigenvalues as `K` and springs below zero together.

use nalgebra::{DMatrix, DVector, Dyn, LU, SymmetricTridiagonal, Vector3, Vector6};

use super::Frames;
use super::factors::hold;
use super::near::{Active, Near, Tissue};
use super::pressed::bends;
use crate::control::Potential;
use crate::space::tube::Distance;
use crate::sparse::{Ldl, Triplets};

/// A spring weaker than this part of the tissue behind it changes nothing that could be seen, and its inverse would be next to infinite.
const SMALL_PART: f64 = 1e-9;
/// Forces that a solution leaves, beside those that it is of, each by the stiffness of its unknown: factors without pivoting are exact to about
/// 1e-10, or a leading block is next to singular.
const LEFT: f64 = 1e-6;
/// Points that are held are moved by no more than this part of what moves any.
const HELD: f64 = 1e-6;
/// Eigenvalues within so many roundings of the largest entry, times the size, are zero.
const ZERO: f64 = 100.0;

/// Second derivatives without contact and their factor; kept, as its order is found once.
#[derive(Debug)]
pub(super) struct Present {
    matrix: Triplets,
    ldl: Ldl,
}

/// A point that presses.
#[derive(Debug)]
pub(super) struct Pressing {
    /// Among those that may touch.
    pub(super) point: usize,
    /// From the tube's origin.
    pub(super) arm: Vector3<f64>,
    pub(super) distance: Distance,
    pub(super) area: f64,
    pub(super) pressure: f64,
    /// What it presses does not move.
    pub(super) at_bone: bool,
}

/// A direction of a point that presses.
#[derive(Debug)]
struct Row {
    /// Among those that press.
    number: usize,
    direction: Vector3<f64>,
    /// Force by way; `None` of a normal, along which the point is held.
    spring: Option<f64>,
}

/// A settled state, as it gives way to small forces and to small motions of the tube.
#[derive(Debug)]
pub struct Yielding<'a> {
    pub(super) frames: &'a Frames,
    present: &'a Present,
    pub(super) pressing: Vec<Pressing>,
    rows: Vec<Row>,
    /// `None` where nothing presses.
    solved: Option<LU<f64, Dyn, Dyn>>,
}

/// What small forces do, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Of all unknowns, mm.
    pub unknowns: Vec<f64>,
    /// Of the force on the tube, N, and of its moment about the tube's own origin, N mm, in the axes of the model.
    pub on_tube: Vector6<f64>,
}

/// What small forces and ways come to.
pub(super) struct Response {
    /// Changes of all unknowns.
    pub(super) change: Vec<f64>,
    /// Ways of the points that press, and how much their pressures grow.
    pub(super) moved: Vec<Vector3<f64>>,
    pub(super) more: Vec<f64>,
}

impl Frames {
    /// The state as it gives way. `None` where nobody knows how: outside [`super::State::Settled`], or where the state is no minimum with the points held that
    /// press, as just before tissue slips off or gives way by itself.
    pub fn yielding(&mut self) -> Option<Yielding<'_>> {
        if !self.now.settled {
            return None;
        }
        let mut present = self.present.take().unwrap_or_else(|| {
            let (matrix, ldl) = (Triplets::default(), Ldl::ordered_by(self.factors.order().clone()));
            Box::new(Present { matrix, ldl })
        });
        let negative = present.factor(self);
        self.present = Some(present);
        let (negative, frames) = (negative?, &*self);
        let present = frames.present.as_deref()?;
        let pressing = frames.pressing();
        let (rows, matrix) = frames.rows(&present.ldl, &pressing);
        let springs = rows.iter().filter(|row| row.spring.is_some_and(|s| s < 0.0)).count();
        (negative + springs == negative_eigenvalues(&matrix)).then(|| Yielding {
            frames,
            present,
            pressing,
            rows,
            solved: (!matrix.is_empty()).then(|| matrix.lu()),
        })
    }

    fn pressing(&self) -> Vec<Pressing> {
        let (mut v, touches) = (Vec::new(), &self.contact.touches);
        touches.take(&self.now.a, &mut v);
        let (around, origin) = (self.around(&self.now.tube), self.now.tube.pose().translation.vector);
        let each = self.now.pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
        let pressing = each.map(|(point, pressure)| Pressing {
            point,
            arm: touches.at(point, &v) - origin,
            distance: touches.distance(point, &v, &around),
            area: touches.area(point),
            pressure: *pressure,
            at_bone: touches.with(point) > 0,
        });
        pressing.collect()
    }

    /// The directions of points that press, and the matrix of the forces along them.
    fn rows(&self, ldl: &Ldl, pressing: &[Pressing]) -> (Vec<Row>, DMatrix<f64>) {
        let near = Near::new(pressing.iter().map(|p| p.point).collect(), 0.0);
        let tissue = Tissue {
            ldl,
            touches: &self.contact.touches,
        };
        let mut active = Active::default();
        let mut rows = Vec::new();
        for (k, p) in pressing.iter().enumerate() {
            let number = active.take(&tissue, &near, k);
            let normal = p.distance.gradient;
            // Held along the normal: without a spring, as a stiff one would have to be taken off again.
            rows.push(Row {
                number,
                direction: normal,
                spring: None,
            });
            for (direction, curvature) in bends(&p.distance) {
                let spring = -p.pressure * p.area * curvature;
                let own = direction.dot(&(active.block(number, number) * direction));
                if (spring * own).abs() > SMALL_PART {
                    rows.push(Row {
                        number,
                        direction,
                        spring: Some(spring),
                    });
                }
            }
        }
        let entry = |i: usize, j: usize| {
            let (one, other) = (&rows[i], &rows[j]);
            let moved = active.block(one.number, other.number) * other.direction;
            let own = one.spring.filter(|_| i == j).map_or(0.0, f64::recip);
            one.direction.dot(&moved) + own
        };
        let mut matrix = DMatrix::zeros(rows.len(), rows.len());
        for j in 0..rows.len() {
            (j..rows.len()).for_each(|i| matrix[(i, j)] = entry(i, j));
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        (rows, matrix)
    }
}

impl Present {
    /// Takes the second derivatives at the present state, and counts their negative eigenvalues. `None` where there are none, or pivots vanish.
    fn factor(&mut self, frames: &Frames) -> Option<usize> {
        let system = &frames.system;
        system.hessian(&frames.now.a, false, &mut self.matrix)?;
        hold(&mut self.matrix, system);
        Some(self.ldl.factor(&self.matrix, 0.0).ok()?.negative)
    }

    /// Whether what a change leaves of forces is rounding.
    fn is_solved(&self, change: &[f64], forces: &[f64]) -> bool {
        let (against, diagonal) = (self.matrix.product(change), self.matrix.diagonal());
        let each = || {
            forces
                .iter()
                .zip(&diagonal)
                .map(|(force, k)| (force, k.abs().max(f64::MIN_POSITIVE)))
        };
        let all: f64 = each().map(|(force, k)| force * force / k).sum();
        let left: f64 = each()
            .zip(&against)
            .map(|((force, k), by)| (force - by) * (force - by) / k)
            .sum();
        // No number is no answer.
        left <= LEFT * LEFT * all
    }
}

impl Yielding<'_> {
    /// What forces on all unknowns do, N, and ways that points which press must go along their normals, mm: one for each. `None` where rounding has eaten it.
    pub(super) fn response(&self, forces: &[f64], kept: &[f64]) -> Option<Response> {
        let (touches, fixed) = (&self.frames.contact.touches, &self.frames.system.fixed);
        let ldl = &self.present.ldl;
        // What is held has pivots in the matrix like any other unknown.
        let held = forces.iter().zip(fixed);
        let mut forces: Vec<f64> = held.map(|(force, fixed)| if *fixed { 0.0 } else { *force }).collect();
        let mut free = forces.clone();
        ldl.solve(&mut free);
        let moved = self.moved(&free);
        // What contact must undo: where points would go without it, less where they are kept.
        let each = self.rows.iter().map(|row| {
            let kept = if row.spring.is_none() { kept[row.number] } else { 0.0 };
            row.direction.dot(&moved[row.number]) - kept
        });
        let along = DVector::from_iterator(self.rows.len(), each);
        let q = match &self.solved {
            Some(solved) => solved.solve(&along)?,
            None => along,
        };
        // Solved for again with these forces, not added up: the sum of large ways that cancel would keep their rounding.
        let (mut own, mut more) = (vec![0.0; touches.unknowns()], vec![0.0; self.pressing.len()]);
        for (row, q) in self.rows.iter().zip(q.iter()) {
            let p = &self.pressing[row.number];
            touches.push(p.point, &(row.direction * -*q), &mut own);
            if row.spring.is_none() {
                more[row.number] = -q / p.area;
            }
        }
        touches.add(&own, &mut forces);
        forces
            .iter_mut()
            .zip(fixed)
            .filter(|(_, fixed)| **fixed)
            .for_each(|(force, _)| *force = 0.0);
        let mut change = forces.clone();
        ldl.solve(&mut change);
        let moved = self.moved(&change);
        let is_solved = self.present.is_solved(&change, &forces) && self.is_held(&moved, kept);
        is_solved.then_some(Response { change, moved, more })
    }

    /// What small forces on all unknowns do, N, to first order, with the tube where it is: those on unknowns that are held do nothing. `None` where
    /// rounding has eaten it: then it is not known, and not small.
    pub fn to(&self, forces: &[f64]) -> Option<Change> {
        let kept = vec![0.0; self.pressing.len()];
        let found = self.response(forces, &kept)?;
        Some(Change {
            on_tube: self.on_tube(&found),
            unknowns: found.change,
        })
    }

    /// Whether points that press go along their normals as they are kept.
    fn is_held(&self, moved: &[Vector3<f64>], kept: &[f64]) -> bool {
        let far = moved.iter().map(Vector3::norm).chain(kept.iter().map(|way| way.abs()));
        let most = HELD * far.fold(0.0, f64::max);
        let normals = self.rows.iter().filter(|row| row.spring.is_none());
        let mut off = normals.map(|row| (row.direction.dot(&moved[row.number]) - kept[row.number]).abs());
        // No number is no answer.
        off.all(|off| off <= most)
    }

    /// The ways of the points that press.
    fn moved(&self, change: &[f64]) -> Vec<Vector3<f64>> {
        let touches = &self.frames.contact.touches;
        // Places are linear in the unknowns: what takes a state takes a change, too.
        let mut own = Vec::new();
        touches.take(change, &mut own);
        let each = self.pressing.iter();
        each.map(|p| touches.displacement(p.point, &own)).collect()
    }
}

/// How many eigenvalues of a symmetric matrix are surely below zero: by Sturm's sequence of its tridiagonal form. Those that are zero to rounding are none: as many
/// points as press on one face have dependent normals, which add zeros, and a state at the verge is no minimum.
fn negative_eigenvalues(matrix: &DMatrix<f64>) -> usize {
    let zero = ZERO * matrix.nrows() as f64 * f64::EPSILON * matrix.amax();
    if matrix.nrows() < 2 {
        return matrix.iter().filter(|value| **value < -zero).count();
    }
    let form = SymmetricTridiagonal::new(matrix.clone());
    let (diagonal, beside) = (form.diagonal(), form.off_diagonal());
    let smallest = f64::EPSILON * matrix.amax().max(f64::MIN_POSITIVE);
    let (mut count, mut last) = (0, 1.0_f64);
    for (k, own) in diagonal.iter().enumerate() {
        let before = if k > 0 {
            beside[k - 1] * beside[k - 1] / last
        } else {
            0.0
        };
        last = own + zero - before;
        // A pivot that vanishes counts as above zero, and the next as below: as one of either.
        if last.abs() < smallest {
            last = smallest;
        }
        count += usize::from(last < 0.0);
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_eigenvalues_are_counted() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1_u32 << 23) - 1.0
        };
        for size in 0..12 {
            for _ in 0..20 {
                let any = DMatrix::from_fn(size, size, |_, _| next());
                let matrix = &any + any.transpose();
                let expected = match size {
                    0 => 0,
                    _ => matrix
                        .clone()
                        .symmetric_eigen()
                        .eigenvalues
                        .iter()
                        .filter(|l| **l < 0.0)
                        .count(),
                };
                assert_eq!(negative_eigenvalues(&matrix), expected, "{matrix}");
            }
        }
        let two = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        assert_eq!(negative_eigenvalues(&two), 1);
    }

    /// Zeros of dependent normals came out below zero by chance, and stood for directions along which nothing held the state.
    #[test]
    fn dependent_directions_add_no_negative_eigenvalue() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1_u32 << 23) - 1.0
        };
        for (own, more) in [(1, 1), (3, 2), (6, 1), (6, 3), (9, 9)] {
            for _ in 0..40 {
                let any = DMatrix::from_fn(own, own, |_, _| next());
                let matrix = &any + any.transpose();
                let eigenvalues = matrix.clone().symmetric_eigen().eigenvalues;
                // Beside the verge, which is no minimum, whatever rounding says.
                if eigenvalues.iter().any(|value| value.abs() < 1e-6) {
                    continue;
                }
                let rows = DMatrix::from_fn(own + more, own, |i, j| {
                    if i < own { f64::from(u8::from(i == j)) } else { next() }
                });
                let with = &rows * &matrix * rows.transpose();
                let with = (&with + with.transpose()) * 0.5;
                let expected = eigenvalues.iter().filter(|value| **value < 0.0).count();
                assert_eq!(negative_eigenvalues(&with), expected, "{with}");
            }
        }
    }
}
