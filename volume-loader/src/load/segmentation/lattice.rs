//! Where the frames of a segmentation lie: planes at steps, some of which have frames of several segments, and some none.

use geometry::VolumeGrid;

use super::error::SegmentationError;
use super::object::Object;
use crate::dicom::error::FileError;
use crate::dicom::geometry::{CORNER_MAX_MM, GeometryError, Stack, UNEVEN_MM, UNEVEN_PART};
use crate::dicom::header::Placed;
use crate::dicom::tag as el;

/// So many places are told where no step leads from one to the next.
const TOLD: usize = 6;

/// The grid of the map, and which frames lie in each of its planes.
#[derive(Debug)]
pub(super) struct Lattice {
    pub grid: VolumeGrid,
    /// For each plane, its frames from 0.
    pub frames: Vec<Vec<usize>>,
    /// How far a frame's corner lies from where the grid puts it at most, mm.
    pub worst_corner_mm: f64,
}

/// Why frames make no grid.
#[derive(Debug)]
pub(super) enum LatticeError {
    Geometry(GeometryError),
    Grid(geometry::GridError),
    Step(SegmentationError),
    Element(FileError),
}

impl Lattice {
    pub(super) fn of(object: &Object) -> Result<Self, LatticeError> {
        let (planes, plane_of_frame) = distinct(object);
        let stack = Stack::of_planes(&planes).map_err(LatticeError::Geometry)?;
        let (step_mm, index) = steps(&stack.along_mm, stack.line.dot(stack.normal), object.step_mm)?;
        let along = |k: usize| index.get(k).map_or(0.0, |&at| at as f64 * step_mm);
        let (slice, worst_corner_mm) = stack.worst_corner([object.columns, object.rows], along);
        // Not a number is refused too.
        if worst_corner_mm.is_nan() || worst_corner_mm > CORNER_MAX_MM {
            let found_mm = worst_corner_mm;
            return Err(LatticeError::Geometry(GeometryError::Corner { slice, found_mm }));
        }
        let count = index.last().map_or(1, |last| last + 1);
        let dims = [i64::from(object.columns), i64::from(object.rows), count as i64];
        let grid = VolumeGrid::checked(dims, stack.ct_from_voxel(step_mm)).map_err(LatticeError::Grid)?;
        let mut place_of_plane = vec![0; planes.len()];
        for (&plane, &at) in stack.order.iter().zip(&index) {
            place_of_plane[plane] = at;
        }
        let mut frames = vec![Vec::new(); count];
        for (frame, &plane) in plane_of_frame.iter().enumerate() {
            frames[place_of_plane[plane]].push(frame);
        }
        Ok(Self {
            grid,
            frames,
            worst_corner_mm,
        })
    }
}

/// The places of the frames, each once, and which of them each frame has.
fn distinct(object: &Object) -> (Vec<Placed>, Vec<usize>) {
    let bits = |placed: &Placed| {
        let numbers = placed.position.iter().chain(&placed.orientation).chain(&placed.spacing);
        // 0 and -0 are one place.
        numbers.map(|number| (number + 0.0).to_bits()).collect::<Vec<_>>()
    };
    let (mut planes, mut known) = (Vec::new(), std::collections::BTreeMap::new());
    let of_frame = object.frames.iter().map(|frame| {
        *known.entry(bits(&frame.placed)).or_insert_with(|| {
            planes.push(frame.placed);
            planes.len() - 1
        })
    });
    let of_frame = of_frame.collect();
    (planes, of_frame)
}

/// The step of the grid along the line of the planes, mm, and which of its planes lies at each of these ascending places; `cosine` is that of
/// the angle between the line and the planes' normal.
///
/// Frames without a voxel of their segment may be left out, so that only some of the steps are there. The smallest must be the one that
/// the file states: of a file that states a finer one, planes may be missing between any two.
fn steps(along_mm: &[f64], cosine: f64, stated_mm: Option<f64>) -> Result<(f64, Vec<usize>), LatticeError> {
    let differences = || {
        along_mm
            .iter()
            .zip(along_mm.iter().skip(1))
            .map(|(low, high)| high - low)
    };
    let smallest = differences().fold(f64::INFINITY, f64::min);
    if along_mm.len() < 2 {
        let step = stated_mm.ok_or(FileError::Missing {
            tag: el::SPACING_BETWEEN_SLICES,
        });
        return Ok((step.map_err(LatticeError::Element)?, vec![0; along_mm.len()]));
    }
    let refused = || LatticeError::Step(no_step(along_mm, stated_mm));
    let is_smallest = |mm: f64| (mm - smallest).abs() <= UNEVEN_MM;
    let first = match stated_mm {
        // Of a tilted gantry the standard's step is along the normal, and some writers' along the line.
        Some(stated) => [stated, stated / cosine].into_iter().find(|mm| is_smallest(*mm)),
        // Two planes alone say nothing of those between.
        None if along_mm.len() == 2 => None,
        // The mean of those that are the smallest but for the digits that they were printed with.
        None => {
            let same: Vec<f64> = differences().filter(|mm| is_smallest(*mm)).collect();
            Some(same.iter().sum::<f64>() / same.len() as f64)
        }
    };
    let first = first.filter(|step| *step > 0.0).ok_or_else(refused)?;
    let mut index = vec![0];
    for difference in differences() {
        let count = (difference / first).round();
        let next = index.last().map_or(0.0, |last| *last as f64) + count;
        // A step of no length, or a plane so far off that no grid holds it; not a number is refused too.
        if !(count >= 1.0 && next <= f64::from(u16::MAX)) {
            return Err(refused());
        }
        index.push(next as usize);
    }
    let step = along_mm.last().unwrap_or(&0.0) / index.last().map_or(1.0, |last| *last as f64);
    let most = UNEVEN_MM.max(UNEVEN_PART * step);
    let is_off = |(mm, &at): (&f64, &usize)| (mm - at as f64 * step).abs() > most;
    match along_mm.iter().zip(&index).any(is_off) {
        true => Err(refused()),
        false => Ok((step, index)),
    }
}

fn no_step(along_mm: &[f64], stated_mm: Option<f64>) -> SegmentationError {
    let told: Vec<String> = along_mm.iter().take(TOLD).map(|mm| format!("{mm:.3}")).collect();
    let more = if along_mm.len() > TOLD { " .." } else { "" };
    SegmentationError::Step {
        places: format!("{}{more} mm", told.join(", ")),
        stated: match stated_mm {
            Some(step) => format!("SpacingBetweenSlices is {step} mm"),
            None => "SpacingBetweenSlices is not stated".to_owned(),
        },
    }
}
