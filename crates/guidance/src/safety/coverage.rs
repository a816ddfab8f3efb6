//! Where along its way a tube lies within the field of a label map.

use geometry::{Vector, VolumeGrid};

use super::tube::Tube;

/// How much of a tube the label map's field holds. Of the rest nothing is known: it is NOT CHECKED, and never free.
///
/// The field is the cells of all voxels. At depth `t` the tube is inside where its whole disc of radius `r` is; as the field is
/// convex, that is so from one depth to another, and then of all of the tube between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    /// From which depth to which the tube lies in the field, mm; `None` where no disc of it does.
    pub inside_mm: Option<[f64; 2]>,
    /// The tube's length, mm.
    pub length_mm: f64,
    /// From the tube to the nearest place outside the field, mm: of structures beyond it nothing is known. Below zero by how far the
    /// tube reaches out of the field.
    pub margin_mm: f64,
}

impl Coverage {
    /// Whether the whole tube lies in the field.
    pub fn is_whole(&self) -> bool {
        self.inside_mm == Some([0.0, self.length_mm])
    }

    /// Whether the whole tube between two depths, mm, lies in the field.
    pub fn holds(&self, from_mm: f64, to_mm: f64) -> bool {
        self.inside_mm.is_some_and(|[from, to]| from <= from_mm && to_mm <= to)
    }

    /// How near the field ends beside a tube that lies in it, mm, where that is nearer than the predicted error: the tube may leave it.
    pub fn nearer_than(&self, predicted_error_mm: Option<f64>) -> Option<f64> {
        let error = predicted_error_mm?;
        (0.0..error).contains(&self.margin_mm).then_some(self.margin_mm)
    }

    /// From which depth to which the tube is outside, mm: none, one or two parts, from the entry on.
    pub fn outside_mm(&self) -> Vec<[f64; 2]> {
        let Some([from, to]) = self.inside_mm else {
            return vec![[0.0, self.length_mm]];
        };
        let parts = [[0.0, from], [to, self.length_mm]];
        parts.into_iter().filter(|[a, b]| a < b).collect()
    }

    /// Of a tube in the field of a map on this grid.
    pub(super) fn of(tube: &Tube, grid: &VolumeGrid) -> Self {
        let (length, rows) = (tube.length_mm(), grid.voxel_from_ct().rows());
        let entry = (grid.voxel_from_ct() * tube.entry()).mm();
        let axis = tube.axis();
        let (mut from, mut to, mut margin) = (0.0_f64, length, f64::INFINITY);
        for k in 0..3 {
            // The index along this axis grows by this vector, whose length is one over the distance of two layers of voxels.
            let across = Vector::new(rows[k][0], rows[k][1], rows[k][2]);
            let per_mm = across.norm();
            let slope = across.dot(axis.vector()) / per_mm;
            // How far the edge of a disc stands out towards the face: by the sine, of which a vector product loses no digits.
            let edge = tube.radius_mm() * across.cross(axis.vector()).norm() / per_mm;
            let last = f64::from(grid.dims()[k]) - 0.5;
            for (at_entry, slope) in [(entry[k] + 0.5, slope), (last - entry[k], -slope)] {
                // The edge of the disc at depth t lies `inside + slope t` within the face.
                let inside = at_entry / per_mm - edge;
                margin = margin.min(inside.min(inside + slope * length));
                let crosses = -inside / slope;
                if slope > 0.0 {
                    from = from.max(crosses);
                } else if slope < 0.0 {
                    to = to.min(crosses);
                } else if inside < 0.0 {
                    to = f64::NEG_INFINITY;
                }
            }
        }
        Self {
            inside_mm: (from <= to).then_some([from, to]),
            length_mm: length,
            margin_mm: margin,
        }
    }
}
