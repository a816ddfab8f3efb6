//! The words of `calib marker`, and its part of the file.

use calib::bundle::Bundle;

use super::drawing::Drawing;
use super::frames::Frames;
use crate::calibration::{EmitterRecord, MarkerRecord, RejectedSighting};
use crate::text::line;

/// The part of the file; `numbers` are those of the frames.
pub(super) fn record(found: &Bundle, numbers: &[usize], frame: String) -> MarkerRecord {
    let emitter = |i: usize| {
        let (place, residuals) = (found.emitters[i]?, found.residuals[i]?);
        Some(EmitterRecord {
            at_mm: place.mm(),
            normal: None,
            covariance_upper_mm2: found
                .covariance_of(i)
                .map(|c| [c[(0, 0)], c[(0, 1)], c[(0, 2)], c[(1, 1)], c[(1, 2)], c[(2, 2)]]),
            sightings: residuals.sightings,
            rms_mm: Some(residuals.rms_mm),
            worst_mm: Some(residuals.worst_mm),
        })
    };
    let rejected = found.rejected.iter().map(|r| RejectedSighting {
        frame: numbers.get(r.view).copied().unwrap_or(r.view),
        emitter: r.emitter,
        residual_mm: r.residual_mm,
    });
    MarkerRecord {
        emitters: (0..found.emitters.len()).map(emitter).collect(),
        frame,
        views: found.poses.iter().flatten().count(),
        rms_mm: Some(found.rms_mm),
        noise_ratio: Some(found.noise_ratio).filter(|x| x.is_finite()),
        sigma_mm: Some(found.sigma_mm).filter(|x| x.is_finite()),
        condition: Some(found.condition),
        predicted_rms_mm: Some(found.predicted_rms_mm()),
        rejected: rejected.collect(),
    }
}

/// The report.
pub(super) fn text(frames: &Frames, found: &Bundle, record: &MarkerRecord, drawing: Option<&Drawing>) -> String {
    let mut text = format!(
        "{} sightings of {} emitters in {} frames of {}, {} of which give a pose\n\n",
        frames.sightings,
        record.emitters.len(),
        frames.views.len(),
        crate::text::shown(&frames.source.path.display().to_string()),
        record.views,
    );
    line!(
        text,
        "emitter          x          y          z mm      error mm  sightings   rms mm  longest"
    );
    for (i, emitter) in record.emitters.iter().enumerate() {
        row(&mut text, i, emitter.as_ref());
    }
    line!(
        text,
        "\nresiduals        rms {:.4} mm as lengths, {:.2} times the noise given, which would be {:.4} mm per axis",
        found.rms_mm,
        found.noise_ratio,
        found.sigma_mm
    );
    line!(
        text,
        "error            {:.4} mm rms of the places by their covariance, once the marker is laid on the true one;",
        found.predicted_rms_mm()
    );
    line!(
        text,
        "                 it is in no covariance of what is calibrated with this marker, nor of its poses: keep it small"
    );
    line!(text, "condition        {:.1}", found.condition);
    left_out(&mut text, record);
    if let Some(drawing) = drawing {
        compared(&mut text, found, drawing);
    }
    text
}

fn row(text: &mut String, i: usize, emitter: Option<&EmitterRecord>) {
    let Some(e) = emitter else {
        line!(text, "{i:>7}  seen too seldom, left out");
        return;
    };
    let [x, y, z] = e.at_mm;
    let error = e
        .covariance_upper_mm2
        .map_or(0.0, |c| (c[0] + c[3] + c[5]).max(0.0).sqrt());
    let (rms, worst) = (e.rms_mm.unwrap_or(0.0), e.worst_mm.unwrap_or(0.0));
    line!(
        text,
        "{i:>7} {x:>10.4} {y:>10.4} {z:>10.4} {error:>13.4} {:>10} {rms:>8.3} {worst:>8.3}",
        e.sightings
    );
}

fn left_out(text: &mut String, record: &MarkerRecord) {
    if record.rejected.is_empty() {
        return;
    }
    let one = |r: &RejectedSighting| {
        let off = r.residual_mm.map_or("no pose".to_owned(), |mm| format!("{mm:.2} mm"));
        format!("{} in frame {} ({off})", r.emitter, r.frame)
    };
    let shown: Vec<String> = record.rejected.iter().take(8).map(one).collect();
    let more = if record.rejected.len() > 8 { ", ..." } else { "" };
    line!(
        text,
        "left out         {} sightings: emitter {}{more}",
        record.rejected.len(),
        shown.join(", ")
    );
}

/// How far each emitter is from its place in the drawing.
fn compared(text: &mut String, found: &Bundle, drawing: &Drawing) {
    let both = found.emitters.iter().zip(drawing.places()).enumerate();
    let off = both.filter_map(|(i, (a, b))| Some((i, (*a)?.distance(b?))));
    let off: Vec<(usize, f64)> = off.collect();
    let squares: f64 = off.iter().map(|(_, d)| d * d).sum();
    let worst = off.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((emitter, mm)) = worst {
        line!(
            text,
            "drawing          kept: {} emitters are {:.4} mm rms from their places, emitter {emitter} most, {mm:.4} mm",
            off.len(),
            (squares / off.len() as f64).sqrt()
        );
    }
}
