//! From the pairs that were read to the registration, by the options of the command line.

use calib::registration::{
    Method, Mirror, Noise, PairError, Pairs, Propagated, Refused, Registration, chi_squared, few_residuals_factor,
    fit_scaled, greatest_chi_squared, propagated, register, register_robust, rms_at, told_noise_factor,
};
use geometry::{Frame, Point};
use nalgebra::{Matrix3, Matrix6};

use crate::input_files::points_text::StatedError;
use crate::refusal::NoRegistration;
use crate::register::file::TouchNoise;
use crate::register::row::Row;

/// The frame that `--to` names. Its name is known at run time only, so that it is none of the system's frames.
#[derive(Debug, Clone, Copy)]
pub(crate) enum To {}
/// The frame that `--from` names.
#[derive(Debug, Clone, Copy)]
pub(crate) enum From {}

impl Frame for To {
    const NAME: &'static str = "to";
}
impl Frame for From {
    const NAME: &'static str = "from";
}

/// The most pairs of a robust registration: the search compares all of them with one another.
pub(crate) const MAX_ROBUST: usize = 500;

/// What is asked for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Options {
    pub(crate) method: Method,
    pub(crate) weights: bool,
    pub(crate) scale: bool,
    /// Tolerance, mm.
    pub(crate) robust: Option<f64>,
    /// `None`: more than half.
    pub(crate) min_inliers: Option<usize>,
    /// Standard deviation per axis, mm; `None`: estimated from the residuals. Where touches state their errors, of what comes to these: the
    /// hand, and the point of `To`.
    pub(crate) noise_mm: Option<f64>,
    /// Of an estimate, the least, mm.
    pub(crate) least_noise_mm: Option<f64>,
}

/// What was found.
#[derive(Debug)]
pub(crate) struct Solution {
    /// With `--scale`: of the `From` points times the scale.
    pub(crate) registration: Registration<To, From>,
    pub(crate) scale: f64,
    /// The weight that each pair had in the fit, the largest 1; 0 for outliers.
    pub(crate) weights: Vec<f64>,
    pub(crate) inliers: Option<Vec<bool>>,
    pub(crate) noise: Noise,
    /// Of the residuals, where `noise` was estimated from them, and the noise that covariance and predictions are for: larger, as few
    /// residuals tell little of it ([`few_residuals_factor`]).
    pub(crate) estimated: Option<Estimated>,
    /// Residuals against a noise that was told.
    pub(crate) told: Option<Told>,
    /// The covariance where errors are known pair by pair; else it is by `noise`.
    pub(crate) by_pairs: Option<Propagated>,
    /// What the errors are made of, where touches state theirs.
    pub(crate) touches: Option<TouchNoise>,
    /// The plane that mirrors the body into one which the pairs do not tell from it.
    pub(crate) plane: Option<Mirror<To>>,
}

/// A noise that residuals suggest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Estimated {
    pub(crate) freedom: u32,
    pub(crate) allowed: Noise,
}

/// A noise that was told, and what residuals say of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Told {
    /// Squares of residuals over that noise, and the most that it explains.
    chi_squared: [f64; 2],
    /// What the deviation is multiplied by for their sake, at least 1.
    pub(crate) times: f64,
}

impl Told {
    /// Of residuals that were judged elsewhere.
    pub(crate) const fn times(times: f64) -> Self {
        Self {
            chi_squared: [0.0, 0.0],
            times,
        }
    }

    fn new(chi_squared: f64, freedom: u32) -> Self {
        Self {
            chi_squared: [chi_squared, greatest_chi_squared(freedom)],
            times: told_noise_factor(chi_squared, freedom).sqrt(),
        }
    }
}

/// Why there is no solution.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SolveError {
    /// The numerics refused.
    #[error(transparent)]
    Refused(#[from] NoRegistration),
    /// Residuals that are not those of the noise told.
    #[error(
        "registering the {pairs} pairs of {files}: residuals of {fre_rms_mm:.3} mm rms are none of a noise of {noise_mm} mm along each axis \
         (squares over it {found:.0}, at most {most:.0}): pairs may be exchanged, or points in other units or of another body; look at the \
         residuals of the pairs with --all and without --noise-mm, tell the noise that is true, or leave outliers out with --robust"
    )]
    NoiseTold {
        pairs: usize,
        files: String,
        fre_rms_mm: f64,
        noise_mm: f64,
        found: f64,
        most: f64,
    },
    /// The search for outliers would not end.
    #[error(
        "registering the {pairs} pairs of {files}: --robust compares all pairs with one another and takes at most \
         {MAX_ROBUST}; thin the set out"
    )]
    TooManyForRobust { pairs: usize, files: String },
    /// What a touch states is no covariance.
    #[error(
        "registering the pairs of {files}: line {line}: cxx to czz are no covariance, or less than u1x to u3z make of it; \
         expected one with no negative variance beside what is shared: touch anew"
    )]
    Stated { files: String, line: usize },
}

/// The name of a method on the command line and in files.
pub(crate) fn method_name(method: Method) -> &'static str {
    match method {
        Method::Newton => "newton",
        Method::Svd => "svd",
        Method::HornQuaternion => "horn-quaternion",
        Method::FaugerasHebert => "faugeras-hebert",
        Method::HornPolar => "horn-polar",
        Method::RotationVector => "rotation-vector",
    }
}

/// Registers the rows; `files` names them in errors.
pub(crate) fn solve(rows: &[Row], options: &Options, files: &str) -> Result<Solution, SolveError> {
    if options.robust.is_some() && rows.len() > MAX_ROBUST {
        return Err(SolveError::TooManyForRobust {
            pairs: rows.len(),
            files: files.to_owned(),
        });
    }
    if let Some(row) = rows.iter().find(|row| row.error.is_some_and(|error| !error.is_good())) {
        return Err(SolveError::Stated {
            files: files.to_owned(),
            line: row.lines[1],
        });
    }
    let solved = unexplained(rows, options);
    let refused = |refused| NoRegistration {
        pairs: rows.len(),
        files: files.to_owned(),
        method: method_name(options.method),
        refused,
    };
    let solution = solved.map_err(refused)?;
    match (solution.told, options.noise_mm) {
        (
            Some(Told {
                chi_squared: [found, most],
                ..
            }),
            Some(noise_mm),
        ) if found > most => Err(SolveError::NoiseTold {
            pairs: rows.len(),
            files: files.to_owned(),
            fre_rms_mm: solution.registration.fre_rms_mm,
            noise_mm,
            found,
            most,
        }),
        _ => Ok(solution),
    }
}

fn unexplained(rows: &[Row], options: &Options) -> Result<Solution, Refused> {
    let to: Vec<Point<To>> = rows.iter().map(|row| point(row.to)).collect();
    let from: Vec<Point<From>> = rows.iter().map(|row| point(row.from)).collect();
    let mut weights = relative_weights(rows, options.weights);
    let pairs = Pairs::new(&to, &from)?.weighted(&weights)?;
    let (registration, scale, inliers) = match options.robust {
        Some(tolerance_mm) => {
            let needed = options.min_inliers.unwrap_or(rows.len() / 2 + 1);
            let robust = register_robust(pairs, options.method, tolerance_mm, needed)?;
            (robust.registration, 1.0, Some(robust.inliers))
        }
        None if options.scale => {
            let (registration, scale) = scaled(pairs, &to, &from, &weights, options.method)?;
            (registration, scale, None)
        }
        None => (register(pairs, options.method)?, 1.0, None),
    };
    for (weight, inlier) in weights.iter_mut().zip(inliers.iter().flatten()) {
        *weight *= f64::from(u8::from(*inlier));
    }
    // A scale is of points in other units, which no touches are.
    if let Some(stated) = stated(rows).filter(|_| !options.scale) {
        let (errors, touches, noise, estimated) = of_touches(&registration, &weights, &stated, options);
        let used = Pairs::new(&to, &from)?.weighted(&weights)?;
        let told = told_of_touches(&registration, (&to, &from), (&weights, &errors), options);
        let times = told.map_or(1.0, |told| told.times);
        let noise = Noise {
            sigma_mm: noise.sigma_mm * times,
        };
        let by_pairs = propagated(&registration.fit, used, &errors).map(|of| of.with_own_times(times * times));
        return Ok(Solution {
            scale,
            weights,
            inliers,
            plane: registration.undecided_mirror(estimated.map_or(noise, |of| of.allowed)),
            noise,
            estimated,
            told,
            by_pairs,
            touches: Some(touches),
            registration,
        });
    }
    let (noise, estimated, told) = noise(&registration, options);
    Ok(Solution {
        scale,
        weights,
        inliers,
        plane: registration.undecided_mirror(estimated.map_or(noise, |of| of.allowed)),
        noise,
        estimated,
        told,
        by_pairs: None,
        touches: None,
        registration,
    })
}

/// What each touch states, where all do.
fn stated(rows: &[Row]) -> Option<Vec<StatedError>> {
    rows.iter().map(|row| row.error).collect()
}

/// The errors of pairs where touches state theirs: covariance and predictions are by these, as those of `calib match`. What they are
/// made of, and the root mean square.
fn of_touches(
    registration: &Registration<To, From>,
    weights: &[f64],
    stated: &[StatedError],
    options: &Options,
) -> (Vec<PairError>, TouchNoise, Noise, Option<Estimated>) {
    let used = || {
        stated
            .iter()
            .zip(weights)
            .filter(|(_, weight)| **weight > 0.0)
            .map(|(error, _)| error)
    };
    let rms = |part: &dyn Fn(&StatedError) -> Matrix3<f64>| {
        let traces = used().map(|error| part(error).trace()).sum::<f64>();
        (traces.max(0.0) / (3.0 * used().count() as f64)).sqrt()
    };
    let own_mm = rms(&StatedError::own);
    // Residuals have each touch's own error in them and not what all share: what is left of them is of the hand and of the point.
    let freedom = registration.freedom();
    let left_mm = |factor: f64| {
        let left = factor * registration.estimated_noise().sigma_mm.powi(2) - own_mm * own_mm;
        left.max(0.0).sqrt().max(options.least_noise_mm.unwrap_or(0.0))
    };
    let (rest_mm, allowed_mm) = match options.noise_mm {
        Some(given) => (given, given),
        None => (left_mm(1.0), left_mm(few_residuals_factor(freedom))),
    };
    let rest = Matrix3::identity() * (allowed_mm * allowed_mm);
    let errors: Vec<PairError> = stated
        .iter()
        .map(|error| PairError {
            own: error.own() + rest,
            shared: error.shared.unwrap_or_default(),
        })
        .collect();
    let told = stated.iter().all(|error| error.shared.is_some());
    let touches = TouchNoise {
        own_mm,
        shared_mm: told.then(|| rms(&|error| error.covariance - error.own())),
        hand_mm: rest_mm,
        bead_mm: 0.0,
    };
    let noise = |rest_mm: f64| Noise {
        sigma_mm: rms(&|error| error.covariance).hypot(rest_mm),
    };
    let estimated = options.is_estimate(allowed_mm).then(|| Estimated {
        freedom,
        allowed: noise(allowed_mm),
    });
    (errors, touches, noise(rest_mm), estimated)
}

fn point<F>([x, y, z]: [f64; 3]) -> Point<F> {
    Point::new(x, y, z)
}

/// Only ratios matter; with the largest at 1 no sum of them overflows.
fn relative_weights(rows: &[Row], weighted: bool) -> Vec<f64> {
    let largest = rows.iter().map(|row| row.weight).fold(0.0, f64::max);
    let weight = |row: &Row| if weighted { row.weight / largest } else { 1.0 };
    rows.iter().map(weight).collect()
}

/// The similarity as the rigid registration of the `From` points times its scale: its residuals, leave-one-out
/// distances and covariance hold that scale as known.
fn scaled(
    pairs: Pairs<'_, To, From>,
    to: &[Point<To>],
    from: &[Point<From>],
    weights: &[f64],
    method: Method,
) -> Result<(Registration<To, From>, f64), Refused> {
    let scale = fit_scaled(pairs, method)?.scale;
    let from: Vec<Point<From>> = from.iter().map(|p| point(p.mm().map(|x| x * scale))).collect();
    let registration = register(Pairs::new(to, &from)?.weighted(weights)?, method)?;
    Ok((registration, scale))
}

/// The noise, and what is made of it where it is estimated.
fn noise(registration: &Registration<To, From>, options: &Options) -> (Noise, Option<Estimated>, Option<Told>) {
    let Noise { sigma_mm } = registration.estimated_noise();
    // The scale is a seventh parameter that was fitted.
    let freedom = registration.freedom() - u32::from(options.scale);
    if let Some(told_mm) = options.noise_mm {
        let squares = f64::from(registration.freedom()) * (sigma_mm / told_mm).powi(2);
        let told = Told::new(squares, freedom);
        let noise = Noise {
            sigma_mm: told_mm * told.times,
        };
        return (noise, None, Some(told));
    }
    let own_mm = sigma_mm * (f64::from(registration.freedom()) / f64::from(freedom)).sqrt();
    let at_least = |sigma_mm: f64| Noise {
        sigma_mm: sigma_mm.max(options.least_noise_mm.unwrap_or(0.0)),
    };
    let allowed = at_least(own_mm * few_residuals_factor(freedom).sqrt());
    let estimated = options
        .is_estimate(allowed.sigma_mm)
        .then_some(Estimated { freedom, allowed });
    (at_least(own_mm), estimated, None)
}

/// The same of touches that state their errors, beside which a noise was told: by directions, and with what all share. Outliers have no part in it.
fn told_of_touches(
    registration: &Registration<To, From>,
    (to, from): (&[Point<To>], &[Point<From>]),
    (weights, errors): (&[f64], &[PairError]),
    options: &Options,
) -> Option<Told> {
    options.noise_mm?;
    let used: Vec<usize> = (0..weights.len()).filter(|pair| weights[*pair] > 0.0).collect();
    let to: Vec<_> = used.iter().map(|pair| to[*pair]).collect();
    let from: Vec<_> = used.iter().map(|pair| from[*pair]).collect();
    let errors: Vec<_> = used.iter().map(|pair| errors[*pair]).collect();
    let squares = chi_squared(&registration.fit, Pairs::new(&to, &from).ok()?, &errors)?;
    Some(Told::new(squares, registration.freedom()))
}

impl Options {
    /// Whether a deviation is what the residuals suggest.
    fn is_estimate(&self, sigma_mm: f64) -> bool {
        self.noise_mm.is_none() && self.least_noise_mm.is_none_or(|least| sigma_mm > least)
    }
}

impl Solution {
    /// The noise that errors are predicted for.
    fn allowed(&self) -> Noise {
        self.estimated.map_or(self.noise, |of| of.allowed)
    }

    /// Covariance of the transform; `None` where the points lie on a line to rounding.
    pub(crate) fn covariance(&self) -> Option<Matrix6<f64>> {
        self.by_pairs
            .map(|of| of.covariance)
            .or_else(|| self.registration.covariance(self.allowed()))
    }

    /// Root mean square error predicted at a point of `To`, mm.
    pub(crate) fn predicted_tre_mm(&self, target: Point<To>) -> f64 {
        match &self.by_pairs {
            Some(of) => rms_at(&of.covariance, target),
            None => self.registration.predicted_tre_mm(self.allowed(), target),
        }
    }

    /// `to_from_from` as a 4 x 4 matrix, the scale in its rotation part.
    pub(crate) fn matrix(&self) -> [[f64; 4]; 4] {
        let transform = &self.registration.fit.transform;
        let t = transform.translation_mm();
        let columns: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|axis| (*transform * geometry::Vector::<From>::new(axis[0], axis[1], axis[2])).mm());
        let row = |i: usize| {
            let entry = |j: usize| self.scale * columns[j][i];
            [entry(0), entry(1), entry(2), t[i]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }
}
