//! Why a marker was not calibrated.

use std::fmt;

/// An emitter that lies where another one belongs, in the views named. Indices count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mislabelled {
    /// The number it was given.
    pub emitter: usize,
    /// The emitter whose place it takes.
    pub seems: usize,
    /// The views in which it does; empty where a whole marker is compared with its drawing.
    pub views: Vec<usize>,
}

impl fmt::Display for Mislabelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "emitter {} is at the place of emitter {}", self.emitter, self.seems)?;
        if self.views.is_empty() {
            return Ok(());
        }
        write!(f, " in {} views ({})", self.views.len(), Listed(&self.views))
    }
}

/// The first few of a list.
struct Listed<'a, T>(&'a [T]);

/// More than these are not printed.
const MAX_SHOWN: usize = 12;

impl<T: fmt::Display> fmt::Display for Listed<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<String> = self.0.iter().take(MAX_SHOWN).map(T::to_string).collect();
        let more = if self.0.len() > MAX_SHOWN { ", ..." } else { "" };
        write!(f, "{}{more}", shown.join(", "))
    }
}

/// Groups of emitters, each in brackets.
fn groups(bodies: &[Vec<usize>]) -> String {
    let one = |body: &Vec<usize>| format!("[{}]", Listed(body));
    bodies.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// Emitters with the views that see them.
fn seldom(list: &[(usize, usize)]) -> String {
    let one = |(emitter, views): &(usize, usize)| format!("{emitter} ({views})");
    Listed(&list.iter().map(one).collect::<Vec<_>>()).to_string()
}

fn mislabels(list: &[Mislabelled]) -> String {
    let one: Vec<String> = list.iter().take(MAX_SHOWN).map(Mislabelled::to_string).collect();
    one.join("; ")
}

/// Why the views were refused. Views and emitters count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The marker has no such emitter.
    #[error("view {view} sees emitter {emitter}, but the marker has {emitters}, counted from 0")]
    NoSuchEmitter {
        /// The view.
        view: usize,
        /// The emitter seen.
        emitter: usize,
        /// How many the marker has.
        emitters: usize,
    },
    /// A view lists an emitter twice.
    #[error("view {view} sees emitter {emitter} twice")]
    Twice {
        /// The view.
        view: usize,
        /// The emitter.
        emitter: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("view {view}, emitter {emitter}: {found:?} holds a number that is not finite")]
    NotFinite {
        /// The view.
        view: usize,
        /// The emitter.
        emitter: usize,
        /// The place found, mm.
        found: [f64; 3],
    },
    /// The noise of a sighting is not a covariance or not a deviation above zero.
    #[error("view {view}, emitter {emitter}: the noise is not symmetric positive definite")]
    BadNoise {
        /// The view.
        view: usize,
        /// The emitter.
        emitter: usize,
    },
    /// There is not one covariance per sighting.
    #[error("view {view} has {found} covariances for {sightings} sightings")]
    Unmatched {
        /// The first such view.
        view: usize,
        /// Covariances given.
        found: usize,
        /// Sightings.
        sightings: usize,
    },
    /// No view sees three emitters off a line.
    #[error(
        "none of {views} views sees three emitters off a line: the widest is {widest_mm:.3e} mm across its line, \
         {needed_mm:.3e} mm are needed"
    )]
    Collinear {
        /// How many views came.
        views: usize,
        /// Root mean square distance of the emitters from their line, in the best view, mm.
        widest_mm: f64,
        /// The least that gives a pose, mm.
        needed_mm: f64,
    },
    /// Some emitters are not seen often enough.
    #[error("emitters seen in fewer than {needed} views that give a pose: {} (views in brackets)", seldom(.emitters))]
    Seldom {
        /// The emitters, each with the number of views.
        emitters: Vec<(usize, usize)>,
        /// The least number of views.
        needed: usize,
    },
    /// The views fall into groups that share fewer than three emitters, or three on a line.
    #[error(
        "the views do not hang together: {} groups of emitters, each two with fewer than three off a line in common: {}",
        .bodies.len(), groups(.bodies)
    )]
    Unconnected {
        /// The emitters of each group, the largest first.
        bodies: Vec<Vec<usize>>,
    },
    /// Views that share enough emitters show bodies of different shape.
    #[error(
        "views {} show emitters {} in another shape than the others, {residual_mm:.3} mm apart where {limit_mm:.3} mm \
         are allowed",
        Listed(.views), Listed(.emitters)
    )]
    Inconsistent {
        /// The views.
        views: Vec<usize>,
        /// The emitters that both share.
        emitters: Vec<usize>,
        /// Root mean square distance after registration, mm.
        residual_mm: f64,
        /// The largest allowed, mm.
        limit_mm: f64,
    },
    /// Emitters carry one another's numbers.
    #[error("wrong numbers: {}", mislabels(.0))]
    Mislabelled(Vec<Mislabelled>),
    /// Some views show the mirror image of the others.
    #[error(
        "{} of {of} views show the mirror image of the others ({}): an axis is turned round, or two emitters of an even \
         body are exchanged",
        .views.len(), Listed(.views)
    )]
    Mirrored {
        /// The lesser group.
        views: Vec<usize>,
        /// All views used.
        of: usize,
    },
    /// The marker is the mirror image of its drawing.
    #[error(
        "the marker is the mirror image of its drawing: {residual_mm:.3} mm apart as it is, {mirrored_mm:.3} mm mirrored"
    )]
    MirroredDesign {
        /// Root mean square distance to the drawing, mm.
        residual_mm: f64,
        /// The same of the mirror image, mm.
        mirrored_mm: f64,
    },
    /// The marker does not have the shape of its drawing.
    #[error("emitter {emitter} is {found_mm:.3} mm from its place in the drawing; {limit_mm:.3} mm are allowed")]
    OffDesign {
        /// The worst emitter.
        emitter: usize,
        /// Its distance, mm.
        found_mm: f64,
        /// The largest allowed, mm.
        limit_mm: f64,
    },
    /// The drawing and the emitters seen have fewer than three in common, or three on a line.
    #[error("the drawing cannot be laid on the marker: {0}")]
    NoDesign(crate::registration::Refused),
    /// Sightings too far from the others to be noise, where none may be left out, or too many.
    #[error(
        "{rejected} of {sightings} sightings lie more than {gate} deviations off; {allowed} may be left out. The worst: \
         view {view}, emitter {emitter}, {worst_mm:.3} mm"
    )]
    Outliers {
        /// Sightings that were left out.
        rejected: usize,
        /// All sightings in views that give a pose.
        sightings: usize,
        /// How many may be left out.
        allowed: usize,
        /// The gate, standard deviations.
        gate: f64,
        /// The view of the worst.
        view: usize,
        /// The emitter of the worst.
        emitter: usize,
        /// Its distance, mm.
        worst_mm: f64,
    },
    /// Two emitters at one place.
    #[error(
        "emitters {first} and {second} are {distance_mm:.3} mm apart, and at least {least_mm:.3} mm are needed to tell their sightings apart: one of \
         them carries the other's number, at least in many views"
    )]
    OnePlace {
        /// The first.
        first: usize,
        /// The second.
        second: usize,
        /// Their distance, mm.
        distance_mm: f64,
        /// The least, mm.
        least_mm: f64,
    },
    /// So many sightings of an emitter were left out that the others may be the wrong ones.
    #[error(
        "{rejected} of {sightings} sightings of emitter {emitter} lie off the place that the others give it, and at most a third may: it moved, or \
         carried another one's number"
    )]
    Torn {
        /// The emitter.
        emitter: usize,
        /// Its sightings that were left out.
        rejected: usize,
        /// All of its sightings in views that give a pose.
        sightings: usize,
    },
    /// An emitter can move almost freely.
    #[error("the views hardly hold emitter {emitter}: condition {condition:.3e}, at most {allowed:.1e} is allowed")]
    Weak {
        /// The emitter that moves most.
        emitter: usize,
        /// Ratio of the largest deviation to the least.
        condition: f64,
        /// The largest allowed.
        allowed: f64,
    },
    /// The iteration did not settle.
    #[error("no convergence after {steps} steps (last step {last_mm:e} mm)")]
    NoConvergence {
        /// The steps made.
        steps: usize,
        /// Root mean square length of the last step, mm.
        last_mm: f64,
    },
}
