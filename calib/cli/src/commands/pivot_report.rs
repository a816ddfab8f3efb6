//! The words of `calib pivot`.

use calib::pivot::{Method, Pivot, Refused, apart};
use geometry::{Marker, Tracker};

use super::common::{recorded_text, verdict_text};
use crate::calibration::{EMITTERS, Gate, PivotRecord, ToolRecord};
use crate::poses::Recording;
use crate::text::line;

/// A method's result.
pub(super) type Solution = Result<Pivot<Tracker, Marker>, Refused>;

/// The report.
pub(super) fn text(
    recording: &Recording,
    found: &Pivot<Tracker, Marker>,
    all: &[(Method, Solution)],
    record: &PivotRecord,
    gates: &[Gate],
) -> String {
    let mut text = recorded_text(recording);
    text.push('\n');
    table(&mut text, found.method, all);
    text.push('\n');
    if let Some(disagreement) = &record.disagreement {
        line!(text, "warning          {disagreement}\n");
    }
    quality(&mut text, found, record);
    line!(text, "emitters         {EMITTERS}");
    slipped(&mut text, found);
    text.push('\n');
    text + &verdict_text(gates)
}

/// Which methods disagree by more than their errors, and what to do.
pub(super) fn disagreement(all: &[(Method, Solution)]) -> Option<String> {
    let found: Vec<_> = all.iter().filter_map(|(_, s)| s.as_ref().ok().cloned()).collect();
    let apart = apart(&found)?;
    let [a, b] = apart.methods.map(Method::name);
    Some(format!(
        "{a} and {b} put the tip {:.2} mm apart, and their errors allow {:.2}: it slipped or its divot gives way, or --sigma-mm and \
         --sigma-deg are not the noise; the error below says too little. Pivot again in a firm divot, on a wider cone",
        apart.mm, apart.most_mm
    ))
}

/// The frame that goes with the tip.
pub(super) fn frame(record: &ToolRecord) -> String {
    let ([w, x, y, z], [a, b, c]) = (record.quaternion_wxyz, record.translation_mm);
    format!(
        "marker_from_tool quaternion {w:.9}, {x:.9}, {y:.9}, {z:.9}; translation {a:.4}, {b:.4}, {c:.4} mm, with the direction \
         given\n\n"
    )
}

fn table(text: &mut String, chosen: Method, all: &[(Method, Solution)]) {
    let (method, tip, pivot) = ("method", "tip in the marker, mm", "pivot in the tracker, mm");
    line!(
        text,
        "  {method:<20} {tip:^29} {pivot:^32} {:>6} {:>8}",
        "poses",
        "rms mm"
    );
    for (method, solution) in all {
        let mark = if *method == chosen { '*' } else { ' ' };
        let name = method.name();
        match solution {
            Ok(found) => {
                let ([a, b, c], [x, y, z]) = (found.tip.mm(), found.pivot.mm());
                let (count, rms) = (found.inliers, found.rms_mm);
                line!(
                    text,
                    "{mark} {name:<20} {a:>9.3} {b:>9.3} {c:>9.3} {x:>10.3} {y:>10.3} {z:>10.3} {count:>6} {rms:>8.3}"
                );
            }
            Err(refused) => {
                line!(text, "{mark} {name:<20} {refused}");
            }
        }
    }
}

fn quality(text: &mut String, found: &Pivot<Tracker, Marker>, record: &PivotRecord) {
    line!(
        text,
        "residuals        rms {:.3} mm as lengths, {:.3} mm per component, longest {:.3} mm, of {} poses",
        found.rms_mm,
        found.rms_scalar_mm,
        found.worst_mm,
        found.inliers
    );
    match found.tip_covariance() {
        Some(c) => {
            let [x, y, z] = [0, 1, 2].map(|i| c[(i, i)].max(0.0).sqrt());
            let rms = c.trace().max(0.0).sqrt();
            line!(
                text,
                "tip error        {x:.4}, {y:.4}, {z:.4} mm along the marker's axes, {rms:.4} mm rms"
            );
        }
        None => {
            line!(text, "tip error        unknown: this method has no covariance");
        }
    }
    let (assumed, estimated) = (record.noise_assumed, record.noise_estimated);
    if let (true, Some(ratio)) = (record.pose_covariances, record.noise_ratio) {
        line!(
            text,
            "noise            {ratio:.2} times the covariances of the poses by the residuals; on the average {:.3} mm and {:.3} deg",
            estimated.sigma_mm,
            estimated.sigma_deg
        );
    } else {
        line!(
            text,
            "noise            {:.3} mm and {:.3} deg by the residuals; the ratio of {} mm and {} deg was assumed",
            estimated.sigma_mm,
            estimated.sigma_deg,
            assumed.sigma_mm,
            assumed.sigma_deg
        );
    }
    line!(text, "condition        {:.1}", found.condition);
    let [a, b, c] = found.coverage.angles_deg();
    line!(
        text,
        "coverage         {a:.1}, {b:.1} and {c:.1} degrees about the principal axes"
    );
    match &record.coverage.advice {
        Some(advice) => {
            line!(text, "                 {advice}");
        }
        None => {
            line!(text, "                 wide enough");
        }
    }
}

fn slipped(text: &mut String, found: &Pivot<Tracker, Marker>) {
    let slipped = |i: &usize| found.weights[*i] == 0.0;
    let list: Vec<usize> = (0..found.weights.len()).filter(slipped).collect();
    if list.is_empty() {
        return;
    }
    let shown: Vec<String> = list.iter().take(10).map(|i| (i + 1).to_string()).collect();
    let more = if list.len() > 10 { " ..." } else { "" };
    line!(
        text,
        "slipped          {} poses were left out: {}{more}",
        list.len(),
        shown.join(", ")
    );
}
