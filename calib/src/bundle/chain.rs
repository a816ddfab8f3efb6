//! A first shape: views laid on one another by the emitters they share.
//!
//! Each view is a body of a few emitters. The body with the most emitters takes up the others one by one, the one with
//! the most in common first; what remains forms bodies of its own, which are joined in the same way until nothing more
//! joins. Places are weighted means; the error of the chain stays in them (0.17 to 0.22 mm for 24 diodes at 0.1 mm of
//! noise) and is what the adjustment takes out.

use geometry::{Marker, Point, Rigid, Tracker};
use nalgebra::Vector3;

use super::Refused;
use super::views::{Data, Station, width_mm};
use crate::registration::{Method, Pairs, fit, register_robust};

/// Emitters in one set of axes, with how often each was met.
#[derive(Clone)]
pub(super) struct Body {
    pub(super) places: Vec<Option<(Vector3<f64>, f64)>>,
    /// The stations taken up, and whether mirrored.
    members: Vec<(usize, bool)>,
}

impl Body {
    fn of(index: usize, station: &Station, emitters: usize) -> Self {
        let mut places = vec![None; emitters];
        for s in &station.sightings {
            places[s.emitter] = Some((s.place, 1.0));
        }
        Self {
            places,
            members: vec![(index, false)],
        }
    }

    /// The emitters known.
    pub(super) fn emitters(&self) -> Vec<usize> {
        (0..self.places.len()).filter(|i| self.places[*i].is_some()).collect()
    }

    fn shared(&self, other: &Self) -> Vec<usize> {
        let both = |i: &usize| self.places[*i].is_some() && other.places[*i].is_some();
        (0..self.places.len()).filter(both).collect()
    }

    fn at(&self, emitters: &[usize]) -> Vec<Vector3<f64>> {
        let place = |i: &usize| self.places[*i].map(|(p, _)| p);
        emitters.iter().filter_map(place).collect()
    }

    fn mirrored(&self) -> Self {
        // A reflection in any plane will do: registration takes care of the rest.
        let turn = |p: &Option<(Vector3<f64>, f64)>| p.map(|(p, w)| (Vector3::new(-p.x, p.y, p.z), w));
        Self {
            places: self.places.iter().map(turn).collect(),
            members: self.members.iter().map(|(i, m)| (*i, !m)).collect(),
        }
    }

    /// Takes up the other body, brought into its axes; places that are too far apart keep the older value.
    fn take_up(&mut self, other: &Self, by: &Rigid<Marker, Tracker>, limit_mm: f64) {
        for (mine, theirs) in self.places.iter_mut().zip(&other.places) {
            let Some((p, w)) = theirs else { continue };
            let p = moved(by, p);
            *mine = match *mine {
                None => Some((p, *w)),
                Some((q, v)) if (p - q).norm() <= limit_mm => Some(((q * v + p * *w) / (v + w), v + w)),
                kept => kept,
            };
        }
        self.members.extend(&other.members);
    }
}

pub(super) fn moved(by: &Rigid<Marker, Tracker>, p: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from((*by * Point::new(p.x, p.y, p.z)).mm())
}

/// Why two bodies do not join.
enum Apart {
    /// Fewer than three in common, or three on a line.
    Few,
    /// Different shapes: root mean square distance, mm.
    Shape(f64),
}

/// A transform that lays `from` on `to`, and which points fit within `limit_mm`.
pub(super) struct Laid {
    pub(super) by: Rigid<Marker, Tracker>,
    pub(super) fits: Vec<bool>,
    pub(super) rms_mm: f64,
}

/// Shares of the limit at which a majority is sought, the strictest first: a loose one may take in a wrong point that
/// happens to keep its distances.
const STRICTNESS: [f64; 3] = [0.25, 0.5, 1.0];

/// Lays points on one another; where some do not fit, the largest set of at least half that does.
pub(super) fn lay(to: &[Vector3<f64>], from: &[Vector3<f64>], limit_mm: f64) -> Option<Laid> {
    let (there, here) = (points::<Marker>(to), points::<Tracker>(from));
    let pairs = Pairs::new(&there, &here).ok()?;
    let plain = plain(pairs, limit_mm)?;
    if plain.fits.iter().all(|x| *x) {
        return Some(plain);
    }
    // A majority, so that two bodies that differ are not laid on one another by chance.
    // With fewer than four, any three that keep their distances would be a majority.
    let needed = (to.len() / 2 + 1).max(4);
    let mut limits = STRICTNESS.iter().map(|s| s * limit_mm);
    let robust = limits.find_map(|l| register_robust(pairs, Method::default(), l, needed).ok());
    let fits = robust.as_ref().map_or_else(
        || vec![false; to.len()],
        |r| r.registration.fre_mm.iter().map(|x| *x <= limit_mm).collect(),
    );
    let by = robust.map_or(plain.by, |r| r.registration.fit.transform);
    Some(Laid { by, fits, ..plain })
}

/// Lays all points on one another.
fn plain(pairs: Pairs<'_, Marker, Tracker>, limit_mm: f64) -> Option<Laid> {
    let found = fit(pairs, Method::default()).ok()?;
    let both = pairs.to.iter().zip(pairs.from);
    Some(Laid {
        by: found.transform,
        fits: both.map(|(a, b)| found.residual_mm(*a, *b) <= limit_mm).collect(),
        rms_mm: found.fre_rms_mm(pairs),
    })
}

fn points<F>(list: &[Vector3<f64>]) -> Vec<Point<F>> {
    list.iter().map(|p| Point::new(p.x, p.y, p.z)).collect()
}

/// Joins bodies until nothing more joins. Views that share enough and do not fit are passed over where their sightings
/// are at most `spare`.
pub(super) fn chain(data: &Data, limit_mm: f64, spare: usize) -> Result<Body, Refused> {
    let number = |(i, s)| Body::of(i, s, data.emitters);
    let mut pool: Vec<Body> = data.stations.iter().enumerate().map(number).collect();
    loop {
        let before = pool.len();
        pool = grown(pool, data, limit_mm);
        // A body that has grown may share emitters with one that was done before it: once more, until nothing joins.
        if pool.len() <= 1 || pool.len() == before {
            break;
        }
    }
    // The body of most views is the marker; the sort is stable, so that the result does not depend on chance.
    pool.sort_by_key(|b| std::cmp::Reverse(b.members.len()));
    let first = pool.first().ok_or(Refused::Collinear {
        views: 0,
        widest_mm: 0.0,
        needed_mm: data.least_width_mm(),
    })?;
    same_hand(first, data)?;
    together(&pool, data, limit_mm, spare)?;
    Ok(first.clone())
}

/// Each body in turn takes up all that it can.
fn grown(mut pool: Vec<Body>, data: &Data, limit_mm: f64) -> Vec<Body> {
    let mut done = Vec::new();
    while !pool.is_empty() {
        // Of bodies of one size the first, so that the views' order alone decides.
        let largest = |i: &usize| (pool[*i].emitters().len(), std::cmp::Reverse(*i));
        let Some(seed) = (0..pool.len()).max_by_key(largest) else {
            break;
        };
        let mut body = pool.swap_remove(seed);
        while let Some(next) = step(&mut body, &pool, data, limit_mm) {
            pool.swap_remove(next);
        }
        done.push(body);
    }
    done
}

/// Takes up the body of the pool with the most in common, and says which.
fn step(body: &mut Body, pool: &[Body], data: &Data, limit_mm: f64) -> Option<usize> {
    let count = |other: &Body| body.shared(other).len();
    let mut order: Vec<(usize, usize)> = pool.iter().map(count).enumerate().map(|(i, n)| (n, i)).collect();
    // Fewer than three points in common leave a turn free.
    order.retain(|(n, _)| *n >= 3);
    order.sort_unstable_by(|a, b| b.cmp(a));
    let which = order.into_iter().map(|(_, i)| i);
    which
        .into_iter()
        .find(|i| join(body, &pool[*i], data, limit_mm).is_ok())
}

/// Takes up `other`, as it is, or mirrored where only that fits.
fn join(body: &mut Body, other: &Body, data: &Data, limit_mm: f64) -> Result<(), Apart> {
    let shared = body.shared(other);
    let (mine, theirs) = (body.at(&shared), other.at(&shared));
    if width_mm(&mine).min(width_mm(&theirs)) < data.least_width_mm() {
        return Err(Apart::Few);
    }
    let laid = lay(&mine, &theirs, limit_mm).ok_or(Apart::Few)?;
    if laid.fits.iter().all(|x| *x) {
        body.take_up(other, &laid.by, limit_mm);
        return Ok(());
    }
    // After the body as it is: emitters in a plane fit either way, and would else be called mirrored.
    let turned = other.mirrored();
    let (there, here) = (points(&mine), points(&turned.at(&shared)));
    let mirror = Pairs::new(&there, &here).ok().and_then(|pairs| plain(pairs, limit_mm));
    if let Some(mirror) = mirror.filter(|m| m.fits.iter().all(|x| *x)) {
        body.take_up(&turned, &mirror.by, limit_mm);
        return Ok(());
    }
    // Last what fits in part: a majority of a mirrored body may be even enough to fit as it is.
    if laid.fits.iter().any(|x| *x) {
        body.take_up(other, &laid.by, limit_mm);
        return Ok(());
    }
    Err(Apart::Shape(laid.rms_mm))
}

/// Refuses views of both hands.
fn same_hand(body: &Body, data: &Data) -> Result<(), Refused> {
    let of = |hand: bool| -> Vec<usize> {
        let same = body.members.iter().filter(|(_, mirrored)| *mirrored == hand);
        let mut views: Vec<usize> = same.map(|(i, _)| data.stations[*i].view).collect();
        views.sort_unstable();
        views
    };
    let (right, left) = (of(false), of(true));
    if right.is_empty() || left.is_empty() {
        return Ok(());
    }
    Err(Refused::Mirrored {
        views: if left.len() <= right.len() { left } else { right },
        of: body.members.len(),
    })
}

/// Refuses what keeps several bodies apart: too little in common, or different shapes of more than `spare` sightings.
fn together(pool: &[Body], data: &Data, limit_mm: f64, spare: usize) -> Result<(), Refused> {
    let (mut sightings, mut worst) = (0, None);
    for other in pool.iter().skip(1) {
        // On a copy: it is tried again only for the reason why it did not join.
        let Err(Apart::Shape(residual_mm)) = join(&mut pool[0].clone(), other, data, limit_mm) else {
            return Err(Refused::Unconnected {
                bodies: pool.iter().map(Body::emitters).collect(),
            });
        };
        let mut views: Vec<usize> = other.members.iter().map(|(i, _)| data.stations[*i].view).collect();
        views.sort_unstable();
        let count = |(i, _): &(usize, bool)| data.stations[*i].sightings.len();
        sightings += other.members.iter().map(count).sum::<usize>();
        // The first is the largest, as the bodies are in the order of their views' number.
        worst.get_or_insert(Refused::Inconsistent {
            views,
            emitters: pool[0].shared(other),
            residual_mm,
            limit_mm,
        });
    }
    match worst {
        Some(refused) if sightings > spare => Err(refused),
        _ => Ok(()),
    }
}
