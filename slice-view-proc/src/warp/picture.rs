//! Slices of organs where they lie now.

mod claims;

use geometry::SlicePlane;

use super::drawing::{Drawing, Tools};
use super::image::{Organ, Warped};
use super::resolve::Kinds;
use super::view::View;
use crate::reslice::{Vector, Work};

/// Organs in one image, at most.
const MOST_ORGANS: usize = 64;
/// Why there is no image.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoWarp {
    /// Too many organs.
    #[error("{0} organs; {MOST_ORGANS} are allowed")]
    Organs(usize),
    /// Places of another mesh.
    #[error("organ {organ}: places of {found} nodes; its mesh has {expected}")]
    Nodes {
        /// Its number, from 0.
        organ: usize,
        /// Places.
        found: usize,
        /// Nodes.
        expected: usize,
    },
    /// A node is at no place.
    #[error("organ {organ}: node {node} lies at {place:?} mm")]
    Place {
        /// Its number, from 0.
        organ: usize,
        /// The node.
        node: usize,
        /// Where.
        place: [f32; 3],
    },
    /// Pixels that are too small for the organ's pieces.
    #[error("organ {0}: a piece is larger than 131072 pixels")]
    Pixels(usize),
}

/// Draws organs where they lie now, one image after the other in the same memory.
#[derive(Debug, Clone, Default)]
pub struct Warp {
    tools: Tools,
    kinds: Kinds,
    found: Warped,
}

impl Warp {
    /// The places at rest of what the plane shows.
    ///
    /// # Errors
    /// [`NoWarp`]; then there is no image.
    pub fn draw(&mut self, plane: &SlicePlane, organs: &[Organ<'_>]) -> Result<&Warped, NoWarp> {
        self.draw_with(Vector::detect(), plane, organs)
    }

    /// With AVX2 or without: the same operations in the same order, so the same bits.
    fn draw_with(
        &mut self,
        vector: Option<Vector>,
        plane: &SlicePlane,
        organs: &[Organ<'_>],
    ) -> Result<&Warped, NoWarp> {
        for (number, organ) in organs.iter().enumerate() {
            check(number, organ)?;
        }
        if organs.len() > MOST_ORGANS {
            return Err(NoWarp::Organs(organs.len()));
        }
        let view = View::of(plane);
        let size = plane.size().map(|n| n as usize);
        self.kinds.begin(size);
        self.found.rest.resize(size[0] * size[1], [0.0; 3]);
        self.found.error_mm = 0.0;
        let mut drawn = Ok(());
        let work = Image {
            warp: self,
            view: &view,
            size,
            organs,
            drawn: &mut drawn,
        };
        Vector::work(vector, work);
        drawn.map(|()| &self.found)
    }
}

/// An image to be drawn.
struct Image<'a> {
    warp: &'a mut Warp,
    view: &'a View,
    size: [usize; 2],
    organs: &'a [Organ<'a>],
    drawn: &'a mut Result<(), NoWarp>,
}

impl Work for Image<'_> {
    #[inline(always)]
    fn work(mut self) {
        for (number, organ) in self.organs.iter().enumerate() {
            let drawn = self.organ(organ, number);
            let found = &mut self.warp.found;
            match drawn {
                Some(error_mm) => found.error_mm = found.error_mm.max(error_mm),
                None => {
                    *self.drawn = Err(NoWarp::Pixels(number));
                    return;
                }
            }
        }
        self.warp.found.finish(&mut self.warp.kinds, self.view, self.organs);
    }
}

impl Image<'_> {
    /// Draws an organ: its error, mm; none where pixels are too small, and then too the canvas is left empty.
    #[inline(always)]
    fn organ(&mut self, organ: &Organ<'_>, number: usize) -> Option<f64> {
        let Warp { tools, kinds, found } = &mut *self.warp;
        tools.canvas.begin(self.size);
        tools.lattice.begin(organ.shape);
        // The first is drawn where it stays.
        if number == 0 {
            std::mem::swap(&mut tools.canvas.rest, &mut found.rest);
        }
        let drawn = Drawing {
            view: self.view,
            organ,
            tools,
            stretch: 0.0,
        }
        .cubes();
        if drawn.is_some() {
            claims::settle(self.view, organ, &mut tools.canvas);
        }
        let places = (number > 0).then_some(&mut found.rest[..]);
        kinds.take(&mut tools.canvas, &organ.shape.region, number as u8, places);
        if number == 0 {
            std::mem::swap(&mut tools.canvas.rest, &mut found.rest);
        }
        drawn
    }
}

#[cfg(test)]
impl Warp {
    /// Without a cube drawn whole: the slow way, against which the other is held.
    pub(super) fn by_pieces() -> Self {
        let mut warp = Self::default();
        warp.tools.by_pieces = true;
        warp
    }

    /// Without AVX2.
    pub(super) fn draw_portably(&mut self, plane: &SlicePlane, organs: &[Organ<'_>]) -> Result<&Warped, NoWarp> {
        self.draw_with(None, plane, organs)
    }
}

fn check(number: usize, organ: &Organ<'_>) -> Result<(), NoWarp> {
    let [found, expected] = [organ.places.len(), organ.shape.nodes];
    if found != expected {
        return Err(NoWarp::Nodes {
            organ: number,
            found,
            expected,
        });
    }
    // First all at once, which takes a tenth of the time.
    let odd = organ.places.as_flattened().iter().filter(|x| !x.is_finite()).count();
    if odd == 0 {
        return Ok(());
    }
    let bad = organ
        .places
        .iter()
        .position(|place| !place.iter().all(|x| x.is_finite()));
    bad.map_or(Ok(()), |node| {
        Err(NoWarp::Place {
            organ: number,
            node,
            place: organ.places[node],
        })
    })
}
