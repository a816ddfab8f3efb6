//! What the forces that a search leaves over may move: the algebraic error, to first order.

use nalgebra::Vector3;

use crate::control::Potential;
use crate::space::system::System;
use crate::sparse::{Dissection, Ldl, Triplets};

/// What moves a place: the first of three unknowns of a node, and its weight.
pub type Row = Vec<(usize, f64)>;

/// What is left over, through the tangent of the state found, contacts included as they press.
#[derive(Debug, Clone, PartialEq)]
pub struct Residual {
    /// The largest free force.
    pub force: f64,
    /// Of each place and axis `sum of |z_i r_i|`, `z` being what a unit force there moves: no signs of the free forces `r` move it farther, to first
    /// order.
    pub bounds: Vec<Vector3<f64>>,
    /// What the forces move all unknowns: Newton's step.
    pub step: Vec<f64>,
}

/// Why nothing is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoResidual {
    /// The state has no energy.
    #[error("the state has no energy")]
    State,
    /// The tangent is not definite, so that a small force might move much.
    #[error("the state's tangent is not definite")]
    Tangent,
}

/// What the free forces of a state move at some places.
///
/// # Errors
/// [`NoResidual`].
pub fn residual(system: &System, a: &[f64], places: &[Row]) -> Result<Residual, NoResidual> {
    let mut forces = vec![0.0; a.len()];
    Potential::gradient(system, a, &mut forces).ok_or(NoResidual::State)?;
    for (force, fixed) in forces.iter_mut().zip(&system.fixed) {
        *force = if *fixed { 0.0 } else { -*force };
    }
    let order = Dissection::by_places(&system.places(), &[]).map_err(|_| NoResidual::State)?;
    let mut matrix = Triplets::new(a.len());
    Potential::hessian(system, a, false, &mut matrix).ok_or(NoResidual::State)?;
    // Held unknowns get a pivot in the scale of the others, so that none of them looks singular.
    let diagonal = matrix.diagonal().into_iter().fold(0.0, f64::max);
    matrix.fix(&system.fixed, diagonal);
    let mut ldl = Ldl::ordered_by(order);
    ldl.take(&matrix);
    // Of a saddle the inverse says nothing about how far the forces carry.
    if !ldl.definite(0.0).unwrap_or(false) {
        return Err(NoResidual::Tangent);
    }
    // One solution for each place and axis, not one for each force: the matrix is symmetric. Signs of the forces may fall together, so magnitudes are
    // summed.
    let bound = |row: &Row, axis: usize| {
        let mut z = vec![0.0; a.len()];
        row.iter().for_each(|(first, weight)| z[first + axis] += weight);
        ldl.solve(&mut z);
        z.iter().zip(&forces).map(|(z, r)| (z * r).abs()).sum::<f64>()
    };
    let bounds = places.iter().map(|row| Vector3::from_fn(|axis, _| bound(row, axis)));
    let bounds = bounds.collect();
    let mut step = forces.clone();
    ldl.solve(&mut step);
    Ok(Residual {
        force: forces.iter().fold(0.0, |most, f| most.max(f.abs())),
        bounds,
        step,
    })
}
