//! Whether a bent plate is why there is no camera.

use nalgebra::Vector3;

use super::error::CameraRefused;
use super::once;
use super::view::{ImageSize, Options, View};

/// The bend is there where its three numbers lie so many deviations from 0.
const MIN_BEND_DEVIATIONS: f64 = 6.0;

/// The refusal, or [`CameraRefused::NotFlat`] where the same views give a camera with a plate that is bent for certain.
pub(super) fn told(refused: CameraRefused, views: &[View], size: ImageSize, options: &Options) -> CameraRefused {
    use CameraRefused::{Folded, NoConvergence, Outliers, Weak};
    // Other refusals say what is wrong by themselves.
    let may_be = matches!(
        refused,
        NoConvergence { .. } | Folded { .. } | Outliers { .. } | Weak { .. }
    );
    if !may_be || options.bent || options.field {
        return refused;
    }
    let bent = Options { bent: true, ..*options };
    let Ok(found) = once(views, size, &bent) else {
        return refused;
    };
    // A bend of three free numbers fits noise as well: it must be there beyond doubt.
    let certain = found.plate.filter(|plate| {
        let bend = Vector3::from(plate.numbers_mm());
        let information = plate.covariance.try_inverse();
        information.is_some_and(|i| bend.dot(&(i * bend)) > MIN_BEND_DEVIATIONS * MIN_BEND_DEVIATIONS)
    });
    let Some(plate) = certain else { return refused };
    let heights = views
        .iter()
        .flat_map(|v| &v.sightings)
        .map(|s| plate.height_mm(s.at_mm));
    CameraRefused::NotFlat {
        sag_mm: heights.fold(0.0, |most, h| most.max(h.abs())),
        rms_px: found.rms_px,
        flat: Box::new(refused),
    }
}
