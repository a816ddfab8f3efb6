//! Where solids are at the start: deformed, then turned, then moved.

use nalgebra::{Matrix2, Vector2};
use simulation::solid::{Deformable, Global, Rigid, Solid};

use crate::scene::raw::RawSolid;
use crate::scene::{Checked, finite, invalid, pair};

/// The parameters of a mesh.
pub(super) fn mesh(k: usize, raw: &RawSolid, solid: &Deformable) -> Checked<Vec<f64>> {
    let (mut a, start) = (solid.initial(), &raw.start);
    let centre = centre(k, raw, solid)?;
    let key = |last: &str| format!("solids.{k}.start.{last}");
    let [x, y] = start.affine.unwrap_or([[1.0, 0.0], [0.0, 1.0]]);
    let rows = [pair(&key("affine.0"), x)?, pair(&key("affine.1"), y)?];
    let bent = start.bent.unwrap_or_default();
    for (i, coefficient) in bent.iter().flatten().enumerate() {
        finite(&key(&format!("bent.{}", i / 3)), *coefficient)?;
    }
    let less_identity = Matrix2::from_rows(&rows.map(|r| r.transpose())) - Matrix2::identity();
    for (u, reference) in a.chunks_exact_mut(2).zip(&solid.mesh().nodes) {
        let x = reference - centre;
        let by = less_identity * x;
        let second = |c: &[f64; 3]| c[0] * x.x * x.x + c[1] * x.x * x.y + c[2] * x.y * x.y;
        u[0] += by.x + second(&bent[0]);
        u[1] += by.y + second(&bent[1]);
    }
    rigidly(k, raw, solid, a)
}

/// The parameters of a polygon.
pub(super) fn polygon(k: usize, raw: &RawSolid, solid: &Rigid) -> Checked<Vec<f64>> {
    undeformed(k, raw)?;
    rigidly(k, raw, solid, solid.initial())
}

/// The parameters of a solid in a block.
pub(super) fn block(k: usize, raw: &RawSolid, solid: &Global) -> Checked<Vec<f64>> {
    undeformed(k, raw)?;
    rigidly(k, raw, solid, solid.initial())
}

fn undeformed(k: usize, raw: &RawSolid) -> Checked<()> {
    for (last, there) in [
        ("affine", raw.start.affine.is_some()),
        ("bent", raw.start.bent.is_some()),
    ] {
        if there {
            let found = format!("a deformation of solid {:?}, which is no mesh", raw.name);
            return Err(invalid(format!("solids.{k}.start.{last}"), found, "turned and moved"));
        }
    }
    Ok(())
}

fn rigidly(k: usize, raw: &RawSolid, solid: &dyn Solid, mut a: Vec<f64>) -> Checked<Vec<f64>> {
    let centre = centre(k, raw, solid)?;
    solid.rotate(
        &mut a,
        finite(&format!("solids.{k}.start.turned"), raw.start.turned)?,
        centre,
    );
    solid.translate(&mut a, pair(&format!("solids.{k}.start.moved"), raw.start.moved)?);
    Ok(a)
}

/// What it turns about: as told, or the middle of the box round it.
fn centre(k: usize, raw: &RawSolid, solid: &dyn Solid) -> Checked<Vector2<f64>> {
    if let Some(about) = raw.start.about {
        return pair(&format!("solids.{k}.start.about"), about);
    }
    let points = || solid.boundary().reference.iter().flatten();
    let low = points().fold(Vector2::repeat(f64::INFINITY), |m, p| m.inf(p));
    let high = points().fold(Vector2::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
    Ok((low + high) * 0.5)
}
