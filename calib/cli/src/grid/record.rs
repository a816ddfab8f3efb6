//! What `calib grid` writes.

use std::path::Path;

use optics::grid::{Found, GridDisc, GridRefused, GridSpec, Refinement};
use optics::image::Image;
use serde_json::{Value, json};

/// The file as a whole.
pub(crate) fn file(spec: &GridSpec, images: &[Value]) -> Value {
    json!({
        "trocar_grid": 1,
        "program": concat!("calib ", env!("CARGO_PKG_VERSION")),
        "units": "pixels, centres of pixels at whole coordinates, x to the right, y down",
        "cols": spec.cols,
        "rows": spec.rows,
        "pitch_mm": spec.pitch_mm,
        "marks": spec.marks,
        "images": images,
    })
}

fn disc(disc: &GridDisc, pitch_mm: f64) -> Value {
    let c = disc.covariance;
    let mut value = json!({
        "col": disc.col,
        "row": disc.row,
        "x_mm": disc.col as f64 * pitch_mm,
        "y_mm": disc.row as f64 * pitch_mm,
        "x_px": disc.at.x,
        "y_px": disc.at.y,
        "covariance_px2": [c[(0, 0)], c[(0, 1)], c[(1, 1)]],
        "mark": disc.mark,
    });
    if let Some(own) = &disc.measured {
        let axes = own.ellipse.axes();
        value["measured"] = json!({
            "x_px": own.ellipse.centre.x,
            "y_px": own.ellipse.centre.y,
            "semi_axes_px": axes.semi,
            "long_axis_deg": axes.long.y.atan2(axes.long.x).to_degrees(),
            "radius_mm": own.radius * pitch_mm,
        });
    }
    value
}

/// The model that was taken: a plane, a lens, or none but each disc's own.
fn model(refinement: Refinement) -> &'static str {
    match refinement {
        Refinement::Whole => "whole",
        Refinement::Lens => "lens",
        Refinement::Each => "each",
    }
}

/// One image with its grid.
pub(crate) fn found(path: &Path, image: &Image, spec: &GridSpec, found: &Found) -> Value {
    let h = found.homography;
    let rows: Vec<[f64; 3]> = (0..3).map(|i| [h[(i, 0)], h[(i, 1)], h[(i, 2)]]).collect();
    let discs: Vec<Value> = found.discs.iter().map(|d| disc(d, spec.pitch_mm)).collect();
    json!({
        "path": path.to_string_lossy(),
        "width": image.width(),
        "height": image.height(),
        "found": true,
        "refinement": model(found.refinement),
        "px_from_col_row": rows,
        "radius_pitch": found.radius,
        "blur_px": found.sigma,
        "noise": found.noise,
        "homography_rms_px": found.homography_rms_px,
        "misfit_px": found.misfit_px,
        "candidates": found.candidates,
        "turns_alike": found.alike,
        "missing": found.missing,
        "discs": discs,
    })
}

/// One image without.
pub(crate) fn refused(path: &Path, image: &Image, refused: &GridRefused, why: &str) -> Value {
    json!({
        "path": path.to_string_lossy(),
        "width": image.width(),
        "height": image.height(),
        "found": false,
        "refused": why,
        "discs_in_lattice": refused.evidence(),
    })
}
