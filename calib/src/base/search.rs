//! Which group of touches lies on which feature, and the place of the base that follows.

use geometry::motion::Pose;
use geometry::rotation::{Rotation, RotationMatrix};
use nalgebra::{Matrix3, Vector3};

use super::consensus::{Flat, line, plane};
use super::solve::{HeldTouch, Hold, normal, settle, shift};
use super::touches::widest;
use super::{Drawing, Feature, Options};

/// Rounds of fitting and choosing.
const MAX_ROUNDS: usize = 20;
/// The plane's touches must spread this many gates across their line.
const LEAST_WIDTH: f64 = 2.0;

/// The groups about the mean of all touches, with the line and the plane that each lies on.
pub(super) struct Touched {
    pub(super) groups: Vec<Vec<Vector3<f64>>>,
    lines: Vec<Option<Flat>>,
    planes: Vec<Option<Flat>>,
    /// By group and touch.
    pub(super) noise: Noise,
    /// The gate of the widest noise, mm: what lies within it may be on a line or a plane.
    limit: f64,
    pub(super) radius: f64,
}

/// Covariances in units of the noise given, by group and touch; `None` for that noise.
pub(super) type Noise = Vec<Vec<Option<Matrix3<f64>>>>;

/// A place of the base for one assignment.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) assignment: Vec<Feature>,
    pub(super) pose: Pose,
    /// By group and touch.
    pub(super) kept: Vec<Vec<bool>>,
    /// Squared distances over the noise given, each up to the gate.
    pub(super) chi_squared: f64,
    /// The root of chi-square of the touches kept over its degrees of freedom.
    pub(super) noise_ratio: f64,
}

impl Found {
    /// Touches left out.
    pub(super) fn rejected(&self) -> usize {
        self.kept.iter().flatten().filter(|k| !**k).count()
    }
}

impl Touched {
    /// Looks for the lines and planes that the labels allow; `gate` is that of the noise given, mm.
    pub(super) fn new(groups: Vec<Vec<Vector3<f64>>>, noise: Noise, labels: &[Option<Feature>], gate: f64) -> Self {
        let limit = gate * widest(&noise);
        let all: Vec<&Vector3<f64>> = groups.iter().flatten().collect();
        let square = all.iter().map(|p| p.norm_squared()).sum::<f64>() / all.len().max(1) as f64;
        let may = |label: &Option<Feature>, plane: bool| label.is_none_or(|f| (f == Feature::Plane) == plane);
        let both = || groups.iter().zip(labels);
        let lines = both().map(|(g, l)| may(l, false).then(|| line(g, limit)).flatten());
        let planes = both().map(|(g, l)| may(l, true).then(|| plane(g, limit)).flatten());
        Self {
            lines: lines.collect(),
            planes: planes.collect(),
            radius: square.sqrt(),
            groups,
            noise,
            limit,
        }
    }

    /// The line or the plane of a group as the feature, where enough touches lie on it.
    fn flat(&self, group: usize, feature: Feature) -> Option<&Flat> {
        let flat = match feature {
            Feature::Plane => self.planes[group]
                .as_ref()
                .filter(|f| f.width_mm >= LEAST_WIDTH * self.limit),
            Feature::Groove(_) => self.lines[group].as_ref(),
        }?;
        // A majority of the group, so that a group of touches on another feature is not laid on a few that line up.
        (flat.count() >= feature.needed() && 2 * flat.count() > flat.on.len()).then_some(flat)
    }

    /// Every touch with what holds it under an assignment.
    pub(super) fn held(&self, assignment: &[Feature], holds: &[Hold; 4]) -> Vec<Vec<HeldTouch>> {
        let group = |(g, f): (usize, &Feature)| {
            let both = self.groups[g].iter().zip(&self.noise[g]);
            let hold = holds[f.index()];
            let one = |(place, noise): (&Vector3<f64>, &Option<Matrix3<f64>>)| HeldTouch {
                place: *place,
                hold,
                noise: *noise,
            };
            both.map(one).collect()
        };
        assignment.iter().enumerate().map(group).collect()
    }

    /// All assignments of the groups to features that keep the labels and use every feature.
    pub(super) fn assignments(&self, labels: &[Option<Feature>]) -> Vec<Vec<Feature>> {
        let mut all = vec![Vec::new()];
        for (group, label) in labels.iter().enumerate() {
            let able = |f: &Feature| label.is_none_or(|l| l == *f) && self.flat(group, *f).is_some();
            let features: Vec<Feature> = Feature::ALL.into_iter().filter(able).collect();
            let longer = |a: &Vec<Feature>| {
                let add = |f: &Feature| a.iter().copied().chain([*f]).collect::<Vec<_>>();
                features.iter().map(add).collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        // Without one of the features a motion of the base is free.
        all.retain(|a| Feature::ALL.iter().all(|f| a.contains(f)));
        all
    }

    /// All places of the base for an assignment: the plane's normal and a groove's line leave four rotations.
    pub(super) fn places(&self, assignment: &[Feature], drawing: &Drawing, options: &Options) -> Vec<Found> {
        let holds = Feature::ALL.map(|f| drawing.hold(f, options.tip_radius_mm));
        let touches = self.held(assignment, &holds);
        let starts = self.starts(assignment, &holds);
        let place = |turn: &Rotation| self.place(assignment, &touches, *turn, options);
        starts.iter().filter_map(place).collect()
    }

    /// Rotations that lay the drawn normal and the line of a groove on those touched, either way round.
    fn starts(&self, assignment: &[Feature], holds: &[Hold; 4]) -> Vec<Rotation> {
        let of = |wanted: Feature| {
            let group = assignment.iter().position(|f| *f == wanted)?;
            self.flat(group, wanted).map(|f| f.axis)
        };
        let Some(normal) = of(Feature::Plane) else {
            return Vec::new();
        };
        // Touched from end to end, the longest groove has the best known direction.
        let longest = Feature::ALL[1..].iter().max_by(|a, b| {
            let length = |f: &Feature| holds[f.index()].along.map_or(0.0, |(_, l)| l);
            length(a).total_cmp(&length(b))
        });
        let Some((groove, along)) = longest.and_then(|g| Some((g, of(*g)?))) else {
            return Vec::new();
        };
        let Some((drawn, _)) = holds[groove.index()].along else {
            return Vec::new();
        };
        // A fitted normal and a fitted line have no sign. `aligned` makes proper rotations only, so that these four are
        // all.
        let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let start = |(a, b)| aligned([holds[0].axes[0], drawn], [normal * a, along * b]);
        signs.into_iter().filter_map(start).collect()
    }

    /// Fits from a rotation, keeps what lies within the gate, and fits again until nothing changes.
    fn place(
        &self,
        assignment: &[Feature],
        touches: &[Vec<HeldTouch>],
        turn: Rotation,
        options: &Options,
    ) -> Option<Found> {
        let limit = options.limit_mm();
        let on = |(g, f): (usize, &Feature)| self.flat(g, *f).map(|f| f.on.clone());
        let mut kept: Vec<Vec<bool>> = assignment.iter().enumerate().map(on).collect::<Option<_>>()?;
        // What lies on the group's own line or plane, which needs no pose: gross errors take no part in the first fit.
        let first = chosen(touches, &kept);
        let mut pose = Pose {
            turn,
            shift: shift(&first, turn),
        };
        // Which touches lie within the gate depends on the pose, and the pose on them: until both agree.
        for round in 1.. {
            pose = settle(&chosen(touches, &kept), pose, self.radius)?;
            let next: Vec<Vec<bool>> = touches
                .iter()
                .map(|g| g.iter().map(|t| t.counted(&pose) <= limit).collect())
                .collect();
            enough(assignment, &next)?;
            // A touch at the gate may come and go for ever. Then the pose of the last round stands with what it was fitted to.
            if next == kept || round == MAX_ROUNDS {
                break;
            }
            kept = next;
        }
        // The weights of the pose at the end itself, not those frozen before its last steps.
        let last = chosen(touches, &kept);
        let (_, _, cost) = normal(&last, &pose, &pose.matrix(), self.radius);
        // Without freedom the ratio is infinite or NaN, and is refused by `accepted`, which asks for at most.
        let freedom = last.iter().map(|t| t.hold.count).sum::<usize>().saturating_sub(6);
        // Counted at the limit at most, so that leaving a touch out is never better than keeping it.
        let offs = touches.iter().flatten().map(|t| t.counted(&pose).min(limit));
        let chi_squared = offs.map(|x| (x / options.sigma_mm).powi(2)).sum();
        Some(Found {
            assignment: assignment.to_vec(),
            pose,
            kept,
            chi_squared,
            noise_ratio: (cost / freedom as f64).sqrt() / options.sigma_mm,
        })
    }
}

/// Every feature keeps enough touches.
fn enough(assignment: &[Feature], kept: &[Vec<bool>]) -> Option<()> {
    let count = |wanted: &Feature| -> usize {
        let groups = assignment.iter().zip(kept).filter(|(f, _)| *f == wanted);
        groups.flat_map(|(_, k)| k).filter(|k| **k).count()
    };
    Feature::ALL.iter().all(|f| count(f) >= f.needed()).then_some(())
}

/// The touches that are kept.
pub(super) fn chosen(touches: &[Vec<HeldTouch>], kept: &[Vec<bool>]) -> Vec<HeldTouch> {
    let both = touches.iter().flatten().zip(kept.iter().flatten());
    both.filter(|(_, k)| **k).map(|(t, _)| *t).collect()
}

/// The rotation that takes the first direction to the first, and the second as near to the second as it can be.
fn aligned(from: [Vector3<f64>; 2], to: [Vector3<f64>; 2]) -> Option<Rotation> {
    let axes = |[a, b]: [Vector3<f64>; 2]| {
        // Parallel directions leave the turn about them free.
        let c = a.cross(&b).try_normalize(1e-9)?;
        Some(Matrix3::from_columns(&[a, c, a.cross(&c)]))
    };
    let turn = axes(to)? * axes(from)?.transpose();
    let rows = [0, 1, 2].map(|i| [0, 1, 2].map(|j| turn[(i, j)]));
    Some(RotationMatrix::new(rows, 1e-9).ok()?.rotation())
}
