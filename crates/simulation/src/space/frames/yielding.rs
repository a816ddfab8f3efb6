//! How a state gives way to small forces with the tube where it is: by the implicit function theorem what a parameter of the model does to it.
//!
//! In a settled state forces balance, `F(a, p) = 0`, and points that press keep no distance. With a parameter `p` the state changes by `da/dp = -K^-1 dF/dp`, where `K` are
//! the second derivatives with contact: points that press go on pressing, and stay at what they press. `K` is not factored: the factor in use, a little
//! old, and the compliance of the points at the tube solve for it, and what that leaves by the present second derivatives, along the change itself by a difference of two
//! gradients, is solved for again until it is small.

use nalgebra::Vector3;

use super::stiffness::{Driven, Held};
use super::{Evaluated, Frames};

/// The last pass moves no point of the tissue by more than this part of what all passes did. A pass leaves what the factor is off by, a part of the pass
/// before: of passes that fall by a half or faster what is left is no more than this part.
const ENOUGH: f64 = 0.01;
/// Passes at most: more say that the factor is not that of this state.
const MOST_PASSES: usize = 16;
/// The way by which gradients are taken apart, mm: far above their rounding, far below what bends a cube.
const APART: f64 = 1e-4;

/// A settled state that can give way.
#[derive(Debug)]
pub struct Yielding<'a> {
    frames: &'a Frames,
    /// `None` where nothing presses.
    held: Option<Held>,
}

impl Frames {
    /// The state as it gives way to small forces. `None` where nobody knows how: outside [`super::State::Settled`], where the factor is of a convex
    /// matrix in the place of second derivatives that are not positive definite, or where points that press are not among those that it serves.
    pub fn yielding(&self) -> Option<Yielding<'_>> {
        if !self.now.settled || self.factors.now.convex {
            return None;
        }
        let near = &self.factors.now.near;
        let pressing = self.pressing(near)?;
        let held = match pressing.is_empty() {
            true => None,
            false => Some(Held::new(pressing, near)?),
        };
        Some(Yielding { frames: self, held })
    }
}

impl Yielding<'_> {
    /// The change of all unknowns, mm, under small forces on them, N, to first order: those on unknowns that are held do nothing. `None` where passes
    /// do not settle: then it is not known, and not small.
    pub fn to(&self, forces: &[f64]) -> Option<Vec<f64>> {
        let system = &self.frames.system;
        let held = forces.iter().zip(&system.fixed);
        let forces: Vec<f64> = held.map(|(force, fixed)| if *fixed { 0.0 } else { *force }).collect();
        let a = &self.frames.now.a;
        let (mut change, mut more) = (vec![0.0; a.len()], vec![0.0; self.pressing()]);
        let mut left = forces.clone();
        for _ in 0..MOST_PASSES {
            let (step, pressures) = self.pass(&left, &change)?;
            add(&mut change, &step);
            add(&mut more, &pressures);
            let [by, all] = [&step, &change].map(|way| self.moves(way));
            // No number is no answer: passes that grow would else end by chance.
            if !all.is_finite() {
                return None;
            }
            // By the tissue alone: nodes outside it, which hardly any material holds, settle last and show nowhere.
            if by <= ENOUGH * all {
                return Some(change);
            }
            left = self.left(&forces, &change, &more)?;
        }
        None
    }

    fn pressing(&self) -> usize {
        self.held.as_ref().map_or(0, |held| held.pressing.len())
    }

    /// How far a change moves a point of the tissue at most, along an axis, mm.
    fn moves(&self, change: &[f64]) -> f64 {
        let now = &self.frames.now;
        let there: Vec<f64> = now.a.iter().zip(change).map(|(a, by)| a + by).collect();
        self.frames.others.apart(&self.frames.system, &now.a, &there)
    }

    /// The ways of the points that press.
    fn ways(&self, held: &Held, change: &[f64]) -> Vec<Vector3<f64>> {
        let touches = &self.frames.contact.touches;
        // Places are linear in the unknowns: what takes a state takes a change, too.
        let mut own = Vec::new();
        touches.take(change, &mut own);
        let each = held.pressing.iter();
        each.map(|p| touches.displacement(self.point(p.point), &own)).collect()
    }

    fn point(&self, near: usize) -> usize {
        self.frames.factors.now.near.points()[near]
    }

    /// What the factor in use makes of forces that are left, and by how much pressures change; points come back to what they press from where
    /// the change so far has them.
    fn pass(&self, left: &[f64], change: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let ldl = &self.frames.factors.now.ldl;
        let mut free = left.to_vec();
        ldl.solve(&mut free);
        let Some(held) = &self.held else {
            return Some((free, Vec::new()));
        };
        let (free_ways, ways) = (self.ways(held, &free), self.ways(held, change));
        let length = free_ways.iter().chain(&ways).map(Vector3::norm).fold(0.0, f64::max);
        let off = held.pressing.iter().zip(&ways);
        let driven = Driven {
            forces: vec![Vector3::zeros(); held.pressing.len()],
            kept: off.map(|(p, way)| -p.distance.gradient.dot(way)).collect(),
            free: free_ways,
            length,
        };
        // The compliance is of the same factor: forces and ways of the points agree with the step to rounding.
        let found = held.response(&driven)?;
        let mut step = vec![0.0; left.len()];
        self.push(held, &found.forces, &mut step);
        ldl.solve(&mut step);
        add(&mut step, &free);
        Some((step, found.more))
    }

    /// Adds forces on the points that press to those on all unknowns.
    fn push(&self, held: &Held, each: &[Vector3<f64>], forces: &mut [f64]) {
        let touches = &self.frames.contact.touches;
        let mut own = vec![0.0; touches.unknowns()];
        for (p, force) in held.pressing.iter().zip(each) {
            touches.push(self.point(p.point), force, &mut own);
        }
        touches.add(&own, forces);
    }

    /// The forces that a change of state and pressures leaves, by the second derivatives of this state. `None` where it has none along the change.
    fn left(&self, forces: &[f64], change: &[f64], more: &[f64]) -> Option<Vec<f64>> {
        let (now, system) = (&self.frames.now, &self.frames.system);
        // By a small part of the change, not by an unknown each: one gradient for all of them.
        let part = APART / change.iter().fold(APART, |most, by| most.max(by.abs()));
        let there: Vec<f64> = now.a.iter().zip(change).map(|(a, by)| a + part * by).collect();
        let there = Evaluated::of(system, &there)?;
        let each = forces.iter().zip(there.forces.iter().zip(&now.at.forces));
        let mut left: Vec<f64> = each
            .map(|(force, (there, here))| force + (there - here) / part)
            .collect();
        if let Some(held) = &self.held {
            let ways = self.ways(held, change);
            let each = held.pressing.iter().zip(ways).zip(more);
            // The normal turns as the point goes along the tube.
            let pushed = each
                .map(|((p, way), more)| (p.distance.gradient * *more + p.distance.hessian * way * p.pressure) * p.area);
            let pushed: Vec<Vector3<f64>> = pushed.collect();
            self.push(held, &pushed, &mut left);
        }
        let held = left.iter_mut().zip(&system.fixed);
        held.filter(|(_, fixed)| **fixed).for_each(|(left, _)| *left = 0.0);
        Some(left)
    }
}

fn add(to: &mut [f64], by: &[f64]) {
    to.iter_mut().zip(by).for_each(|(to, by)| *to += by);
}
