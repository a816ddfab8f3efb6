//! What surfaces are of: bone, by its HU, and the structures of a label map.

use geometry::VolumeGrid;

use crate::average::{Average, MOST_SAMPLES};
use crate::nets::{Lattice, extract};
use crate::{MOST_TRIANGLES, Mesh, SurfaceError};

/// How many paints there are: 0 is bone, the others come round for structures.
pub const PAINTS: usize = 7;

/// Voxels that are read slice by slice.
pub struct Field<'a> {
    /// Where they lie in the patient.
    pub grid: &'a VolumeGrid,
    /// Writes slice z row by row.
    pub read: &'a mut dyn FnMut(u32, &mut [i16]),
}

/// The surface of all that has `level_hu` or more; none of it gives an empty mesh.
///
/// # Errors
/// [`SurfaceError::TooMany`].
pub fn bone(field: &mut Field<'_>, level_hu: f64) -> Result<Mesh, SurfaceError> {
    let (average, mut slice) = ready(field);
    let block = average.0.iter().product::<u32>() as f32;
    let mut sums: Vec<i32> = Vec::new();
    extract(&lattice(field, average, level_hu as f32), |z, values, _| {
        sums.clear();
        sums.resize(values.len(), 0);
        average.each(field.grid, z, &mut slice, &mut *field.read, |at, hu| {
            sums[at] += i32::from(hu)
        });
        for (value, sum) in values.iter_mut().zip(&sums) {
            *value = *sum as f32 / block;
        }
        Ok(())
    })
}

/// The surface of all that has a label, each part in the paint of its label. Where structures touch there is none between them: it would
/// not be seen. So it takes the same work and memory for two labels as for thousands.
///
/// # Errors
/// Each variant of [`SurfaceError`].
pub fn structures(field: &mut Field<'_>) -> Result<Mesh, SurfaceError> {
    let (average, mut slice) = ready(field);
    let block = average.0.iter().product::<u32>() as f32;
    let mut labels: Vec<i16> = Vec::new();
    // A block is inside where half of it is.
    extract(&lattice(field, average, 0.5), |z, values, paints| {
        values.fill(0.0);
        labels.clear();
        labels.resize(values.len(), 0);
        let mut negative = None;
        average.each(field.grid, z, &mut slice, &mut *field.read, |at, label| {
            negative = negative.or((label < 0).then_some(label));
            if label > 0 {
                values[at] += 1.0 / block;
                // Of several the first gives the paint.
                labels[at] = if labels[at] == 0 { label } else { labels[at] };
            }
        });
        for (paint, label) in paints.iter_mut().zip(&labels) {
            *paint = paint_of(*label);
        }
        negative.map_or(Ok(()), |label| Err(SurfaceError::Negative(label)))
    })
}

/// The paint of a label; 0 where there is none.
fn paint_of(label: i16) -> u8 {
    match usize::try_from(label) {
        Ok(label) if label > 0 => ((label - 1) % (PAINTS - 1) + 1) as u8,
        _ => 0,
    }
}

fn ready(field: &Field<'_>) -> (Average, Vec<i16>) {
    let [columns, rows, _] = field.grid.dims();
    let slice = vec![0; columns as usize * rows as usize];
    (Average::of(field.grid, MOST_SAMPLES), slice)
}

fn lattice(field: &Field<'_>, average: Average, level: f32) -> Lattice {
    Lattice {
        dims: average.dims(field.grid),
        ct_from_sample: average.ct_from_sample(field.grid),
        level,
        most: MOST_TRIANGLES,
    }
}
