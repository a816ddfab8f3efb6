//! From samples to the figures of the report.

use std::collections::BTreeMap;

use ::fit::quantile;
use geometry::{Point, Tracker};
use nalgebra::Vector3;

use super::{Phantom, Refused, Sample, Test};
use crate::registration::{Method, Pairs, fit};

/// A divot further from its place after registration is no error of measurement, mm.
const MOST_OFF_MM: f64 = 20.0;

/// How samples of one point scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Samples.
    pub count: usize,
    /// Distance of their mean from the divot by the phantom's registration, mm; `None` without one.
    pub bias_mm: Option<f64>,
    /// Root mean square distance from the mean, mm: divides by the samples less 1.
    pub precision_mm: f64,
    /// The 95th percentile of the distances from the mean, mm.
    pub p95_mm: f64,
    /// The largest, mm.
    pub max_mm: f64,
    /// The least and the largest turn, rad.
    pub range_rad: [f64; 2],
}

/// Errors of distances between divots, measured less known, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distances {
    /// Pairs of divots, over all rounds.
    pub count: usize,
    /// Their mean.
    pub bias_mm: f64,
    /// Their standard deviation.
    pub precision_mm: f64,
    /// The 95th percentile of their absolute values.
    pub p95_mm: f64,
    /// The largest absolute value.
    pub max_mm: f64,
}

/// The figures of one place of the working volume.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceReport {
    /// Its number.
    pub place: usize,
    /// [`Test::Single`].
    pub single: Option<Scatter>,
    /// [`Test::TURNS`].
    pub turns: [Option<Scatter>; 3],
    /// [`Test::Distance`].
    pub distances: Option<Distances>,
    /// Root mean square distance of the divots' means from the registered phantom, mm.
    pub registration_rms_mm: Option<f64>,
}

/// The figures of every place, and of all distances together.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// By number.
    pub places: Vec<PlaceReport>,
    /// The largest distance of a single-point sample from its mean over all places, mm.
    pub single_max_mm: Option<f64>,
    /// The same of all turns about the tip.
    pub turn_max_mm: Option<f64>,
    /// Of all places.
    pub distances: Option<Distances>,
}

/// Makes the report of samples on a phantom whose divots are drawn at `phantom`.
///
/// In [`Test::Distance`] the first sample of each divot at a place is the first round, the second the second.
///
/// # Errors
/// [`Refused`].
pub fn measure(phantom: &[Point<Phantom>], samples: &[Sample]) -> Result<Report, Refused> {
    check(phantom, samples)?;
    // Sorted by number, so that the report does not depend on the order of the samples.
    let mut by_place: BTreeMap<usize, Vec<Sample>> = BTreeMap::new();
    for s in samples {
        by_place.entry(s.place).or_default().push(*s);
    }
    let (mut places, mut errors) = (Vec::new(), Vec::new());
    for (place, here) in &by_place {
        let (report, found) = at_place(*place, phantom, here)?;
        places.push(report);
        errors.extend(found);
    }
    let largest = |of: &dyn Fn(&PlaceReport) -> Vec<f64>| places.iter().flat_map(of).reduce(f64::max);
    Ok(Report {
        single_max_mm: largest(&|p| p.single.iter().map(|s| s.max_mm).collect()),
        turn_max_mm: largest(&|p| p.turns.iter().flatten().map(|s| s.max_mm).collect()),
        distances: distances(&errors),
        places,
    })
}

fn check(phantom: &[Point<Phantom>], samples: &[Sample]) -> Result<(), Refused> {
    if samples.is_empty() {
        return Err(Refused::None);
    }
    for (sample, s) in samples.iter().enumerate() {
        let (found, divot, divots) = (s.at.mm(), s.divot, phantom.len());
        if !found.iter().all(|x| x.is_finite()) {
            return Err(Refused::NotFinite { sample, found });
        }
        if divot >= divots {
            return Err(Refused::NoSuchDivot { sample, divot, divots });
        }
    }
    Ok(())
}

fn at_place(place: usize, phantom: &[Point<Phantom>], samples: &[Sample]) -> Result<(PlaceReport, Vec<f64>), Refused> {
    let rounds = rounds(phantom.len(), samples);
    let laid = laid(place, phantom, &rounds)?;
    let scatter = |test| scatter(place, test, samples, laid.as_ref().map(|(l, _)| l.as_slice()));
    let [roll, pitch, yaw] = Test::TURNS.map(scatter);
    let errors = errors(phantom, &rounds);
    let report = PlaceReport {
        place,
        single: scatter(Test::Single)?,
        turns: [roll?, pitch?, yaw?],
        distances: distances(&errors),
        registration_rms_mm: laid.map(|(_, rms)| rms),
    };
    Ok((report, errors))
}

/// The divots as registered to a place, and what the registration left, mm.
type Laid = (Vec<Point<Tracker>>, f64);

/// The divots of a round with their samples.
type Rounds = Vec<Vec<(usize, Point<Tracker>)>>;

/// The samples of the distance test by round.
fn rounds(divots: usize, samples: &[Sample]) -> Rounds {
    let mut rounds: Rounds = Vec::new();
    let mut next = vec![0; divots];
    for s in samples.iter().filter(|s| s.test == Test::Distance) {
        // Each divot counts for itself, so that the order of touching within a round is free.
        let round = next[s.divot];
        next[s.divot] += 1;
        if round == rounds.len() {
            rounds.push(Vec::new());
        }
        rounds[round].push((s.divot, s.at));
    }
    rounds
}

/// The phantom's divots registered to a place by the means of those measured, and what that left, mm; `None` for fewer than
/// three.
fn laid(place: usize, phantom: &[Point<Phantom>], rounds: &Rounds) -> Result<Option<Laid>, Refused> {
    let mut by_divot: BTreeMap<usize, Vec<Point<Tracker>>> = BTreeMap::new();
    for (divot, at) in rounds.iter().flatten() {
        by_divot.entry(*divot).or_default().push(*at);
    }
    // One point for each divot, the mean: a divot touched more often must not weigh more.
    let known: Vec<(usize, Point<Tracker>)> = by_divot.iter().map(|(d, list)| (*d, centre(list))).collect();
    if known.len() < 3 {
        return Ok(None);
    }
    let to: Vec<Point<Tracker>> = known.iter().map(|(_, p)| *p).collect();
    let from: Vec<Point<Phantom>> = known.iter().map(|(d, _)| phantom[*d]).collect();
    let failed = |source| Refused::NoRegistration { place, source };
    let pairs = Pairs::new(&to, &from).map_err(failed)?;
    let found = fit(pairs, Method::default()).map_err(failed)?;
    let off = |i: &usize| found.residual_mm(to[*i], from[*i]);
    let worst = (0..to.len()).max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
    // Farther off than any localizer is wrong: a divot was mistaken, or the phantom moved.
    if off(&worst) > MOST_OFF_MM {
        return Err(Refused::OffPhantom {
            place,
            divot: known[worst].0,
            found_mm: off(&worst),
            allowed_mm: MOST_OFF_MM,
        });
    }
    let all = phantom.iter().map(|p| found.transform * *p).collect();
    Ok(Some((all, found.fre_rms_mm(pairs))))
}

fn centre(points: &[Point<Tracker>]) -> Point<Tracker> {
    let sum: Vector3<f64> = points.iter().map(|p| Vector3::from(p.mm())).sum();
    let [x, y, z] = (sum / points.len() as f64).into();
    Point::new(x, y, z)
}

fn scatter(
    place: usize,
    test: Test,
    samples: &[Sample],
    laid: Option<&[Point<Tracker>]>,
) -> Result<Option<Scatter>, Refused> {
    let list: Vec<&Sample> = samples.iter().filter(|s| s.test == test).collect();
    let Some(first) = list.first().map(|s| s.divot) else {
        return Ok(None);
    };
    // The standard turns the pointer in one divot: the scatter of two would be their distance.
    if let Some(second) = list.iter().map(|s| s.divot).find(|d| *d != first) {
        return Err(Refused::SeveralDivots {
            place,
            test,
            first,
            second,
        });
    }
    let places: Vec<Point<Tracker>> = list.iter().map(|s| s.at).collect();
    let mean = centre(&places);
    let off: Vec<f64> = places.iter().map(|p| p.distance(mean)).collect();
    let squares: f64 = off.iter().map(|x| x * x).sum();
    let angles = list.iter().map(|s| s.angle_rad);
    Ok(Some(Scatter {
        count: off.len(),
        bias_mm: laid.map(|laid| laid[first].distance(mean)),
        // Of a single sample there is no scatter: 0 over 1, not 0 over 0.
        precision_mm: (squares / (off.len() as f64 - 1.0).max(1.0)).sqrt(),
        p95_mm: quantile(off.clone(), 0.95),
        max_mm: off.iter().copied().fold(0.0, f64::max),
        range_rad: [
            angles.clone().fold(f64::INFINITY, f64::min),
            angles.fold(f64::NEG_INFINITY, f64::max),
        ],
    }))
}

/// Measured less known distance of every pair of divots in every round, mm.
fn errors(phantom: &[Point<Phantom>], rounds: &Rounds) -> Vec<f64> {
    let mut list = Vec::new();
    for round in rounds {
        for (i, (d, a)) in round.iter().enumerate() {
            for (e, b) in &round[i + 1..] {
                list.push(a.distance(*b) - phantom[*d].distance(phantom[*e]));
            }
        }
    }
    list
}

fn distances(errors: &[f64]) -> Option<Distances> {
    let count = errors.len();
    let mean = errors.iter().sum::<f64>() / count as f64;
    let squares: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
    let sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    // Without distances the mean is NaN, and is not told.
    (count > 0).then(|| Distances {
        count,
        bias_mm: mean,
        precision_mm: (squares / (count as f64 - 1.0).max(1.0)).sqrt(),
        p95_mm: quantile(sizes.clone(), 0.95),
        max_mm: sizes.iter().copied().fold(0.0, f64::max),
    })
}
