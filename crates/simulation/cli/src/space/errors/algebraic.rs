//! What the search left over: free forces through the tangent, and the state that is found when it goes on.

use simulation::space::error::residual;

use super::{At, Base};

/// The search goes on to this part of its tolerances.
const TIGHT: f64 = 1e-2;

/// The algebraic error.
#[derive(Debug)]
pub(in super::super) struct Algebraic {
    /// The largest free force, N.
    pub(in super::super) residual: f64,
    /// Of each target: no more than this is it moved by the free forces, to first order, mm.
    pub(in super::super) bounds: Vec<f64>,
    /// What going on to [`TIGHT`] of all tolerances changed, pressures of the contact too.
    pub(in super::super) further: Result<At, String>,
}

pub(super) fn of(base: &Base<'_>) -> Result<Algebraic, String> {
    let (system, a) = (&base.model.system, &base.state.a);
    let rows: Vec<_> = base.model.targets.iter().map(|t| t.unknowns(&system.bodies)).collect();
    let left = residual(system, a, &rows).map_err(|why| why.to_string())?;
    let further = || {
        let mut model = base
            .model
            .changed(base.plan, base.labels)
            .map_err(|why| why.to_string())?;
        base.settled(&mut model, &mut a.clone(), TIGHT)
    };
    Ok(Algebraic {
        residual: left.force,
        bounds: left.bounds.iter().map(|b| b.norm()).collect(),
        further: further(),
    })
}
