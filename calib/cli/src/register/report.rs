//! The report for people: what was found and how far it can be trusted.

use crate::text::{line, mm, shown};

use calib::registration::few_residuals_factor;

use crate::register::file::{Certificate, PlaneRecord, PredictedTre, RegistrationFile};
use crate::register::residual_table;

/// Below this the third singular value tells of a mirror image: of a perfect one it is the relative extent along the
/// thinnest axis, down to -1/3, while noise in a plane leaves it at the square of its relative size.
const MIRRORED: f64 = -0.01;

/// The report; `all` lists every pair however many there are.
pub(crate) fn text(file: &RegistrationFile, all: bool) -> String {
    let mut text = String::new();
    heading(&mut text, file);
    transform(&mut text, file);
    quality(&mut text, file);
    accuracy(&mut text, file);
    text.push('\n');
    text.push_str(&residual_table::text(file, all));
    text
}

fn heading(text: &mut String, file: &RegistrationFile) {
    let inputs: Vec<String> = file.inputs.iter().map(|input| shown(&input.path)).collect();
    line!(
        text,
        "{} by {}, {} pairs of {}",
        file.transform.name,
        file.method,
        file.pairs.len(),
        inputs.join(" and ")
    );
    let used = file.pairs.iter().filter(|pair| pair.weight > 0.0).count();
    if let Some(tolerance) = file.robust_tolerance_mm {
        line!(
            text,
            "{used} agree within {tolerance} mm and were used; the others are outliers"
        );
    } else if used < file.pairs.len() {
        line!(text, "{used} of them have a weight above zero");
    }
    line!(text);
}

pub(crate) fn transform(text: &mut String, file: &RegistrationFile) {
    line!(text, "matrix (mm)");
    for [a, b, c, t] in file.transform.matrix {
        line!(text, "  {a:>14.10} {b:>14.10} {c:>14.10} {t:>18.9}");
    }
    let degrees = file.transform.rotation_vector_rad.map(f64::to_degrees);
    let angle = degrees.iter().map(|x| x * x).sum::<f64>().sqrt();
    line!(
        text,
        "rotation vector  {} deg (angle {angle:.6} deg)",
        three(degrees, 6)
    );
    line!(text, "translation      {} mm", three(file.transform.translation_mm, 6));
    if file.transform.scale_fitted {
        line!(text, "scale            {:.9}", file.transform.scale);
    }
    line!(text);
}

fn quality(text: &mut String, file: &RegistrationFile) {
    line!(
        text,
        "FRE rms          {} mm, longest {} mm",
        mm(file.fre_rms_mm),
        mm(file.fre_max_mm)
    );
    if let (Some(condition), Some(certificate)) = (file.condition, &file.certificate) {
        line!(text, "condition        {condition:.3e}");
        line!(text, "certificate      {}", proof(certificate));
    }
    if let Some([_, _, third]) = file.singular_values
        && third < MIRRORED
    {
        line!(
            text,
            "WARNING          a mirror image fits better than any rotation (third singular value {third:.2}): check the sign \
             of each axis and the order of the points"
        );
    }
}

fn proof(certificate: &Certificate) -> String {
    let bound = certificate
        .error_bound_rad
        .map_or("unbounded".to_owned(), |rad| format!("{rad:.1e} rad"));
    match certificate.global_optimum {
        true => format!("this is the global optimum, to within {bound}"),
        false => format!("NOT PROVEN to be the global optimum (angle to it: {bound})"),
    }
}

pub(crate) fn accuracy(text: &mut String, file: &RegistrationFile) {
    if let Some(noise) = &file.noise {
        let origin = match noise.estimated {
            true => "estimated from the residuals",
            false => "given",
        };
        line!(text, "noise            {} mm per axis, {origin}", mm(noise.sigma_mm));
        if let Some(times) = noise.times_told {
            line!(
                text,
                "                 WARNING residuals show more: this is {times:.2} times the noise that was given"
            );
        }
        if let Some(freedom) = noise.degrees_of_freedom {
            line!(
                text,
                "                 from {freedom} degrees of freedom: errors are predicted for {:.2} times that noise",
                few_residuals_factor(freedom).sqrt()
            );
        }
        if let (true, Some(tolerance)) = (noise.estimated, file.robust_tolerance_mm) {
            line!(
                text,
                "                 and from pairs within {tolerance} mm alone: TOO SMALL, as errors with it, where that cut off true errors; \
                 give --noise-mm, or a tolerance of four times the noise"
            );
        }
    }
    match &file.covariance {
        Some(covariance) => deviations(text, file, covariance),
        None => {
            line!(text, "deviations       unknown: the points lie on a line to rounding");
        }
    }
    if let Some(plane) = &file.plane {
        mirrored(text, file, plane);
    }
    for tre in &file.predicted_tre {
        let PredictedTre { at, point_mm, rms_mm } = tre;
        let rms = rms_mm.map_or("unbounded".to_owned(), |rms| format!("{} mm rms", mm(rms)));
        line!(text, "predicted TRE    {rms} at {} ({at})", three(*point_mm, 3));
    }
}

/// That a mirrored body would not be told from this one, and how far off the targets would be by it.
fn mirrored(text: &mut String, file: &RegistrationFile, plane: &PlaneRecord) {
    line!(text, "WARNING          {}", shown(&plane.side));
    for tre in file.predicted_tre.iter().filter(|tre| tre.at == "target") {
        let off = 2.0 * plane.off_mm(tre.point_mm);
        if tre.rms_mm.is_none_or(|rms| off > 2.0 * rms) {
            line!(
                text,
                "                 the target {} would be {} mm off, and no residual would show it",
                three(tre.point_mm, 3),
                mm(off)
            );
        }
    }
    line!(
        text,
        "                 check it at a known point off that plane, or touch one more point off it"
    );
}

fn deviations(text: &mut String, file: &RegistrationFile, covariance: &[[f64; 6]; 6]) {
    let deviation = |i: usize| covariance[i][i].max(0.0).sqrt();
    let rotation = [0, 1, 2].map(|i| mm(deviation(i).to_degrees()));
    let translation = [3, 4, 5].map(|i| mm(deviation(i)));
    line!(
        text,
        "deviations       rotation {} deg about the axes of {}",
        rotation.join(", "),
        file.to
    );
    line!(
        text,
        "                 translation {} mm at its origin",
        translation.join(", ")
    );
}

/// Three numbers in a row.
fn three(v: [f64; 3], digits: usize) -> String {
    // What rounds to zero has no sign.
    let rounded = |x: f64| {
        if x.abs() < 0.5 * 10.0_f64.powi(-(digits as i32)) {
            0.0
        } else {
            x
        }
    };
    v.map(|x| format!("{:.digits$}", rounded(x))).join(", ")
}
