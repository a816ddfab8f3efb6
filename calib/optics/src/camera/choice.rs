//! Which sightings take part: those that are not far from where the others put them.

use super::adjust::{Problem, STEP_END, Settled};
use super::error::CameraRefused;
use super::fitted::Field;
use super::joint_adjust;
use super::plate_field::Waves;
use super::state::State;
use super::view::{Options, Ready, Station};

/// Rounds of leaving out and adjusting again.
const MAX_ROUNDS: usize = 10;
/// The most rounds of weighing anew; each takes a wrong disc's pull down by what the others have come nearer.
const ROBUST_ROUNDS: usize = 12;
/// The damping of an adjustment that begins near its end, and the last step of one whose weights change anyway, in
/// standard deviations.
const NEAR_DAMPING: f64 = 1e-7;
const ROUGH_STEP_DEVIATIONS: f64 = 0.1;
/// Deviations at which a disc counts half.
const HALF_WEIGHT_DEVIATIONS: f64 = 2.0;
/// Median of the squared length of a plane's vector of unit variance: 2 ln 2.
const MEDIAN_SQUARED_LENGTH: f64 = 1.386_294_361_119_890_6;

/// An adjustment and the sightings that took part, by view.
pub(super) struct Chosen {
    pub(super) settled: Settled,
    pub(super) kept: Vec<Vec<bool>>,
    /// The plate's field, where there is one.
    pub(super) field: Option<Field>,
}

/// Adjusts from the first of `starts` that leads anywhere, and again without the sightings beyond the gate until they
/// are the same.
pub(super) fn adjusted(stations: &[Station], starts: Vec<State>, options: &Options) -> Result<Chosen, CameraRefused> {
    let free = options.shared();
    let all = Problem { stations, free };
    let mut settled = first(&all, starts)?;
    let mut kept: Vec<Vec<bool>> = stations.iter().map(|s| vec![true; s.sightings.len()]).collect();
    if beyond(&all.squares(&settled.state), options)
        .iter()
        .flatten()
        .any(|out| *out)
    {
        settled.state = robust(&all, settled.state)?;
    }
    for _ in 0..MAX_ROUNDS {
        let next = within(&all, &settled.state, options)?;
        if next == kept {
            break;
        }
        let fewer: Vec<Station> = stations.iter().zip(&next).map(|(s, k)| s.only(k)).collect();
        settled = Problem { stations: &fewer, free }.settle_to(STEP_END, NEAR_DAMPING, settled.state)?;
        kept = next;
    }
    let field = None;
    Ok(Chosen { settled, kept, field })
}

/// Adjusts on with a field, until the sightings beyond the gate are the same.
pub(super) fn fielded(
    stations: &[Station],
    mut chosen: Chosen,
    waves: &Waves,
    options: &Options,
) -> Result<Chosen, CameraRefused> {
    let free = options.shared();
    for round in 1..=MAX_ROUNDS {
        let used: Vec<Station> = stations.iter().zip(&chosen.kept).map(|(s, k)| s.only(k)).collect();
        let (state, field) = joint_adjust::adjusted(&used, free, waves, chosen.settled.state)?;
        let used = waves.moved(&used, &field.coefficients);
        chosen.settled = Problem { stations: &used, free }.ended(state, chosen.settled.steps);
        let all = waves.moved(stations, &field.coefficients);
        let next = within(&Problem { stations: &all, free }, &chosen.settled.state, options)?;
        chosen.field = Some(field);
        // What is kept is what was adjusted to.
        if next == chosen.kept || round == MAX_ROUNDS {
            break;
        }
        chosen.kept = next;
    }
    Ok(chosen)
}

/// The state of least Cauchy's cost nearby: one disc in a wrong place draws all others off by least squares, until there
/// is no telling which of them is wrong.
fn robust(problem: &Problem<'_>, mut state: State) -> Result<State, CameraRefused> {
    for _ in 0..ROBUST_ROUNDS {
        let squares = problem.squares(&state);
        let scale = scale(&squares) * HALF_WEIGHT_DEVIATIONS * HALF_WEIGHT_DEVIATIONS;
        let weigh = |(station, squares): (&Station, &Vec<f64>)| {
            let weights: Vec<f64> = squares.iter().map(|s| 1.0 / (1.0 + s / scale)).collect();
            station.weighed(&weights)
        };
        let weighed: Vec<Station> = problem.stations.iter().zip(&squares).map(weigh).collect();
        let (stations, free) = (&weighed[..], problem.free);
        let (next, _, steps) = Problem { stations, free }.descended(ROUGH_STEP_DEVIATIONS, NEAR_DAMPING, state)?;
        state = next;
        // One step, and that of a fraction of a deviation: other weights lead to no other state.
        if steps == 1 {
            break;
        }
    }
    Ok(state)
}

/// The squared size of the residuals in units of the deviations given, by their median; at least 1.
fn scale(squares: &[Vec<f64>]) -> f64 {
    let mut sorted: Vec<f64> = squares.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    (sorted.get(sorted.len() / 2).copied().unwrap_or(0.0) / MEDIAN_SQUARED_LENGTH).max(1.0)
}

/// Whether each sighting lies beyond the gate.
fn beyond(squares: &[Vec<f64>], options: &Options) -> Vec<Vec<bool>> {
    let limit = options.gate * options.gate * scale(squares);
    // A NaN is not within.
    let within = |square: f64| square <= limit;
    let out = |squares: &Vec<f64>| squares.iter().map(|s| !within(*s)).collect();
    squares.iter().map(out).collect()
}

/// The best of the first two that settle: a start on the wrong side of a valley may end in another one. The second goes no
/// further than it takes to tell whether its valley is deeper.
fn first(problem: &Problem<'_>, starts: Vec<State>) -> Result<Settled, CameraRefused> {
    let mut refused = CameraRefused::NoConvergence {
        steps: 0,
        last: f64::INFINITY,
    };
    let mut starts = starts.into_iter();
    let first = starts.by_ref().find_map(|start| match problem.settle(start) {
        Ok(found) => Some(found),
        Err(error) => {
            refused = error;
            None
        }
    });
    let Some(best) = first else { return Err(refused) };
    let second = starts.find_map(|start| problem.descended(ROUGH_STEP_DEVIATIONS, 1e-3, start).ok());
    match second {
        // So near its end a valley has some hundredths of chi square left.
        Some((state, cost, _)) if cost < best.cost - 1.0 => problem.settle_to(STEP_END, NEAR_DAMPING, state),
        _ => Ok(best),
    }
}

/// The sightings within the gate; refused where too many are not.
fn within(problem: &Problem<'_>, state: &State, options: &Options) -> Result<Vec<Vec<bool>>, CameraRefused> {
    let squares = problem.squares(state);
    let kept: Vec<Vec<bool>> = beyond(&squares, options)
        .iter()
        .map(|v| v.iter().map(|out| !out).collect())
        .collect();
    let discs = kept.iter().map(Vec::len).sum::<usize>();
    let rejected = kept.iter().flatten().filter(|k| !**k).count();
    let allowed = (options.most_rejected * discs as f64).floor() as usize;
    // More than this share is no longer a few wrong discs: the model, the gate or the grid is another one.
    if rejected <= allowed {
        return Ok(kept);
    }
    // In pixels, for people: a standard length by the disc's own information, once along each axis.
    let far = |s: &Ready| -> f64 { s.information.trace().max(f64::MIN_POSITIVE).recip().sqrt() };
    let each = squares.iter().zip(problem.stations).enumerate();
    let lengths = each.flat_map(|(view, (squares, station))| {
        let both = squares.iter().zip(&station.sightings);
        // Of equal deviations along both axes the information's trace is 2 / sigma^2: the root of 2 makes that sigma.
        both.map(move |(square, s)| (view, s.disc, square.sqrt() * far(s) * std::f64::consts::SQRT_2))
    });
    let (view, disc, worst_px) = lengths.max_by(|a, b| a.2.total_cmp(&b.2)).unwrap_or_default();
    Err(CameraRefused::Outliers {
        rejected,
        discs,
        gate: options.gate,
        allowed,
        view,
        disc,
        worst_px,
    })
}
