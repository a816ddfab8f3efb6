//! Which bone is meant.

use nalgebra::Vector3;

use crate::component::Component;
use crate::components::Bodies;
use crate::error::Refused;
use crate::fill::{ball, dilated, for_each};
use crate::gaps::gaps;
use crate::voxels::{Crop, VoxelBox, Voxels};

/// Bodies of less are not listed, ml.
const LEAST_ML: f64 = 0.5;
/// Bodies that are listed.
const LISTED: usize = 12;
/// Around a seed bone is looked for so far, in the largest voxel step.
const SEED_STEPS: f64 = 1.5;

/// Whether a voxel of the CT, by column, row and slice, has a label.
pub type IsLabelled<'a> = &'a dyn Fn([u32; 3]) -> bool;

/// Which bone is meant.
pub enum Region<'a> {
    /// The only body above the threshold; where there are several the choice is refused with a list.
    Only,
    /// The body of this number of that list, from 1.
    Number(usize),
    /// The largest body within a box in the patient, mm.
    Box {
        /// Two opposite corners, mm (left, posterior, superior).
        corners_mm: [[f64; 3]; 2],
    },
    /// The body that holds this place, or comes within 1.5 voxels of it, mm.
    Seed {
        /// The place, mm (left, posterior, superior).
        mm: [f64; 3],
    },
    /// The largest body among the voxels that a label map calls so, and those within `grow_mm` of them.
    Labelled {
        /// Whether a voxel is labelled.
        is_in: IsLabelled<'a>,
        /// How much too small the labels may be, mm.
        grow_mm: f64,
    },
}

/// Half a space that the bone does not reach into: a joint that is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// A place on the plane, mm.
    pub place_mm: [f64; 3],
    /// Its normal, towards what is cut away.
    pub normal: [f64; 3],
}

impl Cut {
    /// Whether a place is cut away; what lies on the plane is, to a millionth of a mm.
    pub(crate) fn holds(&self, mm: &Vector3<f64>) -> bool {
        let normal = Vector3::from(self.normal);
        (mm - Vector3::from(self.place_mm)).dot(&normal) > -1e-6 * normal.norm()
    }
}

/// The body that was chosen: the part of the CT about it, and its voxels.
pub(crate) struct Chosen {
    pub(crate) crop: Crop,
    pub(crate) mask: Vec<u8>,
    pub(crate) body: Component,
    /// The largest of all, as listed.
    pub(crate) listed: Vec<Component>,
    /// Metal voxels about it.
    pub(crate) metal: u64,
}

/// What is bone.
#[derive(Clone, Copy)]
pub(crate) struct Levels {
    pub(crate) bone_hu: f64,
    pub(crate) metal_hu: i16,
}

/// Chooses a body.
pub(crate) fn choose(
    voxels: &dyn Voxels,
    region: &Region<'_>,
    cuts: &[Cut],
    excluded: IsLabelled<'_>,
    levels: Levels,
    margin_mm: f64,
) -> Result<Chosen, Refused> {
    let grid = voxels.grid();
    let place = match region {
        Region::Box { corners_mm } => box_of(voxels, corners_mm)?,
        Region::Labelled { is_in, grow_mm } => labelled_box(voxels, is_in, *grow_mm)?,
        Region::Seed { mm } => {
            let [x, y, z] = *mm;
            if !grid.holds(geometry::Point::new(x, y, z)) {
                return Err(outside(voxels));
            }
            VoxelBox::whole(grid)
        }
        Region::Only | Region::Number(_) => VoxelBox::whole(grid),
    };
    let crop = Crop::new(voxels, place);
    let allowed = allowed(&crop, region, cuts, excluded);
    let is_bone = |crop: &Crop, at: usize| {
        let hu = crop.hu[at];
        f64::from(hu) >= levels.bone_hu && hu < levels.metal_hu
    };
    let mut bodies = Bodies::new(&crop, |at| {
        is_bone(&crop, at) && allowed.as_ref().is_none_or(|a| a[at] == 1)
    })?;
    if bodies.list.is_empty() {
        // Of the region, not of the CT: what is kept out or cut away is not meant.
        let is_in = |at: &usize| allowed.as_ref().is_none_or(|a| a[*at] == 1) && crop.hu[*at] < levels.metal_hu;
        let brightest = (0..crop.hu.len()).filter(is_in).map(|at| crop.hu[at]).max();
        return Err(brightest.map_or(Refused::Empty, |brightest| Refused::NoBone {
            level: levels.bone_hu,
            metal: levels.metal_hu,
            brightest,
        }));
    }
    let count = bodies.list.iter().take_while(|body| body.volume_ml >= LEAST_ML).count();
    let listed: Vec<Component> = bodies.list[..count.max(1)].iter().take(LISTED).copied().collect();
    let number = match region {
        Region::Seed { mm } => seed(&crop, &mut bodies, *mm, levels)?,
        Region::Number(asked) if *asked == 0 || *asked > count => {
            return Err(Refused::NoComponent { asked: *asked, count });
        }
        Region::Number(asked) => asked - 1,
        Region::Only if count > 1 => return Err(Refused::Which { count, largest: listed }),
        _ => 0,
    };
    let mut chosen = cropped(voxels, &crop, &mut bodies, number, (listed, levels, margin_mm));
    if let Region::Labelled { is_in, .. } = region {
        add_marrow(&mut chosen, is_in, cuts, levels);
    }
    Ok(chosen)
}

/// The part of the CT about a body, with a margin for the profiles across its surface.
fn cropped(
    voxels: &dyn Voxels,
    whole: &Crop,
    bodies: &mut Bodies,
    number: usize,
    (listed, levels, margin_mm): (Vec<Component>, Levels, f64),
) -> Chosen {
    let body = bodies.list[number];
    let mut painted = vec![0; whole.hu.len()];
    bodies.paint(whole, number, &mut painted);
    let margin = [0, 1, 2].map(|k| (whole.index_from_mm.row(k).norm() * margin_mm).ceil() as u32);
    let mut crop = Crop::new(voxels, body.place.grown(margin, voxels.grid()));
    crop.gap = gaps(&crop, voxels.padding_hu());
    let mut mask = vec![0; crop.hu.len()];
    let (mut metal, mut at) = (0, 0);
    let first = [0, 1, 2].map(|k| i64::from(crop.place.first[k]) - i64::from(whole.place.first[k]));
    for z in 0..crop.dims[2] {
        for y in 0..crop.dims[1] {
            for x in 0..crop.dims[0] {
                let there = [x as i64 + first[0], y as i64 + first[1], z as i64 + first[2]];
                if (0..3).all(|k| there[k] >= 0 && there[k] < whole.dims[k] as i64) {
                    // Padding may be as bright as bone.
                    mask[at] = painted[whole.offset(there.map(|k| k as usize))] & u8::from(!crop.is_gap(at));
                }
                metal += u64::from(crop.hu[at] >= levels.metal_hu);
                at += 1;
            }
        }
    }
    Chosen {
        crop,
        mask,
        body,
        listed,
        metal,
    }
}

/// What the label map says is bone, and is more than 1.7 voxels within, is bone though it be dark: marrow.
fn add_marrow(chosen: &mut Chosen, is_in: IsLabelled<'_>, cuts: &[Cut], levels: Levels) {
    let crop = &chosen.crop;
    let mut labelled = vec![0; crop.hu.len()];
    for_each(crop, |offset, [x, y, z]| {
        let first = crop.place.first;
        labelled[offset] = u8::from(is_in([x as u32 + first[0], y as u32 + first[1], z as u32 + first[2]]));
    });
    let step = (0..3).map(|k| crop.steps.column(k).norm()).fold(0.0, f64::max);
    // Labels are wrong by a voxel: at their rim the HU say what is bone.
    let rim = dilated(crop, &labelled, 0, &ball(crop, 1.7 * step));
    for_each(crop, |offset, place| {
        let mm = crop.mm(Vector3::from(place.map(|k| k as f64)));
        let is_cut = cuts.iter().any(|cut| cut.holds(&mm));
        if rim[offset] == 0 && crop.hu[offset] < levels.metal_hu && !is_cut {
            chosen.mask[offset] = 1;
        }
    });
}

fn outside(voxels: &dyn Voxels) -> Refused {
    let (from, to) = voxels.grid().bounds();
    Refused::Outside {
        from: from.mm(),
        to: to.mm(),
    }
}

/// The voxels whose centres may lie in a box of the patient.
fn box_of(voxels: &dyn Voxels, corners: &[[f64; 3]; 2]) -> Result<VoxelBox, Refused> {
    let grid = voxels.grid();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for corner in 0..8_usize {
        let p = [0, 1, 2].map(|k| corners[corner >> k & 1][k]);
        let index = (grid.voxel_from_ct() * geometry::Point::new(p[0], p[1], p[2])).mm();
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(index[k]), high[k].max(index[k]));
        }
    }
    let dims = grid.dims().map(f64::from);
    // A NaN meets nothing.
    let meets = (0..3).all(|k| low[k] <= dims[k] - 1.0 && high[k] >= 0.0);
    if !meets {
        return Err(outside(voxels));
    }
    Ok(VoxelBox {
        first: [0, 1, 2].map(|k| low[k].ceil().clamp(0.0, dims[k] - 1.0) as u32),
        end: [0, 1, 2].map(|k| (high[k].floor().clamp(0.0, dims[k] - 1.0) + 1.0) as u32),
    })
}

fn labelled_box(voxels: &dyn Voxels, is_in: IsLabelled<'_>, grow_mm: f64) -> Result<VoxelBox, Refused> {
    let grid = voxels.grid();
    let dims = grid.dims();
    let (mut first, mut end) = (dims, [0; 3]);
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                if is_in([x, y, z]) {
                    first = [first[0].min(x), first[1].min(y), first[2].min(z)];
                    end = [end[0].max(x + 1), end[1].max(y + 1), end[2].max(z + 1)];
                }
            }
        }
    }
    if end[0] == 0 {
        return Err(outside(voxels));
    }
    let spacing = grid.spacing_mm();
    // More than enough of a sheared grid too, whose rows are nearer than its steps are long.
    let grow = [0, 1, 2].map(|k| (6.0 * grow_mm / spacing[k]).ceil() as u32);
    Ok(VoxelBox { first, end }.grown(grow, grid))
}

/// Voxels that may belong to the bone; `None` for all.
fn allowed(crop: &Crop, region: &Region<'_>, cuts: &[Cut], excluded: IsLabelled<'_>) -> Option<Vec<u8>> {
    let at = |[x, y, z]: [usize; 3]| [x, y, z].map(|k| k as u32);
    let in_ct = |place: [usize; 3]| {
        let [x, y, z] = at(place);
        [
            x + crop.place.first[0],
            y + crop.place.first[1],
            z + crop.place.first[2],
        ]
    };
    let mut mask = match region {
        Region::Labelled { is_in, grow_mm } => {
            let mut labelled = vec![0; crop.hu.len()];
            for_each(crop, |offset, place| labelled[offset] = u8::from(is_in(in_ct(place))));
            dilated(crop, &labelled, 1, &ball(crop, *grow_mm))
        }
        Region::Box { corners_mm: [a, b] } => {
            let mut within = vec![0; crop.hu.len()];
            for_each(crop, |offset, place| {
                let mm = crop.mm(Vector3::from(place.map(|k| k as f64)));
                within[offset] = u8::from((0..3).all(|k| mm[k] >= a[k].min(b[k]) && mm[k] <= a[k].max(b[k])));
            });
            within
        }
        _ => vec![1; crop.hu.len()],
    };
    for_each(crop, |offset, place| {
        if mask[offset] == 0 {
            return;
        }
        let mm = crop.mm(Vector3::from(place.map(|k| k as f64)));
        let is_cut = cuts.iter().any(|cut| cut.holds(&mm));
        if is_cut || excluded(in_ct(place)) {
            mask[offset] = 0;
        }
    });
    Some(mask)
}

fn seed(crop: &Crop, bodies: &mut Bodies, mm: [f64; 3], levels: Levels) -> Result<usize, Refused> {
    let reach = SEED_STEPS * (0..3).map(|k| crop.steps.column(k).norm()).fold(0.0, f64::max);
    let middle = crop.index(&Vector3::from(mm)).map(f64::round);
    let mut steps = ball(crop, reach);
    let length = |s: &[i32; 3]| (crop.steps * Vector3::from(s.map(f64::from))).norm();
    steps.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let mut brightest = i16::MIN;
    for step in steps {
        let place = [0, 1, 2].map(|k| middle[k] + f64::from(step[k]));
        if (0..3).any(|k| place[k] < 0.0 || place[k] >= crop.dims[k] as f64) {
            continue;
        }
        let place = place.map(|k| k as usize);
        brightest = brightest.max(crop.hu[crop.offset(place)]);
        if let Some(body) = bodies.body_at(crop, place) {
            return Ok(body);
        }
    }
    Err(Refused::Seed {
        seed: mm,
        within: reach,
        brightest,
        level: levels.bone_hu,
    })
}
