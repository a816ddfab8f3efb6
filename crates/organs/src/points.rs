//! How near to one another points of an organ's surface are: near enough for what may come to be at them.

use nalgebra::Vector3;
use simulation::space::cells::Depth;

use super::labels::Labels;
use super::plan::{Contact, Plan};
use super::way::{POINTS, Way};

/// Points so far apart, in radii of the contact's ball, stand for areas whose middles are up to 1.2 times as far from one another's: of half a ball's radius where the
/// surface is stretched by 1.4.
const AT_RIGID: f64 = 0.3;
/// A label smoothed alone is inside, at a half and more, no farther from its voxels than this many standard deviations: half of a Gaussian in space is within that of its middle.
const SPREAD: f64 = 1.54;
/// Gauss points along each axis of a part where contact sets how near points are: the fewest that see how a surface lies in it.
const GAUSS: usize = 2;

/// What an organ's points are to be near enough for.
pub(crate) struct Points<'a> {
    way: &'a Way,
    last: f64,
    depth: Depth,
    labels: &'a Labels,
    rigid: Vec<Rigid>,
}

/// Something rigid that the organ may come to.
struct Rigid {
    labels: Vec<u16>,
    /// Nearer to a voxel than this at rest, mm.
    within: f64,
    ball: f64,
}

impl<'a> Points<'a> {
    /// Of an organ that the tube goes `last` far into, from the entry.
    pub(crate) fn new(organ: usize, plan: &Plan, labels: &'a Labels, way: &'a Way, last: f64) -> Self {
        let rigid = |contact: &Contact| Rigid {
            labels: plan.labels_of(&contact.with),
            within: contact.reach(way.stroke) + SPREAD * contact.smoothing + labels.spacing.max(),
            ball: contact.ball,
        };
        let own = plan.contacts.iter().filter(|contact| contact.organ == organ);
        Self {
            way,
            last,
            depth: plan.organs[organ].settings.depth,
            labels,
            rigid: own.map(rigid).collect(),
        }
    }

    /// How far from one another points of a cube's surface may be, mm, and how they are looked for: for the tube, and for what is rigid where the cube may come to it. No point
    /// of another cube does: a state in which one has gone so far is refused.
    pub(crate) fn spacing(&self, [low, high]: [&Vector3<f64>; 2]) -> Option<(f64, Depth)> {
        let at_tube = self.way.spacing([low, high], self.last);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).norm());
        let is_near = |rigid: &&Rigid| self.labels.is_near(&middle, half + rigid.within, &rigid.labels);
        let balls = self.rigid.iter().filter(is_near).map(|rigid| rigid.ball);
        let most = (high.x - low.x) / POINTS;
        let at_rigid = balls.reduce(f64::min).map(|ball| most.min(AT_RIGID * ball));
        match (at_tube, at_rigid) {
            (tube, Some(rigid)) if tube.is_none_or(|tube| rigid < tube) => {
                let points = self.depth.points.min(GAUSS);
                Some((rigid, Depth { points, ..self.depth }))
            }
            (tube, _) => tube.map(|tube| (tube, self.depth)),
        }
    }
}
