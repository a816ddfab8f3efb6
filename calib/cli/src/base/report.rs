//! The words of `calib base`, and its part of the file.

use calib::base::Located;
use geometry::{Base, Frame, Point};

use super::touches::Touches;
use crate::calibration::{BaseRecord, FeatureRecord, GroupRecord, RejectedTouchRecord};
use crate::text::line;

/// The part of the file, but for the seat.
pub(super) fn record<F: Frame>(
    touches: &Touches<F>,
    found: &Located<F>,
    frame: &str,
    tip_radius_mm: f64,
) -> BaseRecord {
    let group = |(i, name): (usize, &String)| GroupRecord {
        name: name.clone(),
        feature: found.assignment[i].to_string(),
        touches: touches.groups[i].touches.len(),
    };
    let feature = |r: &calib::base::FeatureResiduals| FeatureRecord {
        feature: r.feature.to_string(),
        touches: r.touches,
        rms_mm: r.rms_mm,
        worst_mm: r.worst_mm,
    };
    let rejected = |r: &calib::base::RejectedTouch| RejectedTouchRecord {
        line: touches.lines[r.group][r.touch],
        distance_mm: r.distance_mm,
    };
    let place = found.place.transform();
    BaseRecord {
        of_frame: frame.to_owned(),
        quaternion_wxyz: place.quaternion(),
        translation_mm: place.translation_mm(),
        covariance_upper: found.place.upper(),
        groups: touches.names.iter().enumerate().map(group).collect(),
        features: found.residuals.iter().map(feature).collect(),
        rejected: found.rejected.iter().map(rejected).collect(),
        rms_mm: found.rms_mm,
        noise_ratio: found.noise_ratio,
        condition: found.condition,
        weakest: found.weakest.to_string(),
        tip_radius_mm,
        base_from_tool: None,
    }
}

/// The report.
pub(super) fn text<F: Frame>(touches: &Touches<F>, found: &Located<F>, record: &BaseRecord) -> String {
    let mut text = format!(
        "{} touches of {}\n",
        touches.count,
        crate::text::shown(&touches.source.path.display().to_string())
    );
    for group in &record.groups {
        line!(
            text,
            "  {:<16} {:>4} touches, on {}",
            group.name,
            group.touches,
            group.feature
        );
    }
    let ([w, x, y, z], [a, b, c]) = (record.quaternion_wxyz, record.translation_mm);
    line!(
        text,
        "\n{}_from_base quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm",
        record.of_frame
    );
    for f in &record.features {
        line!(
            text,
            "  {:<9} {:>4} touches, rms {:.3} mm, farthest {:.3} mm",
            f.feature,
            f.touches,
            f.rms_mm,
            f.worst_mm
        );
    }
    line!(
        text,
        "residuals        rms {:.3} mm, {:.2} times the noise given",
        record.rms_mm,
        record.noise_ratio
    );
    let seat = record
        .base_from_tool
        .as_ref()
        .map_or([0.0, 0.0, 80.0], |seat| seat.translation_mm);
    let at = |[x, y, z]: [f64; 3]| (found.place * Point::<Base>::new(x, y, z)).rms_mm();
    line!(
        text,
        "error            {:.4} mm rms at the base's origin, {:.4} mm at ({}, {}, {}) in it",
        at([0.0; 3]),
        at(seat),
        seat[0],
        seat[1],
        seat[2]
    );
    line!(
        text,
        "condition        {:.1}; weakest is {}",
        record.condition,
        record.weakest
    );
    for r in record.rejected.iter().take(10) {
        line!(text, "left out         line {}, {:.3} mm off", r.line, r.distance_mm);
    }
    if record.rejected.len() > 10 {
        line!(text, "                 and {} more", record.rejected.len() - 10);
    }
    text.push('\n');
    text
}
