//! The voxels about a place of the surface, each with its distance from the surface.

use nalgebra::{Matrix3, Vector3};

use crate::model::Place;
use crate::quadric::Quadric;
use crate::voxels::Crop;

/// A window outwards of fewer deviations of the blur than this tells no position: another bone is too near.
const LEAST_OUTSIDE: f64 = 1.3;
/// How much HU must rise again for another bone, or the other wall of this one, HU.
const RISE_HU: f64 = 120.0;
/// The least voxels of a patch.
const LEAST_VOXELS: usize = 10;
/// How far inwards a patch goes beyond three deviations of the blur, mm: the thickest cortex that is told.
const INSIDE_MM: f64 = 5.0;
/// And outwards: the threshold's surface lies outside the bone, never by more.
const OUTSIDE_MM: f64 = 1.0;

/// Why a place of the threshold's surface has no position of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lost {
    /// The CT ends there, or nothing was measured.
    End,
    /// The region, or another body, ends there: a joint that was cut.
    Cut,
    /// Another bone is too near.
    Other,
    /// Metal is near.
    Metal,
    /// The surface is too rough there, or too few voxels tell of it.
    Rough,
    /// The model does not fit what is there.
    Misfit,
    /// Its position is hardly known.
    Unsure,
    /// It lies off from those around it by more than their deviations.
    Stray,
    /// It is of a small piece among places that are lost.
    Island,
    /// Bone is nearly all around before it: the wall of a cavity that is open somewhere.
    Inner,
    /// It has no cortex: contrast medium explains what is there.
    Bare,
}

impl Lost {
    /// All, in order.
    pub const ALL: [Self; 11] = [
        Self::End,
        Self::Cut,
        Self::Other,
        Self::Metal,
        Self::Rough,
        Self::Misfit,
        Self::Unsure,
        Self::Stray,
        Self::Island,
        Self::Inner,
        Self::Bare,
    ];

    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::End => "the CT ends there, or measured nothing",
            Self::Cut => "the region ends there",
            Self::Other => "another bone is too near",
            Self::Metal => "metal is near",
            Self::Rough => "too rough",
            Self::Misfit => "the model does not fit",
            Self::Unsure => "the position is hardly known",
            Self::Stray => "off from its neighbours",
            Self::Island => "a small piece that stands alone",
            Self::Inner => "the wall of a cavity: bone nearly all around before it",
            Self::Bare => "no cortex: a vessel or an organ with contrast medium",
        }
    }
}

/// One voxel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Distance outwards from the smooth surface, mm.
    pub(crate) x: f64,
    pub(crate) hu: f64,
    /// Its say, 1 at the middle.
    pub(crate) weight: f64,
    /// Index in the part of the CT.
    pub(crate) index: [i32; 3],
}

/// The voxels about a place.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    pub(crate) place: Place,
    pub(crate) samples: Vec<Sample>,
    /// Outwards, of length 1.
    pub(crate) normal: Vector3<f64>,
    /// The share of the blur's variance along the normal that is of the slice's plane.
    pub(crate) plane_share: f64,
    /// Whether the window was cut short by something else.
    pub(crate) is_short: bool,
}

/// What patches are made with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// Radius about the normal, mm.
    pub(crate) radius_mm: f64,
    /// Voxels of this value and more are metal, HU.
    pub(crate) metal_hu: i16,
    /// Between two looks along the normal, mm.
    pub(crate) step_mm: f64,
}

/// The patch at a place; of a blur of these deviations in the slice's plane and along its normal, and of this kurtosis.
///
/// # Errors
/// Why there is none.
pub(crate) fn patch(
    crop: &Crop,
    quadric: &Quadric,
    blur: &Matrix3<f64>,
    ([plane, axial], kurtosis): ([f64; 2], f64),
    window: &Window,
) -> Result<Patch, Lost> {
    let n = quadric.normal;
    let variance = n.dot(&(blur * n));
    let s = variance.sqrt();
    let reach = [3.0 * s + INSIDE_MM, 3.0 * s + OUTSIDE_MM];
    let ([inside, outside], is_short) = cut(crop, quadric, reach, window)?;
    if outside < LEAST_OUTSIDE * s {
        let beyond = quadric.foot + n * (outside + window.step_mm);
        return Err(crop.linear(&beyond).map_or(Lost::End, |_| Lost::Other));
    }
    let bends = [0, 1].map(|k| {
        let axis = quadric.axes[k];
        [axis.dot(&(blur * axis)), quadric.curvature[k]]
    });
    let samples = gather(crop, quadric, [inside, outside], window)?;
    if samples.len() < LEAST_VOXELS {
        return Err(Lost::Rough);
    }
    let (plane, axial) = (plane * plane, axial * axial);
    // Of variance = plane (1 - z^2) + axial z^2, the first part's share.
    let along = if (plane - axial).abs() > 1e-9 {
        ((plane - variance) / (plane - axial)).clamp(0.0, 1.0)
    } else {
        1.0 / 3.0
    };
    Ok(Patch {
        place: Place {
            blur_mm: s,
            kurtosis,
            bends,
        },
        samples,
        normal: n,
        plane_share: plane * (1.0 - along) / variance,
        is_short,
    })
}

/// How far inwards and outwards the profile goes before it rises to something else, mm; and whether it does.
fn cut(crop: &Crop, quadric: &Quadric, reach: [f64; 2], window: &Window) -> Result<([f64; 2], bool), Lost> {
    let look = |x: f64| crop.linear(&(quadric.foot + quadric.normal * x));
    let Some(here) = look(0.0) else {
        return Err(Lost::End);
    };
    let step = window.step_mm;
    let mut ends = reach;
    let mut is_short = false;
    // Outwards: it falls, and must not rise again.
    let (mut least, mut at) = (here, 0.0);
    for i in 1..=(reach[1] / step).ceil() as usize {
        let x = i as f64 * step;
        let Some(hu) = look(x) else {
            ends[1] = ends[1].min(x - step);
            break;
        };
        if hu < least {
            (least, at) = (hu, x);
        }
        if hu > least + RISE_HU {
            ends[1] = ends[1].min(at);
            is_short = true;
            break;
        }
    }
    // Inwards: it rises to the cortex, may fall, and a second rise is the other wall.
    let (mut most, mut after, mut at) = (here, f64::INFINITY, 0.0);
    for i in 1..=(reach[0] / step).ceil() as usize {
        let x = i as f64 * step;
        let Some(hu) = look(-x) else {
            ends[0] = ends[0].min(x - step);
            break;
        };
        if hu > most {
            (most, after) = (hu, hu);
        }
        if hu < after {
            (after, at) = (hu, x);
        }
        if hu > after + RISE_HU {
            ends[0] = ends[0].min(at);
            is_short = true;
            break;
        }
    }
    Ok((ends, is_short))
}

fn gather(crop: &Crop, quadric: &Quadric, [inside, outside]: [f64; 2], window: &Window) -> Result<Vec<Sample>, Lost> {
    let radius = window.radius_mm;
    // On a bent surface the cylinder must be as much longer as the surface falls within it.
    let sag = quadric.curvature.iter().fold(0.0_f64, |m, k| m.max(k.abs())) * radius * radius;
    let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for corner in 0..8_u8 {
        let side = |bit: u8, value: [f64; 2]| value[usize::from(corner >> bit & 1)];
        let p = quadric.foot
            + quadric.normal * side(0, [-inside - sag, outside + sag])
            + quadric.axes[0] * side(1, [-radius, radius])
            + quadric.axes[1] * side(2, [-radius, radius]);
        let index = crop.index(&p);
        (low, high) = (low.inf(&index), high.sup(&index));
    }
    let first = [0, 1, 2].map(|k| low[k].ceil().max(0.0) as usize);
    let last = [0, 1, 2].map(|k| high[k].floor().min(crop.dims[k] as f64 - 1.0).max(-1.0) as i64);
    let mut samples = Vec::new();
    for z in first[2] as i64..=last[2] {
        for y in first[1] as i64..=last[1] {
            for x in first[0] as i64..=last[0] {
                let mm = crop.mm(Vector3::new(x as f64, y as f64, z as f64)) - quadric.foot;
                let (u, v) = (mm.dot(&quadric.axes[0]), mm.dot(&quadric.axes[1]));
                let beside = u * u + v * v;
                if beside > radius * radius {
                    continue;
                }
                let height = mm.dot(&quadric.normal);
                // Distance from a bent surface, of second order in what lies beside: of a ball it is height + u^2 / (2 (R + height)).
                let bent = |k: f64, u: f64| 0.5 * k * u * u / (1.0 + k * height).max(0.3);
                let distance = height + bent(quadric.curvature[0], u) + bent(quadric.curvature[1], v);
                if distance < -inside || distance > outside {
                    continue;
                }
                let offset = crop.offset([x, y, z].map(|i| i as usize));
                if crop.is_gap(offset) {
                    continue;
                }
                let hu = crop.hu[offset];
                if hu >= window.metal_hu {
                    return Err(Lost::Metal);
                }
                samples.push(Sample {
                    x: distance,
                    hu: f64::from(hu),
                    weight: (-0.5 * beside / (0.6 * radius).powi(2)).exp(),
                    index: [x, y, z].map(|i| i as i32),
                });
            }
        }
    }
    Ok(samples)
}
