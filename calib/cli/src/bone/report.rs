//! What a person is told.

use std::fmt::Write;
use std::path::Path;

use bone::{Bone, Component, Refused};

use super::BoneFile;
use super::file::LeftOutRecord;
use super::in_words;
use crate::beads::{Volume, warned};
use crate::text::shown;

/// The bodies that could be meant, where it was not said which.
pub(super) fn listed(refused: &Refused) -> String {
    let Refused::Which { count, largest } = refused else {
        return String::new();
    };
    let more = count.saturating_sub(largest.len());
    let more = if more > 0 {
        format!("\n  and {more} more")
    } else {
        String::new()
    };
    table(largest) + &more
}

fn table(bodies: &[Component]) -> String {
    let mut text = "\n  number   volume     mean   centre, mm (left, posterior, superior)".to_owned();
    for (i, body) in bodies.iter().enumerate() {
        let [x, y, z] = body.centre_mm;
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n  {:>6} {:>5.0} ml {:>5.0} HU   {x:.0}, {y:.0}, {z:.0}; {}",
            i + 1,
            body.volume_ml,
            body.mean_hu,
            in_words(body.place)
        );
    }
    text
}

pub(super) fn report(path: &Path, volume: &Volume, bone: &Bone, file: &BoneFile) -> String {
    let [nx, ny, nz] = volume.0.grid.dims();
    let [a, b, c] = volume.0.grid.spacing_mm();
    let mut text = format!(
        "{}: {nx} x {ny} x {nz} voxels of {a:.3} x {b:.3} x {c:.3} mm\nCT {}\n{}{}\n",
        shown(&path.to_string_lossy()),
        file.ct_hash,
        warned(&file.warnings),
        file.region
    );
    let _ = writeln!(
        text,
        "above {} HU: {:.1} ml of {:.0} HU in the mean, {}",
        file.threshold_hu,
        file.body_ml,
        file.body_mean_hu,
        in_words(bone.body.place)
    );
    if !file.kept_out.is_empty() {
        let _ = writeln!(text, "kept out: {}", file.kept_out.join(", "));
    }
    scanner(&mut text, file);
    let _ = writeln!(
        text,
        "surface: {} triangles on {} corners, {:.0} mm^2",
        file.triangles, file.corners, file.area_mm2
    );
    let _ = writeln!(
        text,
        "deviation along the normal: {:.2} mm in the middle, 95 % of the corners below {:.2} mm; of it {:.2} mm that all share",
        file.median_deviation_mm, file.deviation_95_mm, file.surface_shared_sigma_mm
    );
    open(&mut text, file);
    text
}

fn scanner(text: &mut String, file: &BoneFile) {
    let s = &file.scanner;
    let [plane, across] = s.blur_mm;
    let how = match (s.is_blur_told, s.places) {
        (_, 0) => "expected of such voxels; too few places told of it".to_owned(),
        (true, places) => format!("told, and from {places} places"),
        (false, places) => format!("found at {places} places"),
    };
    let _ = writeln!(
        text,
        "blur {plane:.2} mm in the slices' plane and {across:.2} mm across it, +- {:.0} and {:.0} % ({how}); cortex {:.0} +- {:.0} HU; noise {:.0} HU",
        100.0 * s.blur_relative_sigma[0],
        100.0 * s.blur_relative_sigma[1],
        s.cortex_hu[0],
        s.cortex_hu[1],
        s.noise_hu
    );
}

fn open(text: &mut String, file: &BoneFile) {
    let lost: usize = file.lost.iter().map(|lost| lost.corners).sum();
    if lost > 0 {
        let _ = writeln!(
            text,
            "open: {lost} of {} corners of the threshold's surface have no position of their own:",
            file.threshold_corners
        );
    }
    for lost in &file.lost {
        let _ = writeln!(text, "{:>8}  {}", lost.corners, lost.reason);
    }
    if file.metal_voxels > 0 {
        let _ = writeln!(
            text,
            "metal: {} voxels of {} HU and more about it",
            file.metal_voxels, file.metal_hu
        );
    }
    no_cortex(text, file);
}

/// Pieces that are told one by one: at most so many, of so many mm^2.
const TOLD: (usize, f64) = (8, 20.0);

fn no_cortex(text: &mut String, file: &BoneFile) {
    let whole = |pieces: &[LeftOutRecord]| {
        pieces
            .iter()
            .fold((0, 0.0), |(n, a), p| (n + p.triangles, a + p.area_mm2))
    };
    let count = file
        .left_out
        .iter()
        .take(TOLD.0)
        .take_while(|p| p.area_mm2 >= TOLD.1)
        .count();
    let (told, rest) = file.left_out.split_at(count);
    if !file.left_out.is_empty() {
        let (triangles, area) = whole(&file.left_out);
        let _ = writeln!(
            text,
            "left out, no cortex (contrast medium explains it): {triangles} triangles, {area:.0} mm^2"
        );
    }
    for piece in told {
        let [x, y, z] = piece.centre_mm;
        let _ = writeln!(
            text,
            "{:>8.0} mm^2 of {} triangles about {x:.0}, {y:.0}, {z:.0} mm, {:.0} HU inside",
            piece.area_mm2, piece.triangles, piece.hu
        );
    }
    if !told.is_empty() && !rest.is_empty() {
        let (triangles, area) = whole(rest);
        let _ = writeln!(
            text,
            "{area:>8.0} mm^2 of {triangles} triangles in {} smaller pieces",
            rest.len()
        );
    }
    if file.unseen_corners > 0 {
        let _ = writeln!(
            text,
            "cortex not seen: {} corners, {} triangles, {:.0} mm^2; they are marked, and nothing registers to them (purple on the picture)",
            file.unseen_corners, file.unseen_triangles, file.unseen_area_mm2
        );
    }
    if file.without_cortex > 0.2 {
        let _ = writeln!(
            text,
            "no cortex seen on {:.0} % of what was fitted: look whether it is bone",
            100.0 * file.without_cortex
        );
    }
}
