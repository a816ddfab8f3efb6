//! Every view's word on every emitter: the medians of what all views say, and who contradicts them.
//!
//! The chain trusts the view it began with. Here each view is laid on the body by the majority of its emitters, and
//! each emitter goes to the median of the places that the views give it, so that a wrong view is outvoted wherever
//! three or more views see the emitter.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::chain::{Body, Laid, lay, moved};
use super::error::Mislabelled;
use super::views::{Data, Station};

/// Rounds of laying and taking medians.
const VOTE_ROUNDS: usize = 3;

/// A sighting is at another emitter's place where it is this share of its distance from its own away, at most.
const ON_IT: f64 = 0.25;

/// The body as voted, each station laid on it, and what contradicts it.
pub(super) struct Vote {
    pub(super) places: Vec<Option<Vector3<f64>>>,
    pub(super) laid: Vec<Option<Laid>>,
    /// Emitters that carry another one's number.
    pub(super) mislabelled: Vec<Mislabelled>,
}

impl Vote {
    /// Lets the stations vote; sightings within `limit_mm` of the body agree with it.
    pub(super) fn on(body: &Body, data: &Data, limit_mm: f64) -> Self {
        let mut places: Vec<Option<Vector3<f64>>> = body.places.iter().map(|p| p.map(|(p, _)| p)).collect();
        let mut laid = Vec::new();
        for _ in 0..VOTE_ROUNDS {
            laid = data.stations.iter().map(|s| on(&places, s, limit_mm)).collect();
            places = medians(&places, data, &laid);
        }
        let mislabelled = mislabelled(&places, data, &laid, limit_mm);
        Self {
            places,
            laid,
            mislabelled,
        }
    }
}

/// A station laid on the body; `None` where no transform follows, or where the body lacks one of its emitters, so that
/// it belongs to another body.
fn on(places: &[Option<Vector3<f64>>], station: &Station, limit_mm: f64) -> Option<Laid> {
    let known = station.sightings.iter().map(|s| places[s.emitter]);
    let to: Vec<Vector3<f64>> = known.collect::<Option<_>>()?;
    let from: Vec<Vector3<f64>> = station.sightings.iter().map(|s| s.place).collect();
    lay(&to, &from, limit_mm)
}

/// Component by component, over all views that could be laid.
fn medians(old: &[Option<Vector3<f64>>], data: &Data, laid: &[Option<Laid>]) -> Vec<Option<Vector3<f64>>> {
    let mut said: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); old.len()];
    for (station, laid) in data.stations.iter().zip(laid) {
        // Where nothing fits, the transform is no better than the body's own guess, and its word would spoil the
        // medians.
        let Some(laid) = laid.as_ref().filter(|l| l.fits.iter().any(|x| *x)) else {
            continue;
        };
        for s in &station.sightings {
            said[s.emitter].push(moved(&laid.by, &s.place));
        }
    }
    said.iter().zip(old).map(|(list, old)| median(list).or(*old)).collect()
}

fn median(list: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let middle = |k: usize| {
        let mut values: Vec<f64> = list.iter().map(|p| p[k]).collect();
        values.sort_unstable_by(f64::total_cmp);
        let n = values.len();
        Some((values.get(n.checked_sub(1)? / 2)? + values.get(n / 2)?) / 2.0)
    };
    Some(Vector3::new(middle(0)?, middle(1)?, middle(2)?))
}

/// Emitters at another one's place, with the views gathered.
fn mislabelled(places: &[Option<Vector3<f64>>], data: &Data, laid: &[Option<Laid>], limit_mm: f64) -> Vec<Mislabelled> {
    // Sorted, so that the refusal names the same emitters in the same order every time.
    let mut found: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (station, laid) in data.stations.iter().zip(laid) {
        let Some(laid) = laid else { continue };
        let pairs = if laid.fits.iter().any(|x| *x) {
            neighbours(places, station, laid, limit_mm)
        } else {
            exchanged(places, station, limit_mm)
        };
        for pair in pairs {
            found.entry(pair).or_default().push(station.view);
        }
    }
    let named = found.into_iter();
    named
        .map(|((emitter, seems), views)| Mislabelled { emitter, seems, views })
        .collect()
}

/// Sightings that do not fit their own emitter but lie at another one.
fn neighbours(places: &[Option<Vector3<f64>>], station: &Station, laid: &Laid, limit_mm: f64) -> Vec<(usize, usize)> {
    let strangers = station.sightings.iter().zip(&laid.fits).filter(|(_, fits)| !**fits);
    let other = |s: &super::views::Sighting| {
        let p = moved(&laid.by, &s.place);
        // An emitter without a place is nobody's neighbour.
        let off = |m: usize| places[m].map_or(f64::INFINITY, |q| (q - p).norm());
        let nearest = (0..places.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
        // A gross error may fall near another emitter; an exchanged one falls on it.
        let near = limit_mm.min(ON_IT * off(s.emitter));
        (nearest != s.emitter && off(nearest) <= near).then_some((s.emitter, nearest))
    };
    strangers.filter_map(|(s, _)| other(s)).collect()
}

/// The two emitters whose exchange makes a view fit that has no majority: too few are seen to outvote a wrong pair.
fn exchanged(places: &[Option<Vector3<f64>>], station: &Station, limit_mm: f64) -> Vec<(usize, usize)> {
    let n = station.sightings.len();
    for i in 0..n {
        for j in i + 1..n {
            let mut swapped = station.clone();
            let (a, b) = (station.sightings[i].emitter, station.sightings[j].emitter);
            swapped.sightings[i].emitter = b;
            swapped.sightings[j].emitter = a;
            let fits = on(places, &swapped, limit_mm).is_some_and(|l| l.fits.iter().all(|x| *x));
            if fits {
                return vec![(a, b), (b, a)];
            }
        }
    }
    Vec::new()
}
