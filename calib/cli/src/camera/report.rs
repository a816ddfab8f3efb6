//! The report for people: the camera, how far it can be trusted, and the discs furthest off.

use optics::camera::{Calibrated, NAMES, PARAMETERS, WIDEST};

use super::file::CameraFile;
use super::read::Seen;
use crate::text::line;

/// How many of the discs furthest off are listed.
const WORST: usize = 10;

/// The report.
pub(super) fn text(found: &Calibrated, seen: &Seen, file: &CameraFile) -> String {
    let mut text = String::new();
    heading(&mut text, found, seen, file);
    numbers(&mut text, found, file);
    views(&mut text, found, seen);
    worst(&mut text, found, seen);
    text
}

fn heading(text: &mut String, found: &Calibrated, seen: &Seen, file: &CameraFile) {
    let [used, out] = found.counts();
    let [width, height] = file.image_px;
    line!(
        text,
        "camera of {width} x {height} pixels from {} views, {used} discs, {out} left out",
        seen.images.len()
    );
    if !seen.missing.is_empty() {
        line!(
            text,
            "without the images in which no grid was found: {}",
            seen.missing.join(", ")
        );
    }
    line!(
        text,
        "residuals {:.3} px RMS; {:.2} times the deviations given{}",
        found.rms_px,
        found.noise_ratio,
        if found.noise_ratio > 1.0 {
            ", by which those below have grown"
        } else {
            ""
        }
    );
    line!(
        text,
        "what the views say of focal lengths and principal point differs by {:.2} times its stated deviations",
        found.view_ratio
    );
    let [x, y] = file.tilt_deg;
    line!(
        text,
        "tilts differ by {x:.1} deg about the image's x axis and {y:.1} about y; discs in {:.0} % of the image",
        100.0 * file.image_covered
    );
}

fn numbers(text: &mut String, found: &Calibrated, file: &CameraFile) {
    let sigmas = found.sigmas();
    line!(text);
    for k in 0..PARAMETERS {
        let unit = if k < 5 { "px" } else { "" };
        if file.free.iter().any(|name| name == NAMES[k]) {
            line!(
                text,
                "  {:<5} {:>12.5} +- {:<9.2e} {unit}",
                NAMES[k],
                file.numbers[k],
                sigmas[k]
            );
        } else {
            line!(text, "  {:<5} {:>12.5}    held      {unit}", NAMES[k], file.numbers[k]);
        }
    }
    plate(text, found);
    let limit = file.domain_tangent;
    let end = limit.atan().to_degrees();
    let whole = if limit < WIDEST { "" } else { " or more" };
    line!(
        text,
        "  the lens' model is one to one up to {end:.1} deg off the axis{whole}"
    );
}

/// How far the grid is from flat.
fn plate(text: &mut String, found: &Calibrated) {
    let Some(plate) = &found.plate else { return };
    let (numbers, (middle, half)) = (plate.numbers_mm(), plate.ruler_mm());
    for (k, name) in ["u^2", "u w", "w^2"].into_iter().enumerate() {
        let sigma = plate.covariance[(k, k)].max(0.0).sqrt();
        line!(text, "  bend {name} {:>11.4} +- {sigma:<9.2e} mm", numbers[k]);
    }
    line!(
        text,
        "  (u, w): places from ({:.1}, {:.1}) mm of the grid, in units of {half:.1} mm",
        middle.x,
        middle.y
    );
    let Some(field) = &plate.field else { return };
    let [height, flat] = field.rms_mm;
    line!(
        text,
        "  the discs lie off that by a smooth field, {height:.3} mm RMS in height and {flat:.3} mm RMS along each axis of \
         the plane; the views fix {:.0} of its numbers",
        field.fixed
    );
}

/// How well the camera of all other views predicts each.
pub(super) fn held_out(all: &[f64], seen: &Seen) -> String {
    let mut text = String::from("\n  view                           predicted by the camera of the others, RMS px\n");
    for (rms, image) in all.iter().zip(&seen.images) {
        let name: String = image.name.chars().take(28).collect();
        line!(text, "  {name:<28} {rms:>10.3}");
    }
    let mean = (all.iter().map(|r| r * r).sum::<f64>() / all.len().max(1) as f64).sqrt();
    line!(text, "  {:<28} {mean:>10.3}", "all views, RMS");
    text
}

fn views(text: &mut String, found: &Calibrated, seen: &Seen) {
    line!(text);
    line!(
        text,
        "  {:<28} {:>6} {:>8} {:>8} {:>9} {:>12}",
        "view",
        "discs",
        "left out",
        "RMS px",
        "tilt deg",
        "distance mm"
    );
    for (view, image) in found.views.iter().zip(&seen.images) {
        let used = view.residuals.iter().filter(|r| r.used).count();
        let out = view.residuals.len() - used;
        let [_, _, z] = view.pose.translation_mm();
        let name: String = image.name.chars().take(28).collect();
        line!(
            text,
            "  {name:<28} {used:>6} {out:>8} {:>8.3} {:>9.1} {z:>12.1}",
            view.rms_px,
            view.tilt_rad.to_degrees()
        );
    }
}

fn worst(text: &mut String, found: &Calibrated, seen: &Seen) {
    let each = found.views.iter().zip(&seen.images).flat_map(|(view, image)| {
        let both = view.residuals.iter().zip(&image.cells);
        both.map(move |(residual, cell)| (image, residual, cell))
    });
    let mut all: Vec<_> = each.collect();
    all.sort_by(|a, b| b.1.off.norm().total_cmp(&a.1.off.norm()));
    line!(text);
    line!(text, "  the discs furthest off        col row     dx px     dy px");
    for (image, residual, [col, row]) in all.into_iter().take(WORST) {
        let name: String = image.name.chars().take(28).collect();
        let out = if residual.used { "" } else { "  left out" };
        line!(
            text,
            "  {name:<28} {col:>4} {row:>3} {:>9.3} {:>9.3}{out}",
            residual.off.x,
            residual.off.y
        );
    }
}
