//! Residuals of each pair under the transform of all others.

use geometry::Frame;

use super::{Method, Pairs, Refused, fit};

/// The distance of each pair after registration by the others, mm; `None` where they do not determine a transform.
///
/// Each is a registration of its own, not a downdate of the moments, which would cancel where one pair outweighs the
/// rest.
pub(super) fn residuals<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    method: Method,
) -> Result<Vec<Option<f64>>, Refused> {
    let mut weights: Vec<f64> = (0..pairs.len()).map(|i| pairs.weight(i)).collect();
    let mut residuals = Vec::with_capacity(weights.len());
    for i in 0..weights.len() {
        let kept = std::mem::replace(&mut weights[i], 0.0);
        let others = Pairs::new(pairs.to, pairs.from)?.weighted(&weights)?;
        // Of three pairs two are left, of four perhaps three on a line: no error of the registration of all.
        let fit = fit(others, method).ok();
        residuals.push(fit.map(|fit| fit.residual_mm(pairs.to[i], pairs.from[i])));
        weights[i] = kept;
    }
    Ok(residuals)
}
