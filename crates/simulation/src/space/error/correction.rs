//! The way from a state that was taken over from a coarser mesh to the equilibrium of this one: bulk forces by one factorisation,
//! contact exact.
//!
//! The tangent of all that is not contact is factored once, with the unknowns that move points near the tube as its root. What is
//! left on the root, `S`, is small and dense: contact is found there by the augmented Lagrangian, and the other unknowns
//! follow. Forces are then looked at anew and the same factors serve again (modified Newton).

use nalgebra::{DVector, Vector3};

use super::pressed::{Pressed, Spot};
use crate::control::Potential;
use crate::space::system::System;
use crate::space::tube::Tube;
use crate::sparse::{Dissection, Ldl, Triplets};

/// Passes with the same factors at most.
const PASSES: usize = 8;
/// A pass that moves no unknown by more than this part of the largest move so far is the last.
const LAST: f64 = 0.1;
/// A pass that moves them by more than this part of the move before asks for new factors.
const SLOW: f64 = 0.3;
/// After the last pass no more than this may be left.
const MOST_LEFT: f64 = 0.3;
/// Points of the surface nearer to the tube than this part of its radius may come to touch it.
const NEAR: f64 = 0.25;
/// More unknowns of these are refused: they are a dense matrix.
const MOST_ROOT: usize = 3000;

/// A tube that presses on points of a body's surface.
#[derive(Clone, Copy)]
pub struct Touching<'a> {
    /// The body.
    pub body: usize,
    /// The tube.
    pub tube: &'a Tube,
    /// Which points of the surface may touch it, by their reference place and normal.
    pub wanted: &'a dyn Fn(&Vector3<f64>, &Vector3<f64>) -> bool,
}

/// A state in equilibrium but for what the passes left.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// The unknowns.
    pub a: Vec<f64>,
    /// The force on the tube; zero without one.
    pub force: Vector3<f64>,
    /// The largest move of an unknown in the last pass, beside the largest of all together: what is not settled.
    pub left: f64,
    /// Factorisations.
    pub factors: usize,
}

/// Why there is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoCorrection {
    /// The state that was taken over has no energy, or is held by nothing.
    #[error("the state has no energy on the finer mesh, or nothing holds it there")]
    State,
    /// The passes do not settle: the finer mesh is too far from the state, as that of a mesh much too coarse.
    #[error("the last pass still moved an unknown by {left:.2} of the largest move")]
    Unsettled {
        /// That part.
        left: f64,
    },
    /// Contacts of the system's own, whose forces this does not settle.
    #[error(
        "the system has {found} contacts of its own; the one that presses is given by itself, and no other is settled"
    )]
    Contacts {
        /// How many.
        found: usize,
    },
    /// Contact was not found.
    #[error("contact with the tube was not found")]
    Contact,
    /// Too many unknowns near the tube.
    #[error("{found} unknowns move points near the tube; more than {MOST_ROOT} are not tried")]
    Near {
        /// How many.
        found: usize,
    },
}

/// Goes from a state near it to the equilibrium of a system without contacts of its own: `touching` is the one that presses.
///
/// # Errors
/// [`NoCorrection`].
pub fn corrected(system: &System, a: &[f64], touching: Option<&Touching<'_>>) -> Result<Correction, NoCorrection> {
    let own = system.tubes.len() + system.obstacles.len() + system.organs.len();
    let found = own + system.others.iter().filter(|term| term.changes()).count();
    if found > 0 {
        return Err(NoCorrection::Contacts { found });
    }
    // Contact in the root needs its unknowns named before anything is eliminated.
    let spots = touching.map_or_else(Vec::new, |t| spots(system, a, t));
    let mut root: Vec<usize> = spots.iter().flat_map(|s| s.row.iter().map(|r| r.0)).collect();
    root.sort_unstable();
    root.dedup();
    if root.len() > MOST_ROOT {
        return Err(NoCorrection::Near { found: root.len() });
    }
    let order = Dissection::by_places(&system.places(), &root).map_err(|_| NoCorrection::State)?;
    let mut ldl = Ldl::ordered_by(order);
    let mut pressed = Pressed::new(&root, spots, touching.map(|t| t.tube));
    let (start, mut a) = (a.to_vec(), a.to_vec());
    let (mut left, mut before, mut factors, mut part) = (f64::INFINITY, f64::INFINITY, 0, 1.0);
    for pass in 0..PASSES {
        // Factors serve until they no longer bring the state on.
        if pass == 0 || left > SLOW * before {
            factor(system, &a, &mut ldl)?;
            factors += 1;
        }
        let by = way(system, &a, &ldl, &mut pressed)?;
        part = step(system, &mut a, &by).ok_or(NoCorrection::State)?;
        // The tube stands; the points of the surface are where the step took them.
        pressed.moved(&a, &start);
        let all = largest(a.iter().zip(&start).map(|(a, s)| a - s));
        before = left;
        // Beside the whole way: the state that was taken over may be near already.
        left = largest(by.into_iter()) / all.max(f64::MIN_POSITIVE);
        if left <= LAST && part == 1.0 {
            break;
        }
    }
    // The force is that of the whole step: of a shortened one it is of no state.
    if left > MOST_LEFT || part < 1.0 {
        return Err(NoCorrection::Unsettled { left });
    }
    Ok(Correction {
        a,
        force: pressed.force(),
        left,
        factors,
    })
}

fn largest(each: impl Iterator<Item = f64>) -> f64 {
    each.fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// The way to balance with the tangent at hand.
fn way(system: &System, a: &[f64], ldl: &Ldl, pressed: &mut Pressed<'_>) -> Result<Vec<f64>, NoCorrection> {
    let mut forces = vec![0.0; a.len()];
    Potential::gradient(system, a, &mut forces).ok_or(NoCorrection::State)?;
    for (force, fixed) in forces.iter_mut().zip(&system.fixed) {
        *force = if *fixed { 0.0 } else { -*force };
    }
    let matrix = ldl.root().1;
    if matrix.is_empty() {
        ldl.solve(&mut forces);
        return Ok(forces);
    }
    let reduced = ldl.reduce(&forces);
    let y = pressed.find(matrix, &DVector::from_column_slice(reduced.on_root()));
    Ok(ldl.back(&reduced, y.ok_or(NoCorrection::Contact)?.as_slice()))
}

/// Moves `a`, by less where the whole move leads where there is no energy. The part.
fn step(system: &System, a: &mut [f64], by: &[f64]) -> Option<f64> {
    let mut part = 1.0;
    while part > 1e-3 {
        let next: Vec<f64> = a.iter().zip(by).map(|(a, by)| a + part * by).collect();
        if Potential::energy(system, &next).is_some() {
            a.copy_from_slice(&next);
            return Some(part);
        }
        part *= 0.5;
    }
    None
}

/// Factors the tangent without contact; a convex one where it has directions in which the energy falls: a field taken over from larger
/// cubes keeps volumes in their mean only, and its pressures on smaller ones are far off.
fn factor(system: &System, a: &[f64], ldl: &mut Ldl) -> Result<(), NoCorrection> {
    let mut matrix = Triplets::new(a.len());
    for convex in [false, true] {
        Potential::hessian(system, a, convex, &mut matrix).ok_or(NoCorrection::State)?;
        let diagonal = matrix.diagonal().into_iter().fold(0.0, f64::max);
        matrix.fix(&system.fixed, diagonal);
        ldl.take(&matrix);
        if ldl.definite(0.0).unwrap_or(false) {
            return Ok(());
        }
    }
    Err(NoCorrection::State)
}

/// Points near the tube, with the free unknowns that move them.
fn spots(system: &System, a: &[f64], touching: &Touching<'_>) -> Vec<Spot> {
    let (bodies, tube) = (&system.bodies, touching.tube);
    let (solid, part, offset) = (
        bodies.solid(touching.body),
        bodies.part(touching.body, a),
        bodies.offset(touching.body),
    );
    let spot = |point: usize| {
        let (at, normal, area) = solid.reference(point);
        let place = solid.point(part, point);
        let near = tube.signed_distance(&place).value < NEAR * tube.least_radius();
        (near && (touching.wanted)(&at, &normal)).then(|| {
            let mut row = Vec::new();
            solid.rows(part, point, &mut |p, by| {
                if by != Vector3::zeros() && !system.fixed[offset + p] {
                    row.push((offset + p, by));
                }
            });
            Spot::new(row, place, area)
        })
    };
    (0..solid.points()).filter_map(spot).collect()
}
