//! The report for people: what was found, how far it can be trusted, and what the points did.

use std::collections::BTreeMap;

use surface_registration::{Class, Refusal};

use super::Made;
use super::file::{class_name, shared_words};
use super::points::Shared;
use crate::register::file::RegistrationFile;
use crate::register::report::{accuracy, transform};
use crate::text::{line, mm, shown};

/// The report, without the gates of a scene, which may refuse what the numerics do not.
pub(super) fn text(made: &Made<'_>, file: &RegistrationFile, is_accepted: bool) -> String {
    let mut text = String::new();
    line!(
        text,
        "{} by the bone's surface: {} points of {} on {}, begun from {}",
        file.transform.name,
        made.found.points.len(),
        shown(&made.asked.points.to_string_lossy()),
        shown(&made.bone.path.to_string_lossy()),
        made.begun.word
    );
    bone(&mut text, made);
    line!(text);
    transform(&mut text, file);
    beside(&mut text, made);
    fit(&mut text, made, file);
    accuracy(&mut text, file);
    motions(&mut text, made, file);
    warnings(&mut text, made);
    line!(text);
    for refusal in made.against() {
        line!(text, "REFUSED          {refusal}");
    }
    for refusal in &made.refusals {
        if let Refusal::Quiet { found, .. } = refusal {
            line!(
                text,
                "                 if {found:.2} of it is what your points scatter, tell less (--contact-mm of calib sweep, --noise-mm, the columns of the file)"
            );
        }
    }
    if is_accepted {
        line!(
            text,
            "nothing speaks against it. Touch a point that you know and hold calib check against it"
        );
    }
    text
}

fn bone(text: &mut String, made: &Made<'_>) {
    let facts = made.bone.surface.facts();
    let size = [0, 1, 2].map(|k| facts.bounds_mm[1][k] - facts.bounds_mm[0][k]);
    // A sum of nothing is a zero below zero.
    let open = facts.open_ends.iter().fold(0.0, |sum, end| sum + end.length_mm);
    line!(
        text,
        "bone             {} triangles, {:.0} x {:.0} x {:.0} mm, {} open ends ({open:.0} mm), {} inner parts left out; +- {:.2} mm from place to place",
        facts.triangles,
        size[0],
        size[1],
        size[2],
        facts.open_ends.len(),
        facts.inner_parts,
        made.asked.options.priors.bone_mm
    );
}

/// The two numbers that were fitted with the pose.
fn beside(text: &mut String, made: &Made<'_>) {
    let sigma = |i: usize| made.found.covariance[(i, i)].max(0.0).sqrt();
    let priors = &made.asked.options.priors;
    let has_depth = made
        .measured
        .points
        .points()
        .iter()
        .any(|point| point.beam.and_then(|beam| beam.depth_mm).is_some());
    if has_depth && priors.depth_scale > 0.0 {
        line!(
            text,
            "speed of sound   depths are too long by {:.2} +- {:.2} % (told: 0 +- {:.1} %)",
            100.0 * made.found.depth_scale,
            100.0 * sigma(6),
            100.0 * priors.depth_scale
        );
    }
    if priors.offset_mm > 0.0 {
        line!(
            text,
            "bone's offset    the true bone lies {:+.2} +- {:.2} mm outside of the surface (told: 0 +- {:.1} mm)",
            made.found.offset_mm,
            sigma(7),
            priors.offset_mm
        );
    }
    line!(text);
}

fn fit(text: &mut String, made: &Made<'_>, file: &RegistrationFile) {
    let found = &made.found;
    line!(
        text,
        "residuals        {} mm rms, {:.2} of the noise that was told (1 where it is right, +- {:.2})",
        mm(file.fre_rms_mm),
        found.noise_ratio,
        found.noise_ratio_sigma
    );
    for (name, what, trend) in [
        ("order of points", "as if the bone had drifted by", found.drift),
        ("one side", "points on one side lie further outside by", found.side),
    ] {
        if let Some(trend) = trend {
            line!(
                text,
                "{name:<17}{what} {:.2} mm, {:.1} deviations of chance ({:.1} at most)",
                trend.mm,
                trend.deviations,
                made.asked.limits.most_trend
            );
        }
    }
    let mut classes: BTreeMap<&str, usize> = BTreeMap::new();
    for point in &found.points {
        *classes.entry(class_name(point.class)).or_default() += 1;
    }
    let kept = classes.remove(class_name(Class::Kept)).unwrap_or(0);
    let others: Vec<String> = classes
        .iter()
        .map(|(class, count)| format!("{count} {class}"))
        .collect();
    let others = if others.is_empty() {
        "none is left out".to_owned()
    } else {
        others.join(", ")
    };
    line!(text, "points           {kept} have a say; {others}");
    let other = match found.others.first() {
        Some(other) => format!(
            "the next pose that fits is {:.1} mm off and costs {:.1} more",
            other.apart_mm, other.margin
        ),
        None => "no other pose that fits was found".to_owned(),
    };
    line!(
        text,
        "search           {} poses tried, {} fitted, {} of them led here; {other}",
        found.seeds,
        found.fits,
        found.hits
    );
    if let Some(ratio) = found.landmark_ratio {
        line!(
            text,
            "landmarks        their squared misses are {ratio:.2} times what their errors say"
        );
    }
}

fn motions(text: &mut String, made: &Made<'_>, file: &RegistrationFile) {
    for motion in file.surface.iter().flat_map(|surface| &surface.free).take(2) {
        line!(text, "held least       {}", motion.motion);
    }
    line!(text, "shared error     {}", shared_words(&made.measured.shared));
}

/// What is not against the result, and should be known.
fn warnings(text: &mut String, made: &Made<'_>) {
    for warning in made.warnings() {
        line!(text, "WARNING          {}", shown(&warning));
    }
    if matches!(made.measured.shared, Shared::Unknown) {
        line!(
            text,
            "WARNING          nothing was told of the error that all points share, as that of the pointer's or probe's calibration: say --tip or --shared-mm"
        );
    }
    if made.asked.ct_hash.is_none() {
        line!(
            text,
            "WARNING          nothing says which CT this bone is of: a tracker takes the file only where its scene says unchecked_ct (else say --ct or --ct-hash, or keep calib bone's file beside the bone)"
        );
    }
}
