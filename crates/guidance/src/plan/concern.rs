//! What speaks against a plan in the examination that it was made for.

use geometry::{Ct, Point, VolumeGrid};

use super::{Measure, Plan, Target, Trajectory};

/// As dense as this is bone, or a vessel full of contrast medium, HU.
pub const DENSE_HU: i16 = 250;
/// A way is looked at so often, mm: finer than the voxels of any examination of a body.
const STEP_MM: f64 = 0.25;

/// Two parts of a way through something dense are told apart where so much lies between them, mm.
const APART_MM: f64 = 2.0;

/// The HU at a point; `None` outside the examination.
pub type Hu<'a> = &'a dyn Fn(Point<Ct>) -> Option<i16>;

/// A point of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum What {
    /// A target's centre.
    Centre,
    /// A target's entry.
    Entry,
    /// A point of a distance or an angle.
    Measure,
}

impl What {
    const fn word(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Entry => "entry",
            Self::Measure => "measured point",
        }
    }
}

/// What speaks against a plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Concern {
    /// A point lies outside the examination.
    #[error("{name}: its {} {} lies outside the CT", what.word(), at.in_words(1))]
    Outside {
        /// The target's name, or the measure's place.
        name: String,
        /// Which of its points.
        what: What,
        /// Where.
        at: Point<Ct>,
    },
    /// Part of a target lies outside the examination.
    #[error("{name}: the CT ends {left_mm:.1} mm from its centre, within its radius of {radius_mm:.1} mm")]
    OnBorder {
        /// The target's name.
        name: String,
        /// From the centre to the border, mm.
        left_mm: f64,
        /// The target's radius, mm.
        radius_mm: f64,
    },
    /// The entry lies in something as dense as bone.
    #[error("{name}: its entry lies in {hu} HU, as dense as bone")]
    EntryInBone {
        /// The target's name.
        name: String,
        /// What was found there.
        hu: i16,
    },
    /// The tube's axis passes something as dense as bone.
    #[error("{name}: {hu} HU {from_mm:.1} to {to_mm:.1} mm deep: bone or contrast medium")]
    WayThroughBone {
        /// The target's name.
        name: String,
        /// Where that begins, mm from the entry.
        from_mm: f64,
        /// Where it ends last.
        to_mm: f64,
        /// The largest found.
        hu: i16,
    },
    /// A target has no entry: there is no way to be looked at.
    #[error("{name}: has no entry; its way is NOT CHECKED")]
    NoEntry {
        /// The target's name.
        name: String,
    },
}

/// What speaks against `plan`, target by target. `grid` and `hu` are those of its examination.
pub fn concerns(plan: &Plan, grid: &VolumeGrid, hu: Hu<'_>) -> Vec<Concern> {
    let mut found = Vec::new();
    for target in &plan.targets {
        outside(&target.name, What::Centre, &[target.centre], grid, &mut found);
        found.extend(on_border(target, grid));
        match target.entry {
            Some(entry) => {
                outside(&target.name, What::Entry, &[entry], grid, &mut found);
                found.extend(way(target, entry, hu));
            }
            None => found.push(Concern::NoEntry {
                name: target.name.clone(),
            }),
        }
    }
    for (place, measure) in plan.measures.iter().enumerate() {
        let name = match measure {
            Measure::Distance(_) => format!("distance {}", place + 1),
            Measure::Angle(_) => format!("angle {}", place + 1),
        };
        outside(&name, What::Measure, measure.points(), grid, &mut found);
    }
    found
}

fn outside(name: &str, what: What, points: &[Point<Ct>], grid: &VolumeGrid, found: &mut Vec<Concern>) {
    let those = points.iter().filter(|at| !grid.holds(**at));
    found.extend(those.map(|at| Concern::Outside {
        name: name.to_owned(),
        what,
        at: *at,
    }));
}

/// The distance to each face of the grid: a voxel's border is half a voxel beyond its centre.
fn on_border(target: &Target, grid: &VolumeGrid) -> Option<Concern> {
    if !grid.holds(target.centre) {
        return None;
    }
    let inverse = grid.voxel_from_ct();
    let [rows, place] = [
        inverse.rows(),
        (inverse * target.centre).mm().map(|x| [x, 0.0, 0.0, 0.0]),
    ];
    let left_mm = (0..3)
        .map(|axis| {
            // Planes of a constant index lie 1 / |gradient of the index| apart, also on a sheared grid.
            let [x, y, z, _] = rows[axis];
            let apart_mm = 1.0 / x.hypot(y).hypot(z);
            let index = place[axis][0];
            let left = (index + 0.5).min(f64::from(grid.dims()[axis]) - 0.5 - index);
            left * apart_mm
        })
        .fold(f64::INFINITY, f64::min);
    let radius_mm = target.diameter_mm / 2.0;
    (left_mm < radius_mm).then(|| Concern::OnBorder {
        name: target.name.clone(),
        left_mm,
        radius_mm,
    })
}

fn way(target: &Target, entry: Point<Ct>, hu: Hu<'_>) -> Vec<Concern> {
    let mut found = Vec::new();
    if let Some(hu) = hu(entry).filter(|hu| *hu >= DENSE_HU) {
        found.push(Concern::EntryInBone {
            name: target.name.clone(),
            hu,
        });
    }
    let Some(trajectory) = Trajectory::of(target) else {
        return found;
    };
    let steps = (trajectory.depth_mm / STEP_MM).ceil() as usize;
    // Where each part begins and ends, and the most that it has.
    let mut parts: Vec<([f64; 2], i16)> = Vec::new();
    let met = (0..=steps).filter_map(|step| {
        let depth_mm = (step as f64 * STEP_MM).min(trajectory.depth_mm);
        let hu = hu(trajectory.at(depth_mm)).filter(|hu| *hu >= DENSE_HU)?;
        Some((depth_mm, hu))
    });
    for (depth_mm, hu) in met {
        match parts.last_mut() {
            Some(([_, to_mm], most)) if depth_mm - *to_mm <= APART_MM => {
                (*to_mm, *most) = (depth_mm, hu.max(*most));
            }
            _ => parts.push(([depth_mm, depth_mm], hu)),
        }
    }
    found.extend(parts.into_iter().map(|([from_mm, to_mm], hu)| Concern::WayThroughBone {
        name: target.name.clone(),
        from_mm,
        to_mm,
        hu,
    }));
    found
}
