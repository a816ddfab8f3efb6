//! `calib register`: reads pairs, registers them, writes the file and returns the report.

pub(crate) mod args;
pub(crate) mod duplicates;
pub(crate) mod file;
pub(crate) mod input;
pub(crate) mod input_error;
pub(crate) mod report;
pub(crate) mod residual_table;
pub(crate) mod row;
pub(crate) mod solve;
pub(crate) mod surface;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use calib::registration::Registration;
use geometry::rotation::Rotation;
use geometry::{Point, VolumeGrid};

use crate::bounds::{NotJudged, on_registration};
use crate::commands::Outcome;
use crate::commands::common::{broken, verdict_text};
use crate::live::{LiveError, calibration_of};
use crate::register::file::{
    Certificate, FORMAT, InputFile, Noise, PairResult, PlaneRecord, PredictedTre, RegistrationFile, SharedPart,
    Transform, Units, VERSION,
};
use crate::register::input::{From, Input};
use crate::register::input_error::InputError;
use crate::register::solve::{Options, Solution, SolveError, method_name, solve};
use crate::scene_context::SceneContext;
use crate::store::{self, StoreError};

pub(crate) use calib::file::{COVARIANCE_CONVENTION, TRANSFORM_CONVENTION};

/// Of a registration whose points lie in a plane.
const UNDECIDED_SIDE: &str = "the points lie in a plane to their noise: mirrored through it they fit as well, so that which side of it is which rests on \
     both frames being right-handed alone";

/// One registration to be made.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    pub(crate) input: From,
    pub(crate) allow_duplicates: bool,
    pub(crate) options: Options,
    /// In `to`, mm.
    pub(crate) targets: Vec<[f64; 3]>,
    pub(crate) to: String,
    pub(crate) from: String,
    pub(crate) out: Option<PathBuf>,
    pub(crate) overwrite: bool,
    /// The hash of the CT volume, and the marker, that the registration is for.
    pub(crate) ct_hash: Option<String>,
    /// Of that CT, where it was read: points of `to` lie in it.
    pub(crate) grid: Option<VolumeGrid>,
    pub(crate) marker: Option<String>,
    /// The report lists every pair.
    pub(crate) all: bool,
    /// The report is the file.
    pub(crate) json: bool,
}

/// Why there is no registration.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RegisterError {
    #[error(transparent)]
    Input(#[from] InputError),
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    NotJudged(#[from] NotJudged),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    Volume(Box<dyn std::error::Error + Send + Sync>),
}

/// Does what is asked, and returns the report for people; a result that does not keep the scene's gates is not written.
pub(crate) fn register(request: &Request, scened: Option<&SceneContext>) -> Result<Outcome, RegisterError> {
    if let Some(out) = &request.out {
        store::check(out, request.overwrite)?;
    }
    let input = Input::read(&request.input, request.options.weights, request.allow_duplicates)?;
    // With a scale the units are what is asked for.
    if !request.options.scale {
        input.refuse_small()?;
    }
    if let Some(grid) = &request.grid {
        input.refuse_outside(grid)?;
    }
    // Behind those: that a point is not where it can be says more than that it does not fit.
    let solution = solve(&input.rows, &request.options, &input.names())?;
    let mut file = describe(request, &input, &solution);
    let (judged, refused) = judge(&mut file, scened)?;
    let mut text = report::text(&file, request.all) + &judged;
    if input.has_weights && !request.options.weights {
        text.push_str("\nThe file's weights were not used; --weights uses them.\n");
    }
    if let (Some(out), Some(_)) = (&request.out, &refused) {
        text.push_str(&format!("\nnot written to {}\n", out.display()));
    } else if let Some(out) = &request.out {
        let inputs = input.sources.iter().map(|(_, source)| source.path.as_path());
        store::write(out, file.to_json(), inputs)?;
        text.push_str(&format!("\nwritten to {}\n", out.display()));
    }
    if request.json {
        text = file.to_json().map_err(NotJudged::from)?;
    }
    Ok(Outcome { text, refused })
}

/// Holds a registration against the gates of a scene, which it then names: their words, and why it is not accepted where it
/// is not.
pub(crate) fn judge(
    file: &mut RegistrationFile,
    scened: Option<&SceneContext>,
) -> Result<(String, Option<String>), NotJudged> {
    let Some(scened) = scened else {
        return Ok((String::new(), None));
    };
    if let Some(warning) = scened.unused_from(&file.from) {
        bus::stderr_line!("calib: {warning}");
    }
    file.gates = on_registration(file, scened)?;
    Ok((format!("\n{}", verdict_text(&file.gates)), broken(&file.gates)))
}

/// The file of a solution.
pub(crate) fn describe(request: &Request, input: &Input, solution: &Solution) -> RegistrationFile {
    let registration = &solution.registration;
    let used = registration
        .fre_mm
        .iter()
        .zip(&solution.weights)
        .filter(|(_, w)| **w > 0.0);
    RegistrationFile {
        format: FORMAT.to_owned(),
        version: VERSION,
        program: concat!("calib ", env!("CARGO_PKG_VERSION")).to_owned(),
        units: Units {
            length: "mm".to_owned(),
            angle: "rad".to_owned(),
        },
        to: request.to.clone(),
        from: request.from.clone(),
        method: method_name(request.options.method).to_owned(),
        transform: transform(request, solution),
        fre_rms_mm: registration.fre_rms_mm,
        fre_max_mm: used.map(|(fre, _)| *fre).fold(0.0, f64::max),
        condition: Some(registration.fit.condition()),
        singular_values: Some(registration.fit.singular_values().0),
        certificate: Some(certificate(registration)),
        noise: Some(Noise {
            sigma_mm: solution.noise.sigma_mm,
            estimated: solution.estimated.is_some(),
            degrees_of_freedom: solution.estimated.map(|of| of.freedom),
            times_told: solution.told.map(|told| told.times).filter(|times| *times > 1.0),
            touches: solution.touches,
        }),
        covariance: covariance(solution),
        covariance_convention: COVARIANCE_CONVENTION.to_owned(),
        centre_mm: registration.centre().mm(),
        predicted_tre: predicted_tre(request, solution),
        robust_tolerance_mm: request.options.robust,
        shared: shared(input, solution),
        plane: solution.plane.map(|mirror| PlaneRecord {
            point_mm: registration.centre().mm(),
            normal: mirror.normal.mm(),
            side: UNDECIDED_SIDE.to_owned(),
        }),
        pairs: pairs(input, solution),
        surface: None,
        inputs: inputs(input),
        gates: Vec::new(),
        ct_hash: request.ct_hash.clone(),
        marker: request.marker.clone(),
    }
}

fn transform(request: &Request, solution: &Solution) -> Transform {
    let rigid = &solution.registration.fit.transform;
    let q = rigid.quaternion();
    // A registration's quaternion is unit, so that this never is the default.
    let vector = Rotation::from_quaternion(q).map(|r| r.vector().radians());
    Transform {
        name: format!("{}_from_{}", request.to, request.from),
        convention: TRANSFORM_CONVENTION.to_owned(),
        quaternion_wxyz: q,
        rotation_vector_rad: vector.unwrap_or_default(),
        translation_mm: rigid.translation_mm(),
        scale: solution.scale,
        scale_fitted: request.options.scale,
        matrix: solution.matrix(),
    }
}

fn certificate(registration: &Registration<solve::To, solve::From>) -> Certificate {
    let certificate = registration.fit.certificate();
    Certificate {
        global_optimum: certificate.is_global(),
        asymmetry: certificate.asymmetry,
        least: certificate.least,
        error_bound_rad: finite(certificate.error_bound_rad()),
    }
}

/// JSON has no infinity.
fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn covariance(solution: &Solution) -> Option<[[f64; 6]; 6]> {
    let matrix = solution.covariance()?;
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    matrix.iter().all(|x| x.is_finite()).then_some(rows)
}

/// What touches share; `None` where points are not of touches that state their errors.
fn shared(input: &Input, solution: &Solution) -> Option<SharedPart> {
    solution.touches?;
    let rows = |shared: &nalgebra::Matrix6x3<f64>| std::array::from_fn(|i| std::array::from_fn(|j| shared[(i, j)]));
    let told = solution.touches.and_then(|touches| touches.shared_mm).is_some();
    let of = solution.by_pairs.as_ref().filter(|_| told);
    Some(SharedPart {
        calibration: input
            .sources
            .iter()
            .filter(|(role, _)| *role != "to")
            .find_map(|(_, source)| calibration_of(&source.text).map(str::to_owned)),
        columns: of.map(|of| rows(&of.shared)),
    })
}

fn predicted_tre(request: &Request, solution: &Solution) -> Vec<PredictedTre> {
    let centre = ("centre", solution.registration.centre().mm());
    let targets = request.targets.iter().map(|target| ("target", *target));
    let tre = |(at, point_mm): (&str, [f64; 3])| {
        let [x, y, z] = point_mm;
        let rms = solution.predicted_tre_mm(Point::new(x, y, z));
        PredictedTre {
            at: at.to_owned(),
            point_mm,
            rms_mm: finite(rms),
        }
    };
    std::iter::once(centre).chain(targets).map(tre).collect()
}

fn pairs(input: &Input, solution: &Solution) -> Vec<PairResult> {
    let result = |(i, row): (usize, &crate::register::row::Row)| PairResult {
        lines: row.lines,
        label: row.label.clone(),
        weight: solution.weights[i],
        fre_mm: solution.registration.fre_mm[i],
        leave_one_out_mm: solution.registration.leave_one_out_mm[i].and_then(finite),
        inlier: solution.inliers.as_ref().map(|inliers| inliers[i]),
    };
    input.rows.iter().enumerate().map(result).collect()
}

pub(crate) fn inputs(input: &Input) -> Vec<InputFile> {
    let file = |(role, source): &(&'static str, crate::input_files::source::Source)| InputFile {
        role: (*role).to_owned(),
        path: source.path.to_string_lossy().into_owned(),
        bytes: source.bytes,
        blake3: source.blake3.clone(),
    };
    input.sources.iter().map(file).collect()
}
