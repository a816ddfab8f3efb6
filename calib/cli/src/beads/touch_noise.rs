//! What the file of touches states of their errors, and what `calib match` says of that and of the pairing.

use std::fmt::Write;

use bead::matching::{Errors, Matched, Stated};
use geometry::Tracker;
use nalgebra::Matrix3;

use crate::input_files::points_text;
use crate::register::file::TouchNoise;

/// What a touch says of its error.
pub(super) fn stated(touch: &points_text::Point) -> Option<Stated> {
    let error = touch.error?;
    Some(Stated {
        own: error.own(),
        shared: error.shared.unwrap_or_default(),
    })
}

/// What the errors of the pairs are made of, where the touches state theirs.
pub(super) fn noise_of(
    matched: &Matched<Tracker>,
    touched: &[points_text::Point],
    errors: &Errors,
) -> Option<TouchNoise> {
    let paired = || matched.bead_of.iter().zip(touched).filter(|(bead, _)| bead.is_some());
    let rms = |part: &dyn Fn(&Stated) -> Matrix3<f64>| {
        let traces: Vec<f64> = paired()
            .filter_map(|(_, touch)| Some(part(&stated(touch)?).trace()))
            .collect();
        (traces.iter().sum::<f64>().max(0.0) / (3.0 * traces.len() as f64)).sqrt()
    };
    let error = paired().find_map(|(_, touch)| touch.error)?;
    Some(TouchNoise {
        own_mm: rms(&|stated| stated.own),
        shared_mm: error
            .shared
            .map(|_| rms(&|stated| stated.shared * stated.shared.transpose())),
        hand_mm: errors.touch_mm,
        bead_mm: errors.bead_mm,
    })
}

/// What the error of a touch is made of, in words.
pub(super) fn noise_text(noise: Option<TouchNoise>, touch_mm: f64) -> String {
    let Some(noise) = noise else {
        return format!(
            "\ntouches          {touch_mm} mm per axis (--touch-mm) for all of their error: the file states no covariances\n"
        );
    };
    let shared = match noise.shared_mm {
        Some(mm) => format!("{mm:.3} mm of the tip's calibration, which all touches share"),
        None => {
            "the tip's calibration is not told apart, and counts as if each touch had its own: touch anew".to_owned()
        }
    };
    format!(
        "\ntouches          per axis {:.3} mm of each by the file, {shared}; {} mm of the hand (--touch-mm)\n",
        noise.own_mm, noise.hand_mm
    )
}

/// Who is who, in words.
pub(super) fn pairing_text(matched: &Matched<Tracker>, touched: &[points_text::Point]) -> String {
    let mut text = String::new();
    let [found, most] = matched.chi_squared;
    // Writing to a string does not fail.
    let _ = writeln!(
        text,
        "pairing          the only one that fits: squared residuals over the errors are {found:.1} at the least, up to {most:.1} is accepted"
    );
    for at in matched.without_bead() {
        let point = &touched[at];
        let [x, y, z] = point.mm;
        let _ = writeln!(
            text,
            "no bead          line {}: the touched point {x}, {y}, {z} is on no bead",
            point.line
        );
    }
    if !matched.untouched.is_empty() {
        let numbers: Vec<String> = matched.untouched.iter().map(|bead| (bead + 1).to_string()).collect();
        let _ = writeln!(text, "not touched      beads {}", numbers.join(", "));
    }
    text
}
