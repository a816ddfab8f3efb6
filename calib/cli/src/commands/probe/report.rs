//! What was found, in words.

use probe::{Checked, CrossValidated, ProbeCalibration};

use super::file::ProbeFile;
use super::input::Read;
use super::phantom::Told;

pub(super) fn text(
    found: &ProbeCalibration,
    crossed: Option<&[CrossValidated; 2]>,
    phantom: Option<&Told>,
    read: &Read,
) -> String {
    let image = found.probe_from_image.transform();
    let ([w, x, y, z], [a, b, c]) = (image.quaternion(), image.translation_mm());
    let [u, v] = found.pixel_mm;
    let mut text = format!(
        "{} of {} frames with points, {} points, {:.1} % kept\n",
        found.frames,
        read.of,
        found.points.len(),
        100.0 * found.share_kept
    );
    if read.lost > 0 {
        text.push_str(&format!(
            "  {} frames with points have no valid pose and were left out\n",
            read.lost
        ));
    }
    text.push_str(&format!(
        "probe_from_image quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm\n\
         pixels           {u:.6} x {v:.6} mm, +- {:.2} and {:.2} %\n\
         distances        mean {:.3}, root mean square {:.3} mm; {:.2} times the noise told\n",
        100.0 * found.covariance[(6, 6)].max(0.0).sqrt(),
        100.0 * found.covariance[(7, 7)].max(0.0).sqrt(),
        found.mean_mm,
        found.rms_mm,
        found.noise_ratio
    ));
    if found.frame_correlation > 1.5 {
        text.push_str(&format!(
            "frames           neighbours vary together {:.1} times as much as independent ones: something slow is not in the model\n",
            found.frame_correlation
        ));
    }
    text.push_str(&unknowns(found, phantom));
    if let Some([every, halves]) = crossed {
        let [a, b] = every.mean_mm;
        let [c, d] = halves.mean_mm;
        text.push_str(&format!(
            "not taken part   mean distance, mm: every second frame by the others {a:.3}, {b:.3}; one half by the other {c:.3}, {d:.3}\n"
        ));
    }
    text.push_str(&format!(
        "error            {:.3} mm at the worst corner of the points, root mean square\n",
        found.worst_mm()
    ));
    for free in found.free().iter().take(3) {
        text.push_str(&format!("held least       {free}\n"));
    }
    text
}

/// A check.
pub(super) fn checked(found: &Checked, file: &ProbeFile) -> String {
    format!(
        "calibration      {}, which tells {:.3} mm of itself\n\
         distances        {} points: mean {:.3}, root mean square {:.3}, largest {:.3} mm\n\
         of one wire      its points lie {:.3} mm off on average, at most: what noise does not explain\n\
         promise          distances are {:.2} times what noise, poses, phantom and calibration say of them together\n",
        file.id,
        file.error_mm,
        found.distances_mm.len(),
        found.mean_mm,
        found.rms_mm,
        found.most_mm,
        found.bias_mm,
        found.ratio
    )
}

/// What else was found.
fn unknowns(found: &ProbeCalibration, phantom: Option<&Told>) -> String {
    let mut text = String::new();
    if let Some(lag) = found.lag {
        text.push_str(&format!(
            "lag              {:.1} +- {:.1} ms: an image's pose is that of its own time and this\n",
            1e3 * lag.lag_s,
            1e3 * lag.sigma_s
        ));
    }
    if let Some(error) = phantom.and_then(|told| told.error) {
        text.push_str(&format!(
            "phantom          its device set calls the error of its place {error}\n"
        ));
    }
    if let Some(moved) = found.phantom {
        let degrees = moved.turn.iter().map(|w| w * w).sum::<f64>().sqrt().to_degrees();
        let beyond = if moved.ratio > 3.0 {
            ": more than that error explains"
        } else {
            ""
        };
        text.push_str(&format!(
            "phantom          turned by {degrees:.2} degrees within its error, {:.1} deviations{beyond}\n",
            moved.ratio.max(0.0).sqrt()
        ));
    }
    if let Some(rows) = found.tracker {
        let most = rows.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
        text.push_str(&format!(
            "tracker          its shifts are off by up to {:.1} % of their length\n",
            100.0 * most
        ));
    }
    if let Some((n, distance)) = found.wall {
        text.push_str(&format!(
            "wall             normal ({:.4}, {:.4}, {:.4}), {distance:.2} mm from the reference's origin\n",
            n[0], n[1], n[2]
        ));
    }
    text
}
