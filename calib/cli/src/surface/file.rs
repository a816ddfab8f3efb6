//! The file of a registration by the bone's surface: that of every registration, with what is known of the surface beside.

use geometry::Point;
use geometry::rotation::Rotation;
use surface_registration::{Class, OrderCheck, Trend, free};

use super::points::Shared;
use super::{Made, TO};
use crate::live::calibration_of;
use crate::register::file::{FORMAT, InputFile, PredictedTre, RegistrationFile, SharedPart, Transform, Units, VERSION};
use crate::register::solve::To;
use crate::register::surface::{
    BoneRecord, Fitted, FreeMotion, MovedCheck, OtherMinimum, SurfacePointResult, SurfaceRecord, TrendRecord,
    TrendsRecord,
};
use crate::register::{COVARIANCE_CONVENTION, TRANSFORM_CONVENTION};

/// So many of the motions that are held least are told.
const MOTIONS: usize = 3;
/// So many of the other minima.
const OTHERS: usize = 5;

/// The file of what was found.
pub(super) fn describe(made: &Made<'_>) -> RegistrationFile {
    let covariance = made.found.transform.covariance();
    let (rms_mm, max_mm) = distances(made);
    RegistrationFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
        units: Units {
            length: "mm".to_owned(),
            angle: "rad".to_owned(),
        },
        to: TO.to_owned(),
        from: made.asked.from.clone(),
        method: "surface".to_owned(),
        transform: transform(made),
        fre_rms_mm: rms_mm,
        fre_max_mm: max_mm,
        condition: None,
        singular_values: None,
        certificate: None,
        noise: None,
        covariance: Some(std::array::from_fn(|i| std::array::from_fn(|j| covariance[(i, j)]))),
        covariance_convention: COVARIANCE_CONVENTION.to_owned(),
        centre_mm: centre(made).mm(),
        predicted_tre: predicted_tre(made),
        robust_tolerance_mm: None,
        shared: shared_part(made),
        plane: None,
        pairs: Vec::new(),
        surface: Some(surface(made)),
        inputs: inputs(made),
        gates: Vec::new(),
        ct_hash: made.asked.ct_hash.clone(),
        marker: made.asked.marker.clone(),
    }
}

fn transform(made: &Made<'_>) -> Transform {
    let rigid = made.found.transform.transform();
    let q = rigid.quaternion();
    // A registration's quaternion is unit, so that this never is the default.
    let vector = Rotation::from_quaternion(q).map(|r| r.vector().radians());
    let rows = rigid.rotation().matrix().rows();
    let t = rigid.translation_mm();
    let row = |i: usize| [rows[i][0], rows[i][1], rows[i][2], t[i]];
    Transform {
        name: format!("{TO}_from_{}", made.asked.from),
        convention: TRANSFORM_CONVENTION.to_owned(),
        quaternion_wxyz: q,
        rotation_vector_rad: vector.unwrap_or_default(),
        translation_mm: t,
        scale: 1.0,
        scale_fitted: false,
        matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
    }
}

/// Root mean square and largest distance of the points that have a say, each counting what it does in the fit.
fn distances(made: &Made<'_>) -> (f64, f64) {
    let (mut squares, mut weights, mut most) = (0.0, 0.0, 0.0_f64);
    for point in made.found.points.iter().filter(|point| point.weight > 0.0) {
        squares += point.weight * point.residual_mm * point.residual_mm;
        weights += point.weight;
        most = most.max(point.residual_mm.abs());
    }
    // Without any point that has a say the result is refused; 0 would look like a perfect one.
    let rms = if weights > 0.0 {
        f64::sqrt(squares / weights)
    } else {
        f64::MAX
    };
    (rms, most)
}

/// The middle of the points, in the CT.
fn centre(made: &Made<'_>) -> Point<To> {
    let points = made.measured.points.points();
    let mut sum = [0.0; 3];
    for point in points {
        let place = (made.found.transform.transform() * point.place).mm();
        sum = [0, 1, 2].map(|k| sum[k] + place[k] / points.len() as f64);
    }
    Point::new(sum[0], sum[1], sum[2])
}

fn predicted_tre(made: &Made<'_>) -> Vec<PredictedTre> {
    let targets = made.targets.iter().map(|target| ("target", *target));
    let tre = |(at, point): (&str, Point<To>)| PredictedTre {
        at: at.to_owned(),
        point_mm: point.mm(),
        rms_mm: Some(made.found.predicted_tre_mm(point)).filter(|mm| mm.is_finite()),
    };
    std::iter::once(("centre", centre(made)))
        .chain(targets)
        .map(tre)
        .collect()
}

fn surface(made: &Made<'_>) -> SurfaceRecord {
    let (found, facts, priors) = (&made.found, made.bone.surface.facts(), &made.asked.options.priors);
    let sigma = |i: usize| found.covariance[(i, i)].max(0.0).sqrt();
    SurfaceRecord {
        bone: BoneRecord {
            triangles: facts.triangles,
            inner_parts: facts.inner_parts,
            open_ends: facts.open_ends.len(),
            open_length_mm: facts.open_ends.iter().fold(0.0, |sum, end| sum + end.length_mm),
            sigma_mm: priors.bone_mm,
        },
        start: made.begun.word.to_owned(),
        depth_scale: Fitted {
            value: found.depth_scale,
            sigma: sigma(6),
            prior_sigma: priors.depth_scale,
        },
        offset_mm: Fitted {
            value: found.offset_mm,
            sigma: sigma(7),
            prior_sigma: priors.offset_mm,
        },
        // JSON has no infinity; a ratio that is none is refused.
        noise_ratio: found.noise_ratio.min(f64::MAX),
        share_kept: found.share_kept,
        kept: found.kept,
        share_facing_away: found.share_facing_away,
        share_beyond: found.share_beyond,
        searched: [found.seeds, found.fits, found.hits],
        others: found
            .others
            .iter()
            .take(OTHERS)
            .map(|other| OtherMinimum {
                margin: other.margin,
                apart_mm: other.apart_mm,
                hits: other.hits,
            })
            .collect(),
        landmark_ratio: found.landmark_ratio,
        shared_error: shared_words(&made.measured.shared),
        free: free(found, &made.targets)
            .iter()
            .take(MOTIONS)
            .map(|motion| FreeMotion {
                motion: motion.to_string(),
                at_targets_mm: motion.deviation_mm,
            })
            .collect(),
        moved_check: Some(moved_check(&found.order)),
        trends: Some(TrendsRecord {
            drift: found.drift.map(trend),
            side: found.side.map(trend),
            told_side_mm: priors.side_mm,
        }),
        warnings: made.warnings(),
        points: points(made),
    }
}

fn trend(of: Trend) -> TrendRecord {
    TrendRecord {
        deviations: of.deviations,
        mm: of.mm,
        towards: of.towards,
    }
}

fn moved_check(order: &OrderCheck) -> MovedCheck {
    MovedCheck {
        made: matches!(order, OrderCheck::Made { .. }),
        places: match order {
            OrderCheck::Made { places } => *places,
            OrderCheck::TooFew { .. } | OrderCheck::Undecided => 0,
        },
        why_not: order.why_not(),
    }
}

/// What is said of the error that all points share.
pub(super) fn shared_words(shared: &Shared) -> String {
    match shared {
        Shared::Unknown => "not told: the errors predicted are without it".to_owned(),
        Shared::Touches => "that of the touches, u1x to u3z of their file".to_owned(),
        Shared::Shift(mm) => format!("a shift of all points, {mm} mm along each axis"),
        Shared::Tip(of, _) | Shared::Probe(of, ..) => format!("that of {}", crate::text::shown(of)),
    }
}

/// What the points share, by the numbers that touches are with; or that its covariance is without it, where nothing was told. Of what else
/// is told a check takes no part for known.
fn shared_part(made: &Made<'_>) -> Option<SharedPart> {
    let columns = match made.measured.shared {
        Shared::Unknown => None,
        Shared::Touches => Some(std::array::from_fn(|i| {
            std::array::from_fn(|j| made.found.shared[(i, j)])
        })),
        Shared::Shift(_) | Shared::Tip(..) | Shared::Probe(..) => return None,
    };
    Some(SharedPart {
        calibration: calibration_of(&made.source.text).map(str::to_owned),
        columns,
    })
}

/// The word of a class in files and reports.
pub(super) fn class_name(class: Class) -> &'static str {
    match class {
        Class::Kept => "kept",
        Class::InFront => "in front",
        Class::Behind => "behind",
        Class::FacesAway => "faces away",
        Class::Beyond => "beyond",
    }
}

fn points(made: &Made<'_>) -> Vec<SurfacePointResult> {
    let measured = &made.measured;
    let lines = measured.lines.iter().zip(&measured.labels);
    let each = measured.points.points().iter().zip(&made.found.points).zip(lines);
    each.map(|((point, result), (line, label))| SurfacePointResult {
        line: *line,
        label: label.clone(),
        place_mm: (made.found.transform.transform() * point.place).mm(),
        residual_mm: result.residual_mm,
        deviations: result.deviations,
        weight: result.weight,
        class: class_name(result.class).to_owned(),
    })
    .collect()
}

fn inputs(made: &Made<'_>) -> Vec<InputFile> {
    let source = &made.source;
    let points = InputFile {
        role: "points".to_owned(),
        path: source.path.to_string_lossy().into_owned(),
        bytes: source.bytes,
        blake3: source.blake3.clone(),
    };
    let rest = made.bone.inputs.iter().chain(&made.begun.inputs).cloned();
    std::iter::once(points).chain(rest).collect()
}
