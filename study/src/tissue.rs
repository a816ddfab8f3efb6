//! Organs that the tube moves on its way, as they truly are and as the navigation's model has them.
//!
//! The true organs are the scene's with other numbers: each number with a standard deviation is drawn from it, and the tube's true poses push them. The model
//! has the scene's own numbers and is pushed by the poses that the chain makes. Both have the same meshes, so that nothing here says
//! anything of the error of a mesh, of a law or of what holds an organ where.

use bus::message::{TissueHeader, TissueState};
use chance::Chance;
use geometry::{Ct, Point, Vector};
use nalgebra::{Matrix3, Vector3};
use tissue_proc::offline::{Anatomist, Organs};

use crate::Words;
use crate::approach::Shot;
use crate::plan::Tissue;

/// Number of the tissue's numbers among what is drawn of an operation.
const NUMBERS: u64 = 21;
/// Draws beyond so many deviations are made anew: a ratio of Poisson above one half is no tissue.
const MOST_DEVIATIONS: f64 = 2.5;
/// Draws for one number at most; each is beyond [`MOST_DEVIATIONS`] one time in eighty.
const MOST_DRAWS: u64 = 20;
/// The half axis of the ellipsoid that holds 95 of 100, in deviations: root of the quantile of chi squared with three degrees of freedom.
const OF_95: f64 = 2.795_483;

/// What the tube did to organs on one way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pushed {
    /// How far it truly has moved the place that is told, and the one that was aimed at, which stays where it is outside organs. `None` where the
    /// true organs did not settle: then nobody knows.
    pub(crate) truly: Option<[Vector<Ct>; 2]>,
    /// Where the model has the told place beside where it truly is; `None` where it has no state.
    pub(crate) model: Option<Modelled>,
    /// What an image would have said: of the true organs where they did not settle, else of the model.
    pub(crate) word: String,
}

/// What the model says of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Modelled {
    /// From the true place to that of the model.
    pub(crate) off: Vector<Ct>,
    /// The longest half axis of the ellipsoid that holds 95 of 100 by the model's own covariance, mm, and the error normalised by it; `None`
    /// where images say ERROR UNKNOWN.
    pub(crate) stated: Option<[f64; 2]>,
}

/// Meshes the organs of a scene.
///
/// # Errors
/// As `tissue-proc` at its start.
pub(crate) fn meshed(tissue: &Tissue) -> Result<Anatomist, Words> {
    let scene = &tissue.scene;
    let examination = volume_loader::open(&scene.volume, scene.seed)?;
    Anatomist::new(scene, examination.grid(), volume_loader::load_labels_seeded)
}

/// Follows the frames of an approach, the true organs by the true poses and the model by those that the chain made; `seed` is the
/// operation's.
///
/// # Errors
/// In words: numbers that make no organ.
pub(crate) fn pushed(tissue: &Tissue, anatomist: &Anatomist, shots: &[Shot], seed: u64) -> Result<Pushed, Words> {
    let mut truth = anatomist.others(&drawn(seed, anatomist.uncertain()))?;
    let mut model = anatomist.organs()?;
    if model.moved(tissue.told.centre).is_none() {
        // Nobody knows how far the tube moves what is no organ: not by 0 mm.
        return Err(format!(
            "tissue.told: target {:?} lies in no organ of the scene",
            tissue.told.name
        )
        .into());
    }
    let (mut next_ns, step_ns) = (i64::MIN, (1e9 / tissue.rate_hz) as i64);
    let mut last = (TissueHeader::default(), None);
    for (number, shot) in (1..).zip(shots) {
        let t_ns = shot.frame.t_capture_ns;
        // What stands at the end counts: the last frame is always among them.
        if t_ns < next_ns && number < shots.len() {
            continue;
        }
        next_ns = t_ns.saturating_add(step_ns);
        let found = shot.found.as_ref().ok();
        last = (
            truth.pose(t_ns, shot.frame.ct_from_tool),
            found.map(|found| model.pose(t_ns, found.ct_from_tool.transform())),
        );
    }
    Ok(told((&truth, &model), &last, tissue))
}

/// How many standard deviations each number of the true organs is above the scene's.
fn drawn(seed: u64, count: usize) -> Vec<f64> {
    let chance = Chance::new(seed, NUMBERS);
    let one = |number: u64| {
        let draws = (0..MOST_DRAWS).map(|k| chance.normal(number * MOST_DRAWS + k));
        draws.into_iter().find(|draw| draw.abs() <= MOST_DEVIATIONS)
    };
    (0..count as u64).map(|number| one(number).unwrap_or(0.0)).collect()
}

fn told(
    (truth, model): (&Organs, &Organs),
    (truly, shown): &(TissueHeader, Option<TissueHeader>),
    tissue: &Tissue,
) -> Pushed {
    let most = tissue.scene.tissue.as_ref().map_or(0.0, |spec| spec.tolerance);
    let state = |header: Option<&TissueHeader>| state(header, most);
    if state(Some(truly)) != TissueState::Settled {
        return Pushed {
            truly: None,
            model: None,
            word: format!("truth {}", words(state(Some(truly)), Some(truly))),
        };
    }
    let none = || Vector::new(0.0, 0.0, 0.0);
    let truly = [tissue.told.centre, tissue.aimed.centre].map(|place| truth.moved(place).unwrap_or_else(none));
    let has_state = matches!(state(shown.as_ref()), TissueState::Settled | TissueState::Approximate);
    let place = model.moved(tissue.told.centre).filter(|_| has_state);
    Pushed {
        truly: Some(truly),
        model: place.map(|place| Modelled {
            off: place - truly[0],
            stated: shown.and_then(|shown| stated(&shown, tissue.told.centre, place - truly[0])),
        }),
        word: words(state(shown.as_ref()), shown.as_ref()),
    }
}

/// The model's own 95 of 100 of a place, as an image draws it, and its error normalised.
fn stated(shown: &TissueHeader, place: Point<Ct>, off: Vector<Ct>) -> Option<[f64; 2]> {
    let (covariance, _) = shown.error_of(place.mm())?;
    let covariance = Matrix3::from_fn(|row, column| covariance[row][column]);
    let longest = covariance.symmetric_eigenvalues().max().max(0.0).sqrt();
    let off = Vector3::from(off.mm());
    let nees = covariance.cholesky().map(|factor| off.dot(&factor.solve(&off)));
    // An organ at rest has no error by any number: where it is truly at rest nothing is off.
    Some([
        OF_95 * longest,
        nees.unwrap_or(if off.norm() == 0.0 { 0.0 } else { f64::INFINITY }),
    ])
}

/// What an image takes it for, which holds it against the scene's tolerance. A frame of which the chain made no pose has no state.
fn state(header: Option<&TissueHeader>, tolerance: f64) -> TissueState {
    header.map_or(TissueState::Lost, |header| {
        header.certified(tolerance).unwrap_or(TissueState::Refused)
    })
}

fn words(state: TissueState, header: Option<&TissueHeader>) -> String {
    let word = match state {
        TissueState::Settled => "settled",
        TissueState::Approximate => "not settled",
        TissueState::CatchingUp => "catching up",
        TissueState::Refused => "refused",
        TissueState::Lost => "no pose",
    };
    match header.map(TissueHeader::why).filter(|why| !why.is_empty()) {
        Some(why) => format!("{word}: {why}"),
        None => word.to_owned(),
    }
}
